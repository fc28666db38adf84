//! Two vehicles abreast that the receiver does not resolve.
//!
//! Echoes within the azimuth's resolution come out as one, at their mean weighted by power. Far off, the vehicles in
//! both neighbouring lanes then look like one between them, where none is. The scatter distinguishes them from one
//! vehicle. The powers fluctuate independently from scan to scan, and the share of one of two exponential powers is
//! uniform. So the mean of two wanders over all of the distance D between their middles, with the variance D²/12. The
//! mean of one vehicle stays on its body.
//!
//! A track therefore keeps the logarithm of the likelihood ratio of one body to two. Its place is unknown until the
//! ratio is for one body, or until the resolution keeps neighbouring lanes apart.
//!
//! The price: a vehicle in the ego's lane with one abreast counts late. It has to be resolved first, or to need more than
//! comfortable braking.
//!
//! Source of the scatter of unresolved targets: Blair and Brandt-Pearce, Unresolved Rayleigh target
//! detection using monopulse measurements, IEEE Trans. Aerospace and Electronic Systems 34 (1998) 543.

use scenario::event::VEHICLE_WIDTH_M;

use super::longitudinal::Measured;

/// Least distance between the middles of vehicles in both neighbouring lanes, m: two lanes of 3 m.
const LEAST_APART_M: f64 = 6.0;
/// Logarithm of the likelihood ratio from which a track is one body: 55 to 1.
const ONE_BODY: f64 = 4.0;
/// Most of it that is kept: a few distant places do not make two of one body.
const MOST: f64 = 6.0;

/// Evidence from a track's scatter across the lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Abreast {
    is_one: bool,
    /// Logarithm of the likelihood ratio of one body to two.
    evidence: f64,
}

impl Abreast {
    /// Takes a measured lateral position beside the predicted one. `cell_m` is the width over which the azimuth's
    /// resolution merges echoes at the range.
    pub fn observe(&mut self, measured: Measured, predicted: Measured, cell_m: f64) {
        let apart_m = cell_m + VEHICLE_WIDTH_M;
        if apart_m < LEAST_APART_M && self.evidence >= 0.0 {
            self.is_one = true;
            return;
        }
        let off_m = measured.value - predicted.value;
        let one_m2 = measured.variance + predicted.variance;
        // Mean of D²/12 over all distances of two that merge.
        let (least_m, most_m) = (LEAST_APART_M, apart_m.max(LEAST_APART_M));
        let two_m2 = one_m2 + (least_m * least_m + least_m * most_m + most_m * most_m) / 36.0;
        let squared = 0.5 * off_m * off_m;
        self.evidence += 0.5 * libm::log(two_m2 / one_m2) - squared / one_m2 + squared / two_m2;
        self.evidence = self.evidence.clamp(-ONE_BODY, MOST);
        self.is_one = self.evidence >= if self.is_one { 0.0 } else { ONE_BODY };
    }

    /// It is known to be one body.
    pub fn is_one(&self) -> bool {
        self.is_one
    }
}

#[cfg(test)]
mod tests {
    use super::super::lateral;
    use super::*;
    use crate::random::Random;
    use crate::tracking::numbers::Numbers;

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
            abreast.observe(measured, predicted, CELL_M);
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
            let before = count(&[-3.5, 3.5], scans, Abreast::is_one);
            assert!(before < 20, "{before} after {scans}");
        }
    }

    #[test]
    fn one_in_the_lane_with_one_beside_it_is_not_one_body_either() {
        let one = count(&[0.0, 3.5], 40, Abreast::is_one);
        assert!(one < 100, "{one}");
    }

    #[test]
    fn what_is_resolved_is_one_body_at_once_unless_its_scatter_has_said_otherwise() {
        let resolved_m = 2.0;
        let at = |value: f64| Measured::new(value, 0.4);
        let mut one = Abreast::default();
        one.observe(at(0.3), at(0.0), resolved_m);
        assert!(one.is_one());
        let mut two = follow(&[-3.5, 3.5], 20, 1);
        two.observe(at(3.3), at(3.0), resolved_m);
        assert!(!two.is_one());
        (0..12).for_each(|_| two.observe(at(3.3), at(3.2), resolved_m));
        assert!(two.is_one(), "it has settled on one of them");
    }

    /// 0.25 m² of one body; 0.25 m² and the mean of D²/12 for 6 to 8 m of two.
    #[test]
    fn evidence_is_the_likelihood_ratio_of_one_body_to_two() {
        let two_m2 = 0.25 + (36.0 + 48.0 + 64.0) / 36.0;
        let (measured, predicted) = (Measured::new(1.0, 0.4), Measured::new(0.0, 0.3));
        let mut abreast = Abreast::default();
        abreast.observe(measured, predicted, 6.2);
        let once = 0.5 * libm::log(two_m2 / 0.25) - 0.5 / 0.25 + 0.5 / two_m2;
        assert!((abreast.evidence - once).abs() < 1e-12, "{abreast:?}");
        abreast.observe(Measured::new(-1.0, 0.4), predicted, 6.2);
        assert!((abreast.evidence - 2.0 * once).abs() < 1e-12, "{abreast:?}");
        // A cell with room for less than 6 m counts as one of 6 m.
        let mut narrow = Abreast { evidence: -1.0, ..Abreast::default() };
        narrow.observe(predicted, predicted, 1.0);
        let two_m2 = 0.18 + 3.0;
        assert!((narrow.evidence + 1.0 - 0.5 * libm::log(two_m2 / 0.18)).abs() < 1e-12);
    }

    #[test]
    fn it_becomes_one_body_at_four_and_stops_being_one_below_nought() {
        let at = |value: f64| Measured::new(value, 0.3);
        let after = |is_one: bool, evidence: f64, off_m: f64| {
            let mut abreast = Abreast { is_one, evidence };
            abreast.observe(at(off_m), at(0.0), 6.2);
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
            abreast.observe(at, at, cell_m);
            abreast.is_one()
        };
        assert!(one(4.19, 0.0) && !one(4.21, 0.0) && !one(4.19, -0.1));
    }
}
