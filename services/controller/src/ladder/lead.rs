//! The lead since it was last seen.
//!
//! A lead can be lost in two ways. No track arrives at all, or tracks arrive and the lead's is not among them. A lead
//! that left the lane is not a lost lead. Its track is still in the list, outside the path.
//!
//! A lost lead is assumed to go on as it did. It keeps its speed, or brakes as hard as it braked:
//!
//! ```text
//! p(t) = p + v t - b t²/2,   v(t) = v - b t,   until v(t) = 0
//! ```
//!
//! A tracker can lose a lead to a false detection. It then begins a new track at the lead's true place. The new track
//! shows itself by its past: two vehicles were never at one place. See [`LeadMemory::was_at_the_place_of`].

use crate::law::following::safe_gap::LeadNow;
use crate::law::{Ego, Input, Target};
use messages::Track;

/// Time for which a lead that disappeared from the tracks is assumed to be there, s. Chosen: a tracker needs up to 2 s
/// to confirm a vehicle again. One second more costs 1 s of a free road.
pub(super) const HOLD_S: f64 = 3.0;
/// Time for which a lead must have been the target before its loss counts, s. Chosen: false tracks live shorter.
const SEEN_FOR_S: f64 = 1.0;
/// A lead matters within this time headway, s, and distance, m. Chosen: beyond, a lead that brakes with 4 m/s² leaves
/// time to see it again.
const MATTERS: (f64, f64) = (3.0, 10.0);
/// A target this much farther than the lost lead is another vehicle, m.
const BEYOND_M: f64 = 5.0;
/// Braking of a vehicle on a dry road, m/s². More is an error of the estimate.
const HARDEST_MPS2: f64 = 10.0;
/// Age of the memory that a new target's past is compared with, s, to twice as much. Chosen: a tracker goes on with a
/// false detection for less.
const EARLIER_S: f64 = 1.0;
/// Length of a short car, m: two rears on one lane are never closer.
const SHORTEST_M: f64 = 3.5;
/// Slower braking than this is noise of the estimate, m/s².
const NOISE_MPS2: f64 = 0.3;

/// A target as it was when it was last seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastSeen {
    pub target: Target,
    /// Place of its rear, m.
    pub position_m: f64,
    pub speed_mps: f64,
    pub time_s: f64,
    /// Time since when it has been the target, s.
    pub since_s: f64,
}

impl LastSeen {
    fn new(input: &Input, target: Target, before: Option<&Self>) -> Self {
        let same = before.filter(|before| before.target.track_id == target.track_id);
        Self {
            target,
            position_m: input.ego.position_m + target.gap_m,
            speed_mps: (input.ego.speed_mps + target.relative_speed_mps).max(0.0),
            time_s: input.time_s,
            since_s: same.map_or(input.time_s, |before| before.since_s),
        }
    }

    /// Deceleration when it was last seen, m/s².
    pub(super) fn braking_mps2(&self) -> f64 {
        let braking = (-self.target.acceleration_mps2).min(HARDEST_MPS2);
        if braking > NOISE_MPS2 { braking } else { 0.0 }
    }

    /// The target as it is assumed to be now.
    pub(super) fn at(&self, ego: &Ego, time_s: f64) -> Target {
        let (age_s, braking) = (time_s - self.time_s, self.braking_mps2());
        let lead = LeadNow {
            gap_m: self.position_m - ego.position_m,
            speed_mps: self.speed_mps,
            acceleration_mps2: -braking,
        };
        let speed_mps = (self.speed_mps - braking * age_s).max(0.0);
        Target {
            gap_m: lead.position_m(braking, age_s),
            relative_speed_mps: speed_mps - ego.speed_mps,
            acceleration_mps2: if speed_mps > 0.0 { -braking } else { 0.0 },
            age_s: self.target.age_s + age_s,
            ..self.target
        }
    }

