//! Bounds on requests while the road ahead is not seen and for a while after, and behind a vehicle that starts.
//!
//! | situation | largest request, m/s² |
//! |---|---|
//! | blind, and a lead was lost | 0 |
//! | blind on a free road | 0.3 |
//! | sees again, for as long as it was blind, up to 5 s | 0.3 |
//! | then | rises with 2.5 m/s³ |
//! | the radar sees next to nothing, and the ego is faster than that allows | -2 |
//!
//! A radar with reduced sight bounds the set speed. From this speed the ego stops within the distance at which the
//! radar still finds a vehicle in time.
//!
//! The radar estimates its own sight, with noise. Worse sight counts at once, better sight when it has lasted for 5 s.
//! Otherwise, near a threshold, the set speed would change several times a second.
//!
//! A radar that is blind half of the time is so never accelerated on. While blind, the set speed is at most
//! the speed at which the ego became blind. So the laws do not work against the bound.

use crate::law::Input;
use messages::Sight;

/// Largest request while blind, m/s². Chosen: gains 1 m/s until the lead counts as lost.
const BLIND_MPS2: f64 = 0.3;
/// Longest time for which sight must prove itself, s. Chosen: longer losses end in braking, not in caution.
const LONGEST_S: f64 = 5.0;
/// Largest set speed while the radar sees a part of what it should, m/s. Chosen: stops within 100 m, half of its range,
/// with 4 m/s² after 1.5 s.
const LIMITED_MPS: f64 = 22.0;
/// Largest set speed while the radar sees next to nothing, m/s. Chosen: stops within 20 m in the same way.
const BLIND_MPS: f64 = 8.0;
/// Rise of the bound when sight has proved itself, m/s³: the least jerk limit of ISO 15622.
const RISE_MPS3: f64 = 2.5;
/// Largest request while the radar sees next to nothing and the ego is faster than [`BLIND_MPS`], m/s². Chosen:
/// comfortable braking, as for a lead that was lost.
const SLOWS_MPS2: f64 = -2.0;
/// Jerk with which that begins, m/s³.
const SLOWS_JERK_MPS3: f64 = 2.5;
/// Bound that no law reaches, m/s².
const FREE_MPS2: f64 = 10.0;

/// The bounds at one release.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caution {
    /// Time for which sight has to prove itself, s.
    proof_s: f64,
    /// Largest request, m/s².
    most_mps2: f64,
    /// Speed at which the ego became blind, m/s.
    blind_from_mps: Option<f64>,
    /// Bound that slows down what is too fast for a blind radar, m/s².
    slows_mps2: Option<f64>,
    sight: Sight,
    /// Time for which the radar has reported a better one, s.
    better_s: f64,
}

impl Default for Caution {
    fn default() -> Self {
        Self {
            proof_s: 0.0,
            most_mps2: FREE_MPS2,
            blind_from_mps: None,
            slows_mps2: None,
            sight: Sight::Full,
            better_s: 0.0,
        }
    }
}

impl Caution {
    /// Takes what the radar reports of its sight, if there is a report; returns the sight that counts.
    pub(super) fn settle(&mut self, reported: Option<Sight>, period_s: f64) -> Sight {
        let Some(reported) = reported else { return self.sight };
        // The less is seen, the later it stands in the enum.
        if (reported as u32) < self.sight as u32 {
            self.better_s += period_s;
        } else {
            (self.sight, self.better_s) = (reported, 0.0);
        }
        if self.better_s >= LONGEST_S {
            (self.sight, self.better_s) = (reported, 0.0);
        }
        self.sight
    }

    /// Bounds the set speed by the radar's sight; true if that is less than it should be.
    pub(super) fn heed(sight: Sight, input: &mut Input) -> bool {
        let most_mps = match sight {
            Sight::Full => return false,
            Sight::Limited => LIMITED_MPS,
            Sight::Blind => BLIND_MPS,
        };
        input.cap_speed(most_mps);
        true
    }

