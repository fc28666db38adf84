//! Shift rule of the automated gearbox.
//!
//! ```text
//! (7) down   T > 0.93 T_max  and  n < 1040 rpm
//!     up     n_up > 1060 rpm  and  T_up < 0.97 T_max(n_up),   or  n_up > 1350 rpm,   or  n > 1900 rpm
//! ```
//!
//! T is the torque at the gearbox, after the auxiliaries. n_up and T_up are speed and torque after
//! the shift. At least six seconds lie between two shifts; each interrupts the traction for one
//! second.
//!
//! The published rule does not cover very low engine speeds. Here, below 800 rpm the gearbox shifts
//! at once to the highest gear with at least 1000 rpm. It does not wait for the six seconds.

use crate::parameters::GEARS;
use crate::truck::Truck;

/// Smallest time between two shifts \[s\].
pub const MIN_BETWEEN_SHIFTS_S: f64 = 6.0;
/// Time without traction in a shift \[s\].
pub const TRACTION_INTERRUPTION_S: f64 = 1.0;

/// Engine speed below which the engine labours and the gearbox shifts at once \[rpm\].
const LABOURING_RPM: f64 = 800.0;
/// Smallest engine speed after a shift that relieves the engine \[rpm\].
const RELIEVED_RPM: f64 = 1000.0;
/// Highest engine speed that a shift may lead to \[rpm\].
const OVERSPEED_RPM: f64 = 2000.0;

impl Truck {
    /// Returns the gear of rule (7), at most one away from `gear`; further only to relieve a
    /// labouring engine.
    ///
    /// `gear` counts from 0, the lowest. `net_torque_nm` is the requested torque at the gearbox,
    /// `since_shift_s` the time since the last shift began.
    pub fn gear_by_rule(
        &self,
        speed_mps: f64,
        gear: usize,
        net_torque_nm: f64,
        since_shift_s: f64,
    ) -> usize {
        let rpm = self.engine_rpm(speed_mps, gear);
        if rpm < LABOURING_RPM && gear > 0 {
            let relieves = |gear: &usize| self.engine_rpm(speed_mps, *gear) >= RELIEVED_RPM;
            return (0..gear).rev().find(relieves).unwrap_or(0);
        }
        if since_shift_s < MIN_BETWEEN_SHIFTS_S {
            return gear;
        }
        let (_, max_nm) = self.net_torque_limits_nm(speed_mps, gear);
        if gear > 0 && net_torque_nm > 0.93 * max_nm && rpm < 1040.0 {
            return gear - 1;
        }
        if gear + 1 < GEARS && self.shifts_up(speed_mps, gear, net_torque_nm, rpm) {
            return gear + 1;
        }
        gear
    }

    /// Returns whether `gear` may be engaged at this speed: the engine neither labours nor
    /// overspeeds.
    pub fn gear_allowed(&self, speed_mps: f64, gear: usize) -> bool {
        let rpm = self.engine_rpm(speed_mps, gear);
        gear < GEARS && rpm < OVERSPEED_RPM && (rpm >= LABOURING_RPM || gear == 0)
    }

    fn shifts_up(&self, speed_mps: f64, gear: usize, net_torque_nm: f64, rpm: f64) -> bool {
        let ratios = &self.parameters().gear_ratios;
        let up_rpm = self.engine_rpm(speed_mps, gear + 1);
        let up_torque_nm = net_torque_nm * ratios[gear] / ratios[gear + 1];
        let (_, up_max_nm) = self.net_torque_limits_nm(speed_mps, gear + 1);
        (up_rpm > 1060.0 && up_torque_nm < 0.97 * up_max_nm) || up_rpm > 1350.0 || rpm > 1900.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    const TOP: usize = GEARS - 1;

    fn truck() -> Truck {
        Truck::preset(Preset::Jh6At49T)
    }

    #[test]
    fn a_hill_asks_for_the_gear_below_and_the_top_of_it_for_the_gear_above() {
        let truck = truck();
        let slow_mps = 19.0;
        assert!(truck.engine_rpm(slow_mps, TOP) < 1040.0);
        assert_eq!(truck.gear_by_rule(slow_mps, TOP, 2100.0, 10.0), TOP - 1);
        assert_eq!(truck.gear_by_rule(20.8, TOP - 1, 600.0, 10.0), TOP);
    }

    #[test]
    fn six_seconds_lie_between_shifts() {
        assert_eq!(truck().gear_by_rule(19.0, TOP, 2100.0, 5.9), TOP);
    }

    #[test]
    fn a_labouring_engine_is_relieved_at_once() {
        let truck = truck();
        let speed_mps = 8.0;
        let gear = truck.gear_by_rule(speed_mps, TOP, -100.0, 0.0);
        assert!(gear < TOP - 1);
        assert!(truck.engine_rpm(speed_mps, gear) >= RELIEVED_RPM);
        assert_eq!(truck.gear_by_rule(0.0, TOP, 0.0, 0.0), 0);
    }

    #[test]
    fn it_starts_and_goes_up_through_all_gears() {
        let truck = truck();
        let mut gear = 0;
        for step in 0..900 {
            gear = truck.gear_by_rule(f64::from(step) * 0.025, gear, 500.0, 10.0);
        }
        assert_eq!(gear, TOP);
    }
}
