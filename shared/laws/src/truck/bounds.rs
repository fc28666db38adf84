//! Bounds of input, torque, speed and brakes: plausible inputs, step 3 with its guard, the downhill limiter. Beside them
//! the torque of constant speed.

use super::settings::{BoundKeys, Brakes, PlannerKind, Settings};
use law::{Input, PlanRequest, Powertrain};
use truck_model::{Demand, GEARS, Motion as TruckMotion, Truck};

/// Largest believable values of an input.
const BELIEVABLE: f64 = 1e7;
const BELIEVABLE_MPS: f64 = 100.0;
/// Guard of the lower bound (step 3): torque above holding, N m, and more per m/s below.
const GUARD_NM: f64 = 200.0;
const GUARD_NM_PER_MPS: f64 = 400.0;

/// The powertrain; without a report the gear that the speed suggests, and the map's grade.
pub(super) fn powertrain(settings: &Settings, input: &Input, map_grade: Option<f64>) -> Powertrain {
    let reported = input.powertrain.filter(|powertrain| {
        powertrain.gear < GEARS
            && powertrain.engine_torque_nm.abs() < BELIEVABLE
            && powertrain.grade.abs() < 1.0
    });
    reported.unwrap_or_else(|| {
        let motion = TruckMotion::new(&settings.truck, 0.0, input.ego.speed_mps, 0.0);
        Powertrain {
            gear: motion.gear,
            since_shift_s: motion.since_shift_s,
            engine_torque_nm: motion.engine_torque_nm,
            grade: map_grade.unwrap_or(0.0),
        }
    })
}

/// Torque of the plan within the bounds of step 3, N m.
pub(super) fn guarded_nm(
    settings: &Settings,
    input: &Input,
    powertrain: &Powertrain,
    planned_nm: f64,
) -> f64 {
    let truck = &settings.truck;
    let (speed_mps, gear) = (input.ego.speed_mps, powertrain.gear);
    let scale = truck.parameters().engine_scale;
    let hold_nm = truck.engine_torque_nm(0.0, speed_mps, gear, powertrain.grade);
    let bounds = &settings.keys.bounds;
    let (low_nm, high_nm) = torque_bounds_nm(bounds, truck, speed_mps, gear, powertrain.grade);
    let slow_mps = min_speed_mps(bounds, input.set_speed_mps) - speed_mps;
    let mut torque_nm = planned_nm;
    if settings.keys.planner == PlannerKind::PaperN2 && slow_mps > 0.0 {
        torque_nm = torque_nm.max(hold_nm + scale * (GUARD_NM + GUARD_NM_PER_MPS * slow_mps));
    }
    if speed_mps > max_speed_mps(bounds, input.set_speed_mps, input.speed_limit_mps) {
        torque_nm = torque_nm.min(hold_nm);
    }
    torque_nm.clamp(low_nm, high_nm)
}

/// The demand without the brakes that the law may not use.
pub(super) fn permitted(
    settings: &Settings,
    mut demand: Demand,
    speed_mps: f64,
    gear: usize,
) -> Demand {
    let truck = &settings.truck;
    let brakes = settings.keys.brakes;
    if brakes != Brakes::Service {
        demand.service_brake_n = 0.0;
    }
    if brakes == Brakes::None {
        let drag_nm = truck.engine().drag_torque_nm(truck.engine_rpm(speed_mps, gear));
        demand.engine_torque_nm = demand.engine_torque_nm.max(drag_nm);
    }
    demand
}