    /// Takes whether the road ahead is seen and whether a lead was lost; bounds the set speed.
    pub(super) fn observe(&mut self, is_blind: bool, input: &mut Input) {
        let period_s = input.period_s;
        if is_blind {
            let from_mps = *self.blind_from_mps.get_or_insert(input.ego.speed_mps.max(0.0));
            input.cap_speed(from_mps);
            self.proof_s = (self.proof_s + period_s).min(LONGEST_S);
            self.most_mps2 = if input.target.is_some() { 0.0 } else { BLIND_MPS2 };
            return;
        }
        self.blind_from_mps = None;
        self.proof_s -= period_s;
        if self.proof_s > 0.0 {
            self.most_mps2 = BLIND_MPS2;
        } else {
            self.proof_s = 0.0;
            self.most_mps2 = (self.most_mps2 + RISE_MPS3 * period_s).min(FREE_MPS2);
        }
    }

    /// Takes the radar's sight; slows down an ego that is too fast for a blind one.
    pub(super) fn slow_down(&mut self, sight: Sight, input: &Input) {
        let is_too_fast = sight == Sight::Blind && input.ego.speed_mps > BLIND_MPS;
        let harder_mps2 = self.slows_mps2.unwrap_or(0.0) - SLOWS_JERK_MPS3 * input.period_s;
        self.slows_mps2 = is_too_fast.then_some(harder_mps2.max(SLOWS_MPS2));
    }

    /// The largest request, m/s²; infinite while nothing asks for caution.
    pub(super) fn most_mps2(&self) -> f64 {
        let most_mps2 = if self.most_mps2 < FREE_MPS2 { self.most_mps2 } else { f64::INFINITY };
        self.slows_mps2.map_or(most_mps2, |slows_mps2| slows_mps2.min(most_mps2))
    }
}

/// Speed below which the ego stands, m/s.
const STANDS_MPS: f64 = 0.05;
/// Farthest gap at which a start waits, m. Chosen: all laws stand within 7 m.
const CLOSE_M: f64 = 8.0;
/// Growth of the gap that starts a vehicle, m. Chosen: the deviation of the radar's range, 0.4 m, and a little more.
const GROWN_M: f64 = 0.5;

/// Starting behind a vehicle: its gap must have grown. This is the smallest one while the ego stands.
///
/// A measured speed alone starts no vehicle that stands close behind another. A false speed of 2 m/s would move it
/// towards a car that stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Departure {
    smallest_m: Option<f64>,
    waits: bool,
}

impl Departure {
    /// Takes the ego and the target of a release.
    pub(super) fn observe(&mut self, input: &Input) {
        let close = input.target.filter(|_| input.ego.speed_mps < STANDS_MPS);
        self.smallest_m =
            close.map(|target| target.gap_m.min(self.smallest_m.unwrap_or(f64::INFINITY)));
        self.waits = close.zip(self.smallest_m).is_some_and(|(target, smallest_m)| {
            target.gap_m <= CLOSE_M && target.gap_m < smallest_m + GROWN_M
        });
    }

    /// The largest request, m/s²: a vehicle that waits stays.
    pub(super) fn most_mps2(&self) -> f64 {
        if self.waits { 0.0 } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Ego, Target};

    fn input(speed_mps: f64, target: Option<Target>) -> Input {
        let ego = Ego { speed_mps, ..Ego::default() };
        Input { period_s: 0.1, ego, target, set_speed_mps: 30.0, ..Input::default() }
    }

    #[test]
    fn nothing_is_bounded_while_the_road_is_seen() {
        let mut caution = Caution::default();
        let mut input = input(20.0, None);
        caution.observe(false, &mut input);
        assert_eq!((caution.most_mps2(), input.set_speed_mps), (f64::INFINITY, 30.0));
    }

    #[test]
    fn blind_it_keeps_its_speed_behind_a_lost_lead_and_hardly_gains_any_without() {
        let mut caution = Caution::default();
        let mut behind = input(20.0, Some(Target::default()));
        caution.observe(true, &mut behind);
        assert_eq!((caution.most_mps2(), behind.set_speed_mps), (0.0, 20.0));
        let mut free = input(21.0, None);
        caution.observe(true, &mut free);
        assert_eq!((caution.most_mps2(), free.set_speed_mps), (0.3, 20.0));
    }

    #[test]
    fn the_set_speed_follows_what_the_radar_sees() {
        for (share, most_mps) in [(1.0, 30.0), (0.5, LIMITED_MPS), (0.1, BLIND_MPS)] {
            let mut input = input(20.0, None);
            assert_eq!(Caution::heed(Sight::of_share(share), &mut input), share < 0.7);
            assert_eq!(input.set_speed_mps, most_mps);
        }
    }

