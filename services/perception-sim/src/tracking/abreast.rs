//! Two vehicles abreast that the receiver does not resolve.
//!
//! Echoes within the azimuth's resolution come out as one, at their mean weighted by power. Far off, the vehicles in
//! both neighbouring lanes then look like one between them, where none is. The scatter distinguishes them from one
//! vehicle. The powers fluctuate independently from scan to scan, and the share of one of two exponential powers is
//! uniform. So the mean of two wanders over all of the distance D between their middles, with the variance D²/12. The
//! mean of one vehicle stays on its body.
//!
//! A track therefore keeps the logarithm of the likelihood ratio of one body to two, and the outermost places. The
//! bodies are at the outermost places, and the room between is unknown, until the ratio is for one body
//! ([`Numbers::one_body`]). If the resolution keeps neighbouring lanes apart, a track is one body unless its scatter
//! contradicts.
//!
//! The price: the middle one of three abreast, in the ego's lane, counts late. It has to be resolved first, or to
//! need more than comfortable braking.
//!
//! Source of the scatter of unresolved targets: Blair and Brandt-Pearce, Unresolved Rayleigh target
//! detection using monopulse measurements, IEEE Trans. Aerospace and Electronic Systems 34 (1998) 543.

use scenario::event::VEHICLE_WIDTH_M;

use super::longitudinal::Measured;
use super::numbers::Numbers;

/// Evidence from a track's scatter across the lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Abreast {
    /// It was found to be one body.
    one: bool,
    /// Logarithm of the likelihood ratio of one body to two.
    evidence: f64,
    /// The outermost measured positions, m.
    right_m: f64,
    left_m: f64,
    scans: u32,
}

impl Default for Abreast {
    fn default() -> Self {
        let (right_m, left_m) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { one: false, evidence: 0.0, right_m, left_m, scans: 0 }
    }
}

impl Abreast {
    /// Takes a measured lateral position beside the predicted one. `cell_m` is the width over which the
    /// azimuth's resolution merges echoes at the range.
    pub fn observe(
        &mut self,
        measured: Measured,
        predicted: Measured,
        cell_m: f64,
        numbers: &Numbers,
    ) {
        let apart_m = cell_m + VEHICLE_WIDTH_M;
        if apart_m < numbers.least_apart_m && self.evidence >= 0.0 {
            self.one = true;
            return;
        }
        let off_m = measured.value - predicted.value;
        let one_m2 = measured.variance + predicted.variance;
        // Mean of D²/12 over all distances of two that merge.
        let least_m = numbers.least_apart_m;
        let most_m = apart_m.max(least_m);
        let two_m2 = one_m2 + (least_m * least_m + least_m * most_m + most_m * most_m) / 36.0;
        let squared = 0.5 * off_m * off_m;
        self.evidence += 0.5 * libm::log(two_m2 / one_m2) - squared / one_m2 + squared / two_m2;
        self.evidence = self.evidence.clamp(numbers.least_evidence, numbers.most_evidence);
        self.one = self.evidence >= if self.one { 0.0 } else { numbers.one_body };
        self.right_m = self.right_m.min(measured.value);
        self.left_m = self.left_m.max(measured.value);
        self.scans = self.scans.saturating_add(1);
    }

    /// Place of the body nearest to the ego's axis if there are several, m; `None` while it is unknown. The mean of
    /// two is between them. So one is at its rightmost place or beyond, the other at its leftmost. `others` says on
    /// which sides (right, left) the body is one that has a track of its own.
    pub fn nearest_of_several_m(&self, others: (bool, bool), numbers: &Numbers) -> Option<f64> {
        if self.evidence >= 0.0 || self.scans < numbers.enough_scans {
            return None;
        }
        match others {
            (true, true) => None,
            (true, false) => Some(self.left_m),
            (false, true) => Some(self.right_m),
            (false, false) if self.right_m.abs() < self.left_m.abs() => Some(self.right_m),
            (false, false) => Some(self.left_m),
        }
    }