    /// True while the loss of this lead asks for caution.
    fn is_missed(&self, input: &Input) -> bool {
        let (headway_s, distance_m) = MATTERS;
        input.time_s - self.time_s <= HOLD_S
            && self.time_s - self.since_s >= SEEN_FOR_S
            && self.target.gap_m <= headway_s * input.ego.speed_mps + distance_m
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct LeadMemory {
    last: Option<LastSeen>,
    /// The same lead up to [`EARLIER_S`] before the last, and as long again before that.
    recent: Option<LastSeen>,
    earlier: Option<LastSeen>,
    /// True if the newest fresh sample misses the lead.
    pub(super) is_missed: bool,
}

impl LeadMemory {
    /// Takes the target of a fresh sample with the tracks beside it. Returns the target that the law is given.
    pub(super) fn see(&mut self, input: &Input, tracks: &[Track]) -> Option<Target> {
        let lost = self.last.filter(|last| {
            tracks.iter().all(|track| track.id != last.target.track_id) && last.is_missed(input)
        });
        let assumed = lost.map(|last| last.at(&input.ego, input.time_s));
        self.is_missed = assumed.is_some_and(|lost| {
            input.target.is_none_or(|seen| {
                seen.gap_m > lost.gap_m + BEYOND_M && !self.was_at_the_place_of(input, &seen)
            })
        });
        if self.is_missed {
            return assumed;
        }
        let last = input.target.map(|target| LastSeen::new(input, target, self.last.as_ref()));
        self.remember(last);
        input.target
    }

    /// True if the lead was where `seen` has come from: `seen` is the lead, under another number.
    fn was_at_the_place_of(&self, input: &Input, seen: &Target) -> bool {
        self.earlier.is_some_and(|lead| {
            let speed_mps = input.ego.speed_mps + seen.relative_speed_mps;
            let now_m = input.ego.position_m + seen.gap_m;
            let then_m = now_m - speed_mps * (input.time_s - lead.time_s);
            (then_m - lead.position_m).abs() < SHORTEST_M
        })
    }

    /// Takes the lead as it is now seen.
    fn remember(&mut self, last: Option<LastSeen>) {
        let is_same =
            self.last.zip(last).is_some_and(|(a, b)| a.target.track_id == b.target.track_id);
        self.last = last;
        if !is_same {
            (self.recent, self.earlier) = (last, last);
        } else if self
            .recent
            .zip(last)
            .is_some_and(|(then, now)| now.time_s - then.time_s >= EARLIER_S)
        {
            (self.earlier, self.recent) = (self.recent, last);
        }
    }

    /// The lead as it was last seen.
    pub(super) fn last(&self) -> Option<&LastSeen> {
        self.last.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(time_s: f64, target: Option<Target>) -> Input {
        let ego = Ego { position_m: 20.0 * time_s, speed_mps: 20.0, acceleration_mps2: 0.0 };
        Input { time_s, period_s: 0.1, ego, target, ..Input::default() }
    }

    fn lead(track_id: u32, gap_m: f64, acceleration_mps2: f64) -> Option<Target> {
        Some(Target { track_id, gap_m, acceleration_mps2, ..Target::default() })
    }

    fn listed(id: u32) -> Track {
        Track { id, in_path: 0, range_m: 40.0, range_rate_mps: 0.0, azimuth_rad: 0.0 }
    }

    /// Memory of a lead at `gap_m` that was seen from 0 to `until_s`.
    fn seen(until_s: f64, gap_m: f64, acceleration_mps2: f64) -> LeadMemory {
        let mut memory = LeadMemory::default();
        for time_s in [0.0, until_s] {
            memory.see(&input(time_s, lead(1, gap_m, acceleration_mps2)), &[listed(1)]);
        }
        memory
    }

    #[test]
    fn a_lead_that_disappears_is_assumed_to_go_on_until_its_time_is_over() {
        let mut memory = seen(2.0, 30.0, -4.0);
        let assumed = memory.see(&input(3.0, None), &[]).expect("it is missed");
        assert!(memory.is_missed);
        // 20 m/s of both; the lead lost 2 m and 4 m/s in a second.
        assert!((assumed.gap_m - 28.0).abs() < 1e-9);
        assert_eq!((assumed.relative_speed_mps, assumed.acceleration_mps2), (-4.0, -4.0));
        assert!(memory.see(&input(2.0 + HOLD_S, None), &[]).is_some());
        assert_eq!(memory.see(&input(2.1 + HOLD_S, None), &[]), None);
        assert!(!memory.is_missed);
    }

    #[test]
    fn a_lead_that_left_the_lane_is_not_missed() {
        let mut memory = seen(2.0, 30.0, 0.0);
        assert_eq!(memory.see(&input(2.1, None), &[listed(1)]), None);
        assert_eq!(memory.see(&input(2.2, None), &[]), None, "it was let go before");
    }

    #[test]
    fn a_vehicle_seen_shortly_or_far_away_is_not_missed() {
        assert_eq!(seen(0.9, 30.0, 0.0).see(&input(1.0, None), &[]), None);
        assert_eq!(seen(2.0, 71.0, 0.0).see(&input(2.1, None), &[]), None);
        assert!(seen(2.0, 69.0, 0.0).see(&input(2.1, None), &[]).is_some());
    }

    #[test]
    fn a_target_beyond_the_lost_lead_does_not_take_its_place_and_one_at_its_place_does() {
        let mut memory = seen(2.0, 30.0, 0.0);
        let beyond = memory.see(&input(2.1, lead(2, 36.0, 0.0)), &[listed(2)]);
        assert_eq!(beyond.map(|target| target.track_id), Some(1));
        let near = memory.see(&input(2.2, lead(3, 33.0, 0.0)), &[listed(3)]);
        assert_eq!(near.map(|target| target.track_id), Some(3));
        assert!(!memory.is_missed);
    }

    #[test]
    fn a_new_track_that_comes_from_the_leads_place_is_the_lead() {
        // A false detection took the track: it brakes far too hard and disappears. The lead drives on at 30 m.
        for (gap_m, relative_mps, is_lead) in
            [(30.0, 0.0, true), (28.0, -1.0, true), (36.0, 0.0, false), (36.0, 3.0, true)]
        {
            let mut memory = LeadMemory::default();
            for k in 0..=20 {
                memory.see(&input(0.1 * f64::from(k), lead(1, 30.0, 0.0)), &[listed(1)]);
            }
            memory.see(&input(2.4, lead(1, 22.0, -14.0)), &[listed(1), listed(2)]);
            let target = Target {
                track_id: 2,
                gap_m,
                relative_speed_mps: relative_mps,
                ..Target::default()
            };
            let seen = memory.see(&input(2.5, Some(target)), &[listed(2)]).expect("a target");
            assert_eq!(seen.track_id == 2, is_lead, "{gap_m} {relative_mps}");
            assert_eq!(memory.is_missed, !is_lead);
        }
    }

    #[test]
    fn no_lead_is_assumed_to_brake_harder_than_tyres_can() {
        let last = *seen(2.0, 40.0, -15.0).last().expect("seen");
        assert_eq!(last.braking_mps2(), HARDEST_MPS2);
    }

    #[test]
    fn a_lead_that_braked_to_a_standstill_stays_there() {
        let last = *seen(2.0, 40.0, -5.0).last().expect("seen");
        let stopped = last.at(&input(11.0, None).ego, 11.0);
        assert!((stopped.gap_m - (40.0 + 40.0 - 180.0)).abs() < 1e-9, "{stopped:?}");
        assert_eq!((stopped.acceleration_mps2, stopped.relative_speed_mps), (0.0, -20.0));
        let noise = *seen(2.0, 40.0, -0.2).last().expect("seen");
        assert_eq!(noise.at(&input(3.0, None).ego, 3.0).acceleration_mps2, 0.0);
    }
}