/// True if the numbers can be those of a truck on a road.
pub(super) fn believable(input: &Input) -> bool {
    let ego = &input.ego;
    input.time_s.abs() < BELIEVABLE
        && (1e-4..10.0).contains(&input.period_s)
        && ego.position_m.abs() < BELIEVABLE
        && (0.0..BELIEVABLE_MPS).contains(&ego.speed_mps)
        && ego.acceleration_mps2.abs() < BELIEVABLE_MPS
        && (0.0..BELIEVABLE_MPS).contains(&input.set_speed_mps)
        && input.speed_limit_mps > 0.0
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

/// Least and largest engine torque at a speed on a grade, N m.
///
/// The bounds of acceleration give way where the engine cannot keep them, on a slope that is too steep.
pub(crate) fn torque_bounds_nm(
    keys: &BoundKeys,
    truck: &Truck,
    speed_mps: f64,
    gear: usize,
    grade: f64,
) -> (f64, f64) {
    let (low_nm, high_nm) = torque_limits_nm(keys, truck, speed_mps, gear);
    let giving_nm = |mps2: f64| truck.engine_torque_nm(mps2, speed_mps, gear, grade);
    let low_nm = low_nm.max(giving_nm(keys.min_acceleration_mps2)).min(high_nm);
    (low_nm, high_nm.min(giving_nm(keys.max_acceleration_mps2)).max(low_nm))
}

/// Least and largest engine torque at a speed, N m: T_min and T_max.
pub(crate) fn torque_limits_nm(
    keys: &BoundKeys,
    truck: &Truck,
    speed_mps: f64,
    gear: usize,
) -> (f64, f64) {
    let (rpm, engine) = (truck.engine_rpm(speed_mps, gear), truck.engine());
    (keys.drag_share * engine.drag_torque_nm(rpm), keys.full_load_share * engine.max_torque_nm(rpm))
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
    pub fn torque_nm(
        &mut self,
        truck: &Truck,
        (set_mps, speed_mps): (f64, f64),
        gear: usize,
        grade: f64,
        dt_s: f64,
    ) -> f64 {
        let rpm = truck.engine_rpm(speed_mps, gear);
        let (low_nm, high_nm) =
            (truck.engine().drag_torque_nm(rpm), truck.engine().max_torque_nm(rpm));
        let scale = truck.parameters().engine_scale;
        let error_mps = set_mps - speed_mps;
        let hold_nm = truck.engine_torque_nm(0.0, speed_mps, gear, grade);
        let torque_nm = hold_nm + scale * PROPORTIONAL * error_mps + self.integral_nm;
        if (low_nm..high_nm).contains(&torque_nm) {
            self.integral_nm += scale * INTEGRAL * error_mps * dt_s;
        }
        torque_nm.clamp(low_nm, high_nm)
    }
}

/// Deceleration per speed above the limit, 1/s.
const GAIN_PER_S: f64 = 0.5;
/// Distance below the limit at which it begins to act, m/s.
const MARGIN_MPS: f64 = 0.1;

/// The downhill speed limiter: engine brake, then service brakes, when a truck runs away. Returns `demand`, but no more than holds the truck at `limit_mps` once it is there.
pub fn limited(
    truck: &Truck,
    demand: Demand,
    speed_mps: f64,
    gear: usize,
    grade: f64,
    limit_mps: f64,
) -> Demand {
    if speed_mps < limit_mps - MARGIN_MPS {
        return demand;
    }
    let acceleration_mps2 = GAIN_PER_S * (limit_mps - speed_mps);
    let holding = Demand::for_acceleration(truck, acceleration_mps2, speed_mps, gear, grade);
    Demand {
        engine_torque_nm: demand.engine_torque_nm.min(holding.engine_torque_nm),
        service_brake_n: demand.service_brake_n.max(holding.service_brake_n),
        gear: demand.gear,
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
        let bounds = |grade| torque_bounds_nm(&keys, &truck, SPEED_MPS, TOP, grade);
        let giving_nm = |mps2| truck.engine_torque_nm(mps2, SPEED_MPS, TOP, 0.0);
        assert_eq!(bounds(0.0), (giving_nm(-0.1), giving_nm(0.05)));
        let (drag_nm, full_nm) = torque_limits_nm(&keys, &truck, SPEED_MPS, TOP);
        assert_eq!(bounds(-0.1), (drag_nm, drag_nm), "it runs away: drag");
        assert_eq!(bounds(0.1), (full_nm, full_nm), "it falls back: full load");
    }

    #[test]
    fn shares_are_those_of_drag_and_full_load() {
        let truck = Truck::preset(Preset::Jh6At49T);
        let keys = BoundKeys { drag_share: 0.0, full_load_share: 0.5, ..BoundKeys::default() };
        let full_nm = truck.engine().max_torque_nm(truck.engine_rpm(SPEED_MPS, TOP));
        assert_eq!(torque_limits_nm(&keys, &truck, SPEED_MPS, TOP), (0.0, 0.5 * full_nm));
    }
}