    #[test]
    fn worse_sight_counts_at_once_and_better_sight_when_it_has_lasted() {
        let mut caution = Caution::default();
        let mut settle = |sight, releases: usize| {
            (0..releases).map(|_| caution.settle(sight, 0.1)).last().expect("a release")
        };
        assert_eq!(settle(Some(Sight::Full), 1), Sight::Full);
        assert_eq!(settle(Some(Sight::Limited), 1), Sight::Limited);
        // An estimate that goes to and fro about the threshold.
        for _ in 0..20 {
            assert_eq!(settle(Some(Sight::Full), 40), Sight::Limited);
            assert_eq!(settle(Some(Sight::Limited), 1), Sight::Limited);
        }
        assert_eq!(settle(Some(Sight::Blind), 1), Sight::Blind);
        assert_eq!(settle(None, 100), Sight::Blind, "no report is no better sight");
        assert_eq!(settle(Some(Sight::Limited), 49), Sight::Blind);
        assert_eq!(settle(Some(Sight::Full), 2), Sight::Full);
    }

    #[test]
    fn an_ego_that_is_too_fast_for_a_blind_radar_slows_down_comfortably() {
        let mut caution = Caution::default();
        caution.slow_down(Sight::Blind, &input(20.0, None));
        assert_eq!(caution.most_mps2(), -0.25);
        (0..20).for_each(|_| caution.slow_down(Sight::Blind, &input(20.0, None)));
        assert_eq!(caution.most_mps2(), SLOWS_MPS2);
        caution.slow_down(Sight::Blind, &input(BLIND_MPS, None));
        assert_eq!(caution.most_mps2(), f64::INFINITY, "slow enough");
        caution.slow_down(Sight::Limited, &input(20.0, None));
        assert_eq!(caution.most_mps2(), f64::INFINITY, "it sees enough");
    }

    #[test]
    fn sight_proves_itself_for_as_long_as_it_was_lost() {
        let mut caution = Caution::default();
        (0..20).for_each(|_| caution.observe(true, &mut input(20.0, None)));
        (0..19).for_each(|_| caution.observe(false, &mut input(20.0, None)));
        assert_eq!(caution.most_mps2(), 0.3);
        (0..3).for_each(|_| caution.observe(false, &mut input(20.0, None)));
        assert!((0.5..1.2).contains(&caution.most_mps2()), "{}", caution.most_mps2());
        (0..40).for_each(|_| caution.observe(false, &mut input(20.0, None)));
        assert_eq!(caution.most_mps2(), f64::INFINITY);
    }

    #[test]
    fn a_long_loss_asks_for_no_longer_proof_than_its_bound() {
        let mut caution = Caution::default();
        (0..600).for_each(|_| caution.observe(true, &mut input(20.0, None)));
        (0..49).for_each(|_| caution.observe(false, &mut input(20.0, None)));
        assert_eq!(caution.most_mps2(), 0.3);
        (0..3).for_each(|_| caution.observe(false, &mut input(20.0, None)));
        assert!(caution.most_mps2() > 0.3);
    }

    fn behind(speed_mps: f64, gap_m: f64) -> Input {
        // The speed is false: the target stands.
        let target = Some(Target { gap_m, relative_speed_mps: 2.0, ..Target::default() });
        Input { ego: Ego { speed_mps, ..Ego::default() }, target, ..Input::default() }
    }

    #[test]
    fn a_vehicle_that_stands_waits_until_the_gap_has_grown() {
        let mut departure = Departure::default();
        for gap_m in [7.0, 6.6, 7.0] {
            departure.observe(&behind(0.0, gap_m));
            assert_eq!(departure.most_mps2(), 0.0, "{gap_m}");
        }
        departure.observe(&behind(0.0, 7.2));
        assert_eq!(departure.most_mps2(), f64::INFINITY);
    }

    #[test]
    fn nothing_waits_that_moves_or_stands_far_behind_or_behind_nothing() {
        let free = Input { target: None, ..behind(0.0, 0.0) };
        for input in [behind(0.1, 5.0), behind(0.0, 8.1), free] {
            let mut departure = Departure::default();
            departure.observe(&input);
            assert_eq!(departure.most_mps2(), f64::INFINITY, "{input:?}");
        }
    }
}
