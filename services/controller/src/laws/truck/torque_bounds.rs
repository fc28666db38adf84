//! The torques that a plan may have: step 3.

use super::settings::BoundKeys;
use truck_model::Truck;

/// Least and largest net torque at a speed on a grade, N m.
///
/// The bounds of acceleration give way where the engine cannot keep them, on a slope that is too steep.
pub(crate) fn net_torque_bounds_nm(
    keys: &BoundKeys,
    truck: &Truck,
    speed_mps: f64,
    gear: usize,
    grade: f64,
) -> (f64, f64) {
    let (low_nm, high_nm) = net_torque_limits_nm(keys, truck, speed_mps, gear);
    let resistance_n = truck.resistance_n(speed_mps, grade);
    let giving_nm =
        |mps2: f64| truck.net_torque_nm(resistance_n + truck.inertial_mass_kg() * mps2, gear);
    let low_nm = low_nm.max(giving_nm(keys.min_acceleration_mps2)).min(high_nm);
    (low_nm, high_nm.min(giving_nm(keys.max_acceleration_mps2)).max(low_nm))
}

/// Least and largest net torque at a speed, N m: T_min and T_max less what the auxiliaries take.
pub(crate) fn net_torque_limits_nm(
    keys: &BoundKeys,
    truck: &Truck,
    speed_mps: f64,
    gear: usize,
) -> (f64, f64) {
    let (drag_nm, full_nm) = truck.net_torque_limits_nm(speed_mps, gear);
    let rpm = truck.engine_rpm(speed_mps, gear);
    let engine = truck.engine();
    (
        drag_nm - (1.0 - keys.drag_share) * engine.drag_torque_nm(rpm),
        full_nm - (1.0 - keys.full_load_share) * engine.max_torque_nm(rpm),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use truck_model::{GEARS, Preset};

    const TOP: usize = GEARS - 1;

    /// Acceleration that a net torque gives on a grade at 75 km/h, m/s².
    fn acceleration_mps2(truck: &Truck, net_nm: f64, grade: f64) -> f64 {
        let force_n = truck.force_n(net_nm, TOP) - truck.resistance_n(75.0 / 3.6, grade);
        force_n / truck.inertial_mass_kg()
    }

    #[test]
    fn accelerations_bound_the_torque_where_the_engine_can() {
        let truck = Truck::preset(Preset::Jh6At25T);
        let keys = BoundKeys {
            min_acceleration_mps2: -0.1,
            max_acceleration_mps2: 0.05,
            ..BoundKeys::default()
        };
        let bounds = |grade| net_torque_bounds_nm(&keys, &truck, 75.0 / 3.6, TOP, grade);
        let (low_nm, high_nm) = bounds(0.0);
        assert!((acceleration_mps2(&truck, low_nm, 0.0) + 0.1).abs() < 1e-12);
        assert!((acceleration_mps2(&truck, high_nm, 0.0) - 0.05).abs() < 1e-12);
        let (drag_nm, full_nm) = truck.net_torque_limits_nm(75.0 / 3.6, TOP);
        assert_eq!(bounds(-0.1), (drag_nm, drag_nm), "it runs away: drag");
        assert_eq!(bounds(0.1), (full_nm, full_nm), "it falls back: full load");
    }

    #[test]
    fn shares_take_from_drag_and_full_load_of_the_engine() {
        let truck = Truck::preset(Preset::Jh6At49T);
        let keys = BoundKeys { drag_share: 0.0, full_load_share: 0.5, ..BoundKeys::default() };
        let (low_nm, high_nm) = net_torque_limits_nm(&keys, &truck, 75.0 / 3.6, TOP);
        let rpm = truck.engine_rpm(75.0 / 3.6, TOP);
        let auxiliary_nm = truck.auxiliary_torque_nm(rpm);
        assert!((low_nm + auxiliary_nm).abs() < 1e-9, "no engine torque: {low_nm}");
        let half_nm = 0.5 * truck.engine().max_torque_nm(rpm);
        assert!((high_nm + auxiliary_nm - half_nm).abs() < 1e-9, "{high_nm}");
    }
}
