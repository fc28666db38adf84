//! Bounds of torque, speed and brakes: step 3 with its guard, the downhill limiter. Beside them the torque of constant
//! speed.

use super::settings::{BoundKeys, Brakes, Keys, PlannerKind};
use law::{Input, PlanRequest, Powertrain};
use truck_model::{Demand, GEARS, Motion as TruckMotion, Truck};

/// Largest torque of an engine that is no broken report, N m.
const BELIEVABLE_NM: f64 = 1e7;
/// Guard of the lower bound (step 3): torque above holding, N m, and more per m/s below.
const GUARD_NM: f64 = 200.0;
const GUARD_NM_PER_MPS: f64 = 400.0;
/// Limiter downhill: deceleration per speed above the limit, 1/s.
const GAIN_PER_S: f64 = 0.5;
/// Distance below the limit at which it begins to act, m/s.
const MARGIN_MPS: f64 = 0.1;

/// The powertrain; without a report the gear that the speed suggests, and the map's grade.
pub(super) fn powertrain(truck: &Truck, input: &Input, map_grade: Option<f64>) -> Powertrain {
    let reported = input.powertrain.filter(|powertrain| {
        powertrain.gear < GEARS
            && powertrain.engine_torque_nm.abs() < BELIEVABLE_NM
            && powertrain.grade.abs() < 1.0
    });
    reported.unwrap_or_else(|| {
        let motion = TruckMotion::new(truck, 0.0, input.ego.speed_mps, 0.0);
        Powertrain {
            gear: motion.gear,
            since_shift_s: motion.since_shift_s,
            engine_torque_nm: motion.engine_torque_nm,
            grade: map_grade.unwrap_or(0.0),
        }
    })
}

/// A truck at a moment: what its engine gives, and what the road asks for.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    pub truck: &'a Truck,
    pub speed_mps: f64,
    pub gear: usize,
    pub grade: f64,
}

impl Moment<'_> {
    /// Engine torque for an acceleration, N m, without limits.
    fn giving_nm(&self, acceleration_mps2: f64) -> f64 {
        self.truck.engine_torque_nm(acceleration_mps2, self.speed_mps, self.gear, self.grade)
    }

    /// Engine, engine brake and service brakes for an acceleration.
    pub(super) fn demand(&self, acceleration_mps2: f64) -> Demand {
        let Self { truck, speed_mps, gear, grade } = *self;
        Demand::for_acceleration(truck, acceleration_mps2, speed_mps, gear, grade)
    }

    /// Engine torques of drag and of full load, N m.
    pub(super) fn engine_nm(&self) -> (f64, f64) {
        let (rpm, engine) = (self.truck.engine_rpm(self.speed_mps, self.gear), self.truck.engine());
        (engine.drag_torque_nm(rpm), engine.max_torque_nm(rpm))
    }

    /// Least and largest engine torque of a plan, N m: T_min and T_max.
    pub(super) fn limits_nm(&self, keys: &BoundKeys) -> (f64, f64) {
        let (drag_nm, full_nm) = self.engine_nm();
        (keys.drag_share * drag_nm, keys.full_load_share * full_nm)
    }

    /// The same within the bounds of acceleration, N m.
    ///
    /// These give way where the engine cannot keep them, on a slope that is too steep.
    pub(super) fn bounds_nm(&self, keys: &BoundKeys) -> (f64, f64) {
        let (low_nm, high_nm) = self.limits_nm(keys);
        let low_nm = low_nm.max(self.giving_nm(keys.min_acceleration_mps2)).min(high_nm);
        (low_nm, high_nm.min(self.giving_nm(keys.max_acceleration_mps2)).max(low_nm))
    }

    /// Torque of the plan within the bounds of step 3, N m.
    pub(super) fn guarded_nm(&self, keys: &Keys, input: &Input, planned_nm: f64) -> f64 {
        let hold_nm = self.giving_nm(0.0);
        let (low_nm, high_nm) = self.bounds_nm(&keys.bounds);
        let slow_mps = min_speed_mps(&keys.bounds, input.set_speed_mps) - self.speed_mps;
        let mut torque_nm = planned_nm;
        if keys.planner == PlannerKind::PaperN2 && slow_mps > 0.0 {
            let scale = self.truck.parameters().engine_scale;
            torque_nm = torque_nm.max(hold_nm + scale * (GUARD_NM + GUARD_NM_PER_MPS * slow_mps));
        }
        let most_mps = max_speed_mps(&keys.bounds, input.set_speed_mps, input.speed_limit_mps);
        if self.speed_mps > most_mps {
            torque_nm = torque_nm.min(hold_nm);
        }
        torque_nm.clamp(low_nm, high_nm)
    }

    /// The demand without the brakes that the law may not use.
    pub(super) fn permitted(&self, mut demand: Demand, brakes: Brakes) -> Demand {
        if brakes != Brakes::Service {
            demand.service_brake_n = 0.0;
        }
        if brakes == Brakes::None {
            demand.engine_torque_nm = demand.engine_torque_nm.max(self.engine_nm().0);
        }
        demand
    }

    /// The downhill speed limiter: engine brake, then service brakes, when a truck runs away. Returns `demand`, but no
    /// more than holds the truck at `limit_mps` once it is there.
    pub fn limited(&self, demand: Demand, limit_mps: f64) -> Demand {
        if self.speed_mps < limit_mps - MARGIN_MPS {
            return demand;
        }
        let holding = self.demand(GAIN_PER_S * (limit_mps - self.speed_mps));
        Demand {
            engine_torque_nm: demand.engine_torque_nm.min(holding.engine_torque_nm),
            service_brake_n: demand.service_brake_n.max(holding.service_brake_n),
            gear: demand.gear,
        }
    }
}

