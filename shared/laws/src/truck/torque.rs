//! Engine torques: those that a plan may have (step 3), that of constant speed, and the downhill limiter.

use super::settings::BoundKeys;
use truck_model::{Demand, Truck};

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
