//! End of a run whose ego is clear of all others.

use crate::longitudinal::State;
use messages::AllVehicles;
use scenario::Scenario;

/// Watches for the end of a run whose verdict cannot change any more.
///
/// A contact needs a distance that shrinks. It does not shrink while the ego is no faster than a vehicle ahead and no
/// slower than one behind. Only an ego that turns to the other vehicle again could change that. So the state has to
/// last for a while first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClearWatch {
    after_ns: i64,
    for_ns: i64,
    ego_length_m: f64,
    /// Length of the longest of the others, m: the ground truth does not have it.
    longest_m: f64,
    since_ns: Option<i64>,
}

impl ClearWatch {
    pub(crate) fn of(scenario: &Scenario) -> Option<Self> {
        let asked = scenario.referee.ends_when_clear?;
        let lengths = scenario.actors.iter().map(|actor| actor.length_m.value());
        Some(Self {
            after_ns: asked.after_s.nanoseconds() as i64,
            for_ns: asked.for_s.nanoseconds() as i64,
            ego_length_m: scenario.plant.length_m.value(),
            longest_m: lengths.fold(0.0, f64::max),
            since_ns: None,
        })
    }

    /// Looks at the release of `now_ns`; true when the ego has been clear for long enough.
    pub(crate) fn observe(&mut self, now_ns: i64, ego: &State, others: &AllVehicles) -> bool {
        if now_ns < self.after_ns || !self.is_clear(now_ns, ego, others) {
            self.since_ns = None;
            return false;
        }
        now_ns - *self.since_ns.get_or_insert(now_ns) >= self.for_ns
    }

    fn is_clear(&self, now_ns: i64, ego: &State, others: &AllVehicles) -> bool {
        let age_s = (now_ns - others.header.acquisition_ns) as f64 * 1e-9;
        others.vehicles.iter().all(|other| {
            let ahead_m = other.rear_position_m + other.speed_mps * age_s - ego.position_m;
            if ahead_m > 0.0 {
                ego.speed_mps <= other.speed_mps
            } else {
                ahead_m < -(self.ego_length_m + self.longest_m) && other.speed_mps <= ego.speed_mps
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::VehicleTruthItem;

    fn watch() -> ClearWatch {
        let text = "schema_version = 1\nname = \"x\"\n[plant]\nlength_m = 4\n\
                    [referee]\nends_when_clear = { after_s = 1, for_s = 0.5 }\n\
                    [[actors]]\nname = \"a\"\ngap_m = 9\nlength_m = 5\ninitial_speed_mps = 10\n";
        let scenario = Scenario::parse("x", text).unwrap_or_else(|error| panic!("{error}"));
        ClearWatch::of(&scenario).expect("it is asked for")
    }

    /// First time at which the watch ends the run of an ego at 20 m/s, asked every 100 ms, ms. The other vehicle is
    /// `ahead_m` ahead at `other_mps`.
    fn ends_after(ahead_m: f64, other_mps: impl Fn(f64) -> f64) -> Option<i64> {
        let mut watch = watch();
        (0..50).map(|k| 100 * k).find(|ms| {
            let mut others = AllVehicles::with_room(1);
            others.vehicles.push(VehicleTruthItem::zeroed());
            others.header.acquisition_ns = ms * 1_000_000;
            others.vehicles[0].rear_position_m = ahead_m;
            others.vehicles[0].speed_mps = other_mps(*ms as f64 * 1e-3);
            let ego = State { position_m: 0.0, speed_mps: 20.0, acceleration_mps2: 0.0 };
            watch.observe(ms * 1_000_000, &ego, &others)
        })
    }

    #[test]
    fn it_ends_when_no_other_has_come_nearer_for_the_time_asked_for() {
        assert_eq!(ends_after(20.0, |_| 20.0), Some(1_500), "not before what is in store is over");
        assert_eq!(ends_after(20.0, |_| 19.9), None, "it comes nearer");
        let dips = |s: f64| if (1.3..1.35).contains(&s) { 19.0 } else { 21.0 };
        assert_eq!(ends_after(20.0, dips), Some(1_900), "anew after each break");
    }

    #[test]
    fn a_vehicle_beside_may_still_touch_and_one_that_was_passed_may_not_catch_up() {
        assert_eq!(ends_after(-8.9, |_| 0.0), None, "it may be as long as the longest");
        assert_eq!(ends_after(-9.1, |_| 10.0), Some(1_500));
        assert_eq!(ends_after(-9.1, |_| 21.0), None);
    }

    #[test]
    fn the_others_are_moved_on_from_their_sample() {
        // Sampled 0.5 s ago at 7 m behind the ego's rear and its own length. Now it is 4 m beside it, or 10 m behind.
        for (other_mps, clear) in [(10.0, false), (-6.0, true)] {
            let mut others = AllVehicles::with_room(1);
            others.vehicles.push(VehicleTruthItem::zeroed());
            others.header.acquisition_ns = 1_500_000_000;
            others.vehicles[0].rear_position_m = -7.0;
            others.vehicles[0].speed_mps = other_mps;
            let ego = State { position_m: 0.0, speed_mps: 20.0, acceleration_mps2: 0.0 };
            assert_eq!(watch().is_clear(2_000_000_000, &ego, &others), clear, "{other_mps}");
        }
    }
}