/// Lowest and highest speed of a plan, m/s: 13 km/h below and 5 km/h above the set speed, if nothing else is set, and
/// within the limit. The lowest one counts where the truck can hold it.
pub fn speed_band_mps(keys: &BoundKeys, request: &PlanRequest) -> (f64, f64) {
    let max_mps = max_speed_mps(keys, request.set_speed_mps, request.speed_limit_mps);
    (min_speed_mps(keys, request.set_speed_mps).min(max_mps), max_mps)
}

/// Highest speed that is planned, m/s.
pub fn max_speed_mps(keys: &BoundKeys, set_speed_mps: f64, speed_limit_mps: f64) -> f64 {
    (set_speed_mps + keys.above_set_kmh / 3.6).min(speed_limit_mps)
}

/// Lowest speed that is planned where the truck can hold it, m/s.
pub fn min_speed_mps(keys: &BoundKeys, set_speed_mps: f64) -> f64 {
    set_speed_mps - keys.below_set_kmh / 3.6
}

/// Proportional gain of the generic engine, N m per m/s.
const PROPORTIONAL: f64 = 1500.0;
/// Integral gain, N m per m.
const INTEGRAL: f64 = 40.0;

/// Constant speed: PI control of torque, with the resistance of the road under the truck fed forward.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpeedKeeper {
    integral_nm: f64,
}

impl SpeedKeeper {
    /// Engine torque between drag and full load, N m, for the next `dt_s`.
    pub fn torque_nm(&mut self, at: &Moment<'_>, set_mps: f64, dt_s: f64) -> f64 {
        let (low_nm, high_nm) = at.engine_nm();
        let scale = at.truck.parameters().engine_scale;
        let error_mps = set_mps - at.speed_mps;
        let torque_nm = at.giving_nm(0.0) + scale * PROPORTIONAL * error_mps + self.integral_nm;
        if (low_nm..high_nm).contains(&torque_nm) {
            self.integral_nm += scale * INTEGRAL * error_mps * dt_s;
        }
        torque_nm.clamp(low_nm, high_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truck_model::{GEARS, Preset};

    const TOP: usize = GEARS - 1;
    const SPEED_MPS: f64 = 75.0 / 3.6;

    #[test]
    fn accelerations_bound_the_torque_where_the_engine_can() {
        let truck = Truck::preset(Preset::Jh6At25T);
        let keys = BoundKeys {
            min_acceleration_mps2: -0.1,
            max_acceleration_mps2: 0.05,
            ..BoundKeys::default()
        };
        let at = |grade| Moment { truck: &truck, speed_mps: SPEED_MPS, gear: TOP, grade };
        let bounds = |grade| at(grade).bounds_nm(&keys);
        let giving_nm = |mps2| truck.engine_torque_nm(mps2, SPEED_MPS, TOP, 0.0);
        assert_eq!(bounds(0.0), (giving_nm(-0.1), giving_nm(0.05)));
        let (drag_nm, full_nm) = at(0.0).limits_nm(&keys);
        assert_eq!(bounds(-0.1), (drag_nm, drag_nm), "it runs away: drag");
        assert_eq!(bounds(0.1), (full_nm, full_nm), "it falls back: full load");
    }

    #[test]
    fn shares_are_those_of_drag_and_full_load() {
        let truck = Truck::preset(Preset::Jh6At49T);
        let keys = BoundKeys { drag_share: 0.0, full_load_share: 0.5, ..BoundKeys::default() };
        let full_nm = truck.engine().max_torque_nm(truck.engine_rpm(SPEED_MPS, TOP));
        let at = Moment { truck: &truck, speed_mps: SPEED_MPS, gear: TOP, grade: 0.0 };
        assert_eq!(at.limits_nm(&keys), (0.0, 0.5 * full_nm));
    }
}
