//! One vehicle, or two abreast that the radar does not resolve.
//!
//! Two echoes of one range and one speed come out as one between them if the radar does not resolve their azimuths. Two
//! vehicles in the lanes beside the ego's then look as one in the ego's lane. The place of such an echo scatters around
//! the middle between the two. Their powers fluctuate from scan to scan. That of one vehicle stays on its body.
//!
//! So an object that is that far off has odds. They compare one body with two as the explanation of the places where it
//! was seen. Each scan multiplies them by
//!
//! ```text
//! seen at y:                    p(y | the lateral filter) / N(y; 0, s²)     s: scatter around the middle of the ego's lane
//! not seen, but in its range and speed elsewhere:  MISSED
//! ```
//!
//! From where the radar resolves the two, an object is one body.
//!
//! The price: the middle one of three that are exactly abreast counts late, from where two would be resolved.

use crate::filter::density;

/// Least distance between the middles of vehicles in the lanes beside the ego's, m: two lanes of 3 m.
const LEAST_APART_M: f64 = 6.0;
/// Distance between the corners of a rear that reflect, m.
const CORNERS_M: f64 = 1.8;
/// Standard deviation of the place of the echo of two, m. Calculated: 7 m times that of the share of one of two powers.
/// Each is the sum of three exponential ones, of the middle of a rear (0.6) and its corners (0.2). So each is like a
/// gamma variable of shape 1 / 0.44. The share is like a beta variable with the variance 0.045.
const SCATTER_M: f64 = 1.5;
/// Odds that an echo of one body is missing in a scan, to those of one between two. Chosen: one in ten of a vehicle's
/// echoes is too weak. Two bodies come out as two in every other scan.
const MISSED: f64 = 0.1 / 0.5;
/// Limits of the odds' logarithm: 20 to 1. Another vehicle may come abreast at any time.
const MOST: f64 = 3.0;

/// Probability that an object is one body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct OneBody {
    /// Logarithm of the odds; at first both are alike.
    log_odds: f64,
}

impl OneBody {
    /// True if a radar of this azimuth resolution may see two as one at this distance.
    pub(crate) fn is_doubtful(distance_m: f64, resolution_rad: f64) -> bool {
        distance_m * resolution_rad > LEAST_APART_M - CORNERS_M
    }

    /// It was seen at `place_m`, with a variance, m², where one body was expected with this density, 1/m.
    pub(crate) fn see(&mut self, place_m: f64, variance_m2: f64, density_perm: f64) {
        self.weigh(density_perm / density(place_m, SCATTER_M * SCATTER_M + variance_m2));
    }

    /// It was not seen, but something else in its range and speed.
    pub(crate) fn miss(&mut self) {
        self.weigh(MISSED);
    }

    fn weigh(&mut self, ratio: f64) {
        self.log_odds = (self.log_odds + libm::log(ratio.max(1e-9))).clamp(-MOST, MOST);
    }

    /// Its probability.
    pub(crate) fn probability(&self) -> f64 {
        1.0 / (1.0 + libm::exp(-self.log_odds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Lateral;

    const VARIANCE_M2: f64 = 0.18;

    /// Probability after these places, m.
    fn after(places_m: &[f64]) -> f64 {
        let mut lateral = Lateral::first(places_m[0], 0.7);
        let mut one = OneBody::default();
        for place_m in &places_m[1..] {
            lateral.predict(0.05, 30.0);
            one.see(*place_m, VARIANCE_M2, lateral.expects(*place_m, VARIANCE_M2));
            lateral.update(*place_m, VARIANCE_M2);
        }
        one.probability()
    }

    #[test]
    fn an_object_that_stays_in_its_place_is_one_body_when_it_is_confirmed() {
        assert!(after(&[0.3, -0.2, 0.4, 0.0]) > 0.8, "{}", after(&[0.3, -0.2, 0.4, 0.0]));
        // One that comes in at 1 m/s, too.
        let coming_in: Vec<f64> = (0..8).map(|k| 3.5 - 0.05 * f64::from(k)).collect();
        assert!(after(&coming_in) > 0.95, "{}", after(&coming_in));
    }

    #[test]
    fn an_echo_that_scatters_between_two_lanes_is_two_vehicles() {
        let between = [-1.5, 1.7, -1.9, -0.5, 0.0, -1.7, -0.2, 0.3];
        assert!(after(&between) < 0.15, "{}", after(&between));
    }

    #[test]
    fn an_object_seen_at_several_places_is_rarely_one_body() {
        let mut one = OneBody::default();
        one.see(0.0, VARIANCE_M2, 0.8);
        let before = one.probability();
        one.miss();
        one.miss();
        assert!(before > 0.7 && one.probability() < 0.2, "{before} {}", one.probability());
    }

    #[test]
    fn near_by_the_radar_resolves_two() {
        let resolution_rad = 3f64.to_radians();
        assert!(OneBody::is_doubtful(100.0, resolution_rad));
        assert!(!OneBody::is_doubtful(75.0, resolution_rad));
        assert!(!OneBody::is_doubtful(150.0, 1f64.to_radians()));
    }

    #[test]
    fn a_scan_multiplies_the_odds_by_how_much_better_one_body_explains_it() {
        let (mut one, two_perm) = (OneBody::default(), |place_m: f64| {
            let variance = 1.5 * 1.5 + VARIANCE_M2;
            libm::exp(-0.5 * place_m * place_m / variance)
                / libm::sqrt(2.0 * std::f64::consts::PI * variance)
        });
        assert_eq!(one.probability(), 0.5);
        one.see(1.0, VARIANCE_M2, 0.5);
        let odds = 0.5 / two_perm(1.0);
        assert!((one.probability() - odds / (1.0 + odds)).abs() < 1e-12);
        one.miss();
        assert!((one.probability() - 0.2 * odds / (1.0 + 0.2 * odds)).abs() < 1e-12);
        // No more than e³ to one, either way.
        (0..9).for_each(|_| one.see(0.0, VARIANCE_M2, 5.0));
        assert!((one.probability() - 1.0 / (1.0 + libm::exp(-3.0))).abs() < 1e-12);
        one.see(0.0, VARIANCE_M2, 0.0);
        assert!((one.probability() - 1.0 / (1.0 + libm::exp(3.0))).abs() < 1e-12);
    }

    #[test]
    fn two_abreast_are_resolved_by_their_corners() {
        // 6 m between the middles less 1.8 m between the corners.
        assert!(OneBody::is_doubtful(42.1, 0.1) && !OneBody::is_doubtful(41.9, 0.1));
    }
}