    /// Moves the outermost places by `by_m`, with the axis from which they are measured.
    pub fn shift(&mut self, by_m: f64) {
        self.right_m += by_m;
        self.left_m += by_m;
    }

    /// It is known to be one body.
    pub fn is_one(&self) -> bool {
        self.one
    }
}

#[cfg(test)]
mod tests {
    use super::super::lateral;
    use super::*;
    use crate::random::Random;

    const NUMBERS: &Numbers = &Numbers::DEFAULT;

    /// Evidence after `scans` of echoes at `places` whose powers are exponential.
    fn follow(places: &[f64], scans: u32, seed: u64) -> Abreast {
        let mut random = Random::of_run(seed, 0);
        let mut abreast = Abreast::default();
        let mut track: Option<lateral::Filter> = None;
        for _ in 0..scans {
            let (mut power, mut moment) = (0.0, 0.0);
            for place in places {
                let share = random.exponential();
                power += share;
                moment += share * place;
            }
            let measured = Measured::new(moment / power + NOISE_M * random.normal(), NOISE_M);
            let measured = Measured { variance: measured.variance + BODY_M2, ..measured };
            let Some(filter) = &mut track else {
                track = Some(lateral::Filter::start(measured, NUMBERS));
                continue;
            };
            filter.predict(0.05, NUMBERS);
            let sigma_m = filter.position_sigma_m();
            let predicted = Measured::new(filter.position_m(), sigma_m);
            abreast.observe(measured, predicted, CELL_M, NUMBERS);
            filter.update(measured, NUMBERS);
        }
        abreast
    }

    /// At 120 m: the resolution of 3°, the azimuth's noise, and the variance on a rear.
    const CELL_M: f64 = 6.3;
    const NOISE_M: f64 = 0.3;
    const BODY_M2: f64 = 0.11;
    const RUNS: u64 = 400;

    fn count(places: &[f64], scans: u32, holds: impl Fn(&Abreast) -> bool) -> usize {
        (0..RUNS).filter(|seed| holds(&follow(places, scans, *seed))).count()
    }

    fn in_path(abreast: &Abreast) -> bool {
        abreast.is_one()
            || abreast
                .nearest_of_several_m((false, false), NUMBERS)
                .is_some_and(|y_m| y_m.abs() < 1.6)
    }

    #[test]
    fn one_vehicle_is_one_body_within_half_a_second() {
        for scans in [10, 40] {
            let known = count(&[-0.9, 0.0, 0.9], scans, Abreast::is_one);
            assert!(known > 380, "{known} after {scans}");
        }
        let known = count(&[-0.9, 0.0, 0.9], 7, Abreast::is_one);
        assert!(known > 200, "most within a third: {known}");
    }

    #[test]
    fn two_in_the_neighbouring_lanes_are_not_before_the_ego() {
        for scans in [10, 20, 30, 40] {
            let before = count(&[-3.5, 3.5], scans, in_path);
            assert!(before < 20, "{before} after {scans}");
        }
    }

    #[test]
    fn the_one_of_two_that_is_before_the_ego_counts() {
        let before = count(&[0.0, 3.5], 40, in_path);
        assert!(before > 340, "{before}");
    }

    #[test]
    fn what_is_resolved_is_one_body_at_once_unless_its_scatter_has_said_otherwise() {
        let resolved_m = 2.0;
        let at = |value: f64| Measured::new(value, 0.4);
        let mut one = Abreast::default();
        one.observe(at(0.3), at(0.0), resolved_m, NUMBERS);
        assert!(one.is_one());
        let mut two = follow(&[-3.5, 3.5], 20, 1);
        two.observe(at(3.3), at(3.0), resolved_m, NUMBERS);
        assert!(!two.is_one());
        (0..12).for_each(|_| two.observe(at(3.3), at(3.2), resolved_m, NUMBERS));
        assert!(two.is_one(), "it has settled on one of them");
    }

