//! The clock of a roadside unit on another host, in the vehicle's run time.
//!
//! ```
//! use v2x_sim::unit_clock::UnitClock;
//!
//! // The unit started at 103 s of its clock, which is 3 s ahead; the vehicle started at 110 s of its own.
//! let clock = UnitClock::new(103_000_000_000, 3_000_000_000, 110_000_000_000);
//! assert_eq!(clock.unit_ns(5_000_000_000), 15_000_000_000);
//! ```

/// Lead of another unit's run time over the vehicle's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitClock {
    ahead_ns: i64,
}

impl UnitClock {
    /// The clock of a unit in the vehicle's own group.
    pub const OWN: Self = Self { ahead_ns: 0 };

    /// A unit whose wall clock showed `start_ns` at its run time 0 and is `offset_ns` ahead of the vehicle's clock.
    /// The vehicle's clock showed `vehicle_start_ns` at its run time 0. All ns.
    pub fn new(start_ns: i64, offset_ns: i64, vehicle_start_ns: i64) -> Self {
        Self { ahead_ns: vehicle_start_ns.saturating_add(offset_ns).saturating_sub(start_ns) }
    }

    /// The unit's run time at a run time of the vehicle, both ns; 0 before the unit started.
    pub fn unit_ns(&self, vehicle_ns: u64) -> u64 {
        vehicle_ns.saturating_add_signed(self.ahead_ns)
    }

    /// The vehicle's run time at a run time of the unit.
    pub fn vehicle_ns(&self, unit_ns: u64) -> u64 {
        unit_ns.saturating_add_signed(-self.ahead_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roadside_unit::RoadsideUnit;
    use scenario::{Scenario, builtin};

    const SECOND: i64 = 1_000_000_000;

    /// The unit started 10 s before the vehicle, by clocks that are 3 s apart.
    #[test]
    fn a_signal_shows_the_same_by_both_clocks() {
        let clock = UnitClock::new(103 * SECOND, 3 * SECOND, 110 * SECOND);
        assert_eq!(clock.unit_ns(5_000_000_000), 15_000_000_000);
        let text = builtin::find("corridor").expect("it is built in").text;
        let unit = RoadsideUnit::new(&Scenario::parse("corridor", text).expect("right").v2x);
        let shown = unit.truth(&clock, 5_000_000_000, 0.0);
        assert_eq!(shown.signals[0].intervals[0].likely_end_s, 17.0);
    }

    #[test]
    fn a_unit_that_starts_later_has_not_begun() {
        let clock = UnitClock::new(20 * SECOND, 0, 10 * SECOND);
        assert_eq!((clock.unit_ns(0), clock.unit_ns(11_000_000_000)), (0, 1_000_000_000));
    }
}