    /// 0.25 m² of one body; 0.25 m² and the mean of D²/12 for 6 to 8 m of two.
    #[test]
    fn evidence_is_the_likelihood_ratio_of_one_body_to_two() {
        let two_m2 = 0.25 + (36.0 + 48.0 + 64.0) / 36.0;
        let (measured, predicted) = (Measured::new(1.0, 0.4), Measured::new(0.0, 0.3));
        let mut abreast = Abreast::default();
        abreast.observe(measured, predicted, 6.2, NUMBERS);
        let once = 0.5 * libm::log(two_m2 / 0.25) - 0.5 / 0.25 + 0.5 / two_m2;
        assert!((abreast.evidence - once).abs() < 1e-12, "{abreast:?}");
        assert_eq!((abreast.right_m, abreast.left_m, abreast.scans), (1.0, 1.0, 1));
        abreast.observe(Measured::new(-1.0, 0.4), predicted, 6.2, NUMBERS);
        assert!((abreast.evidence - 2.0 * once).abs() < 1e-12, "{abreast:?}");
        assert_eq!((abreast.right_m, abreast.left_m, abreast.scans), (-1.0, 1.0, 2));
        abreast.shift(0.5);
        assert_eq!((abreast.right_m, abreast.left_m), (-0.5, 1.5));
        // A cell with room for less than 6 m counts as one of 6 m.
        let mut narrow = Abreast { evidence: -1.0, ..Abreast::default() };
        narrow.observe(predicted, predicted, 1.0, NUMBERS);
        let two_m2 = 0.18 + 3.0;
        assert!((narrow.evidence + 1.0 - 0.5 * libm::log(two_m2 / 0.18)).abs() < 1e-12);
    }

    #[test]
    fn it_becomes_one_body_at_four_and_stops_being_one_below_nought() {
        let at = |value: f64| Measured::new(value, 0.3);
        let after = |one: bool, evidence: f64, off_m: f64| {
            let mut abreast = Abreast { one, evidence, ..Abreast::default() };
            abreast.observe(at(off_m), at(0.0), 6.2, NUMBERS);
            (abreast.is_one(), abreast.evidence)
        };
        // An echo in the middle speaks for one body by 0.5 ln(4.291 / 0.18) = 1.586.
        assert!(after(false, 2.43, 0.0).0 && !after(false, 2.40, 0.0).0);
        assert!(after(true, -1.57, 0.0).0 && !after(true, -1.60, 0.0).0);
        assert_eq!((after(true, 5.9, 0.0).1, after(false, -3.9, 6.0).1), (6.0, -4.0));
    }

    #[test]
    fn neighbouring_lanes_are_resolved_below_six_metres_less_a_vehicles_width() {
        let at = Measured::new(0.0, 0.3);
        let one = |cell_m: f64, evidence: f64| {
            let mut abreast = Abreast { evidence, ..Abreast::default() };
            abreast.observe(at, at, cell_m, NUMBERS);
            abreast.is_one()
        };
        assert!(one(4.19, 0.0) && !one(4.21, 0.0) && !one(4.19, -0.1));
    }

    #[test]
    fn the_nearest_of_several_is_known_after_enough_scans_that_speak_for_two() {
        let two = Abreast { evidence: -1.0, right_m: -2.0, left_m: 3.0, scans: 24, one: false };
        let nearest = |abreast: Abreast| abreast.nearest_of_several_m((false, false), NUMBERS);
        assert_eq!(nearest(two), Some(-2.0));
        assert_eq!(nearest(Abreast { right_m: -4.0, ..two }), Some(3.0));
        assert_eq!(nearest(Abreast { scans: 23, ..two }), None);
        assert_eq!(nearest(Abreast { evidence: 0.0, ..two }), None);
        let beside = |others: (bool, bool)| two.nearest_of_several_m(others, NUMBERS);
        assert_eq!(beside((true, false)), Some(3.0));
        assert_eq!(beside((false, true)), Some(-2.0));
        assert_eq!(beside((true, true)), None);
    }
}
