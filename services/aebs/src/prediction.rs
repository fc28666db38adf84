//! The last point to brake: how near the ego comes to an object if it brakes from some instant on.
//!
//! The ego keeps its acceleration until the brakes bite (dead time), then its deceleration grows by the
//! brake's jerk up to its authority, until it is no faster than the object and far enough behind it. The
//! object keeps the acceleration that was estimated, until it stands. Both are integrated in steps of
//! [`STEP_S`]. An object that the ego passes before it comes into the way is no threat, and braking can make
//! it one: that shows in the same integration.

use crate::path::Overlap;

/// Step of the prediction, s.
const STEP_S: f64 = 0.02;
/// Longest prediction, s: a car at 70 m/s with 0.85 g stands before.
const LONGEST_S: f64 = 10.0;

/// What the vehicle's emergency brakes give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Authority {
    /// Time from the request until the deceleration begins to grow, s.
    pub dead_time_s: f64,
    /// Growth of the deceleration, m/s³.
    pub jerk_mps3: f64,
    /// Largest deceleration, m/s².
    pub deceleration_mps2: f64,
}

/// The ego as its odometry has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ego {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
}

/// What is in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threat {
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Its speed over ground, m/s.
    pub speed_mps: f64,
    /// Its acceleration, m/s².
    pub acceleration_mps2: f64,
    /// The ego has passed it when this far beyond its rear, m: both lengths.
    pub passed_m: f64,
    /// When it is in the way.
    pub overlap: Overlap,
}

impl Authority {
    /// Smallest distance to `threat` while it is in the way, m, if the brakes are asked for in `wait_s`
    /// and held until it is no slower and `margin_m` ahead. Negative: they would touch. Infinite: it is
    /// never in the way, or passed before it is.
    #[must_use]
    pub fn smallest_gap_m(&self, ego: &Ego, threat: &Threat, wait_s: f64, margin_m: f64) -> f64 {
        let begins_s = wait_s + self.dead_time_s;
        let (mut gap_m, mut speed, mut other) = (threat.gap_m, ego.speed_mps, threat.speed_mps);
        let mut acceleration = ego.acceleration_mps2;
        let mut smallest_m = f64::INFINITY;
        let mut time_s = 0.0;
        while time_s < LONGEST_S && time_s <= threat.overlap.out_s && gap_m > -threat.passed_m {
            let in_the_way = time_s >= threat.overlap.in_s;
            if in_the_way {
                smallest_m = smallest_m.min(gap_m);
                if gap_m < 0.0 {
                    break;
                }
            }
            // The difference only grows from here on, or it stays as it is.
            let settled = speed <= other && threat.acceleration_mps2 >= acceleration.min(0.0);
            if settled && (gap_m >= margin_m || in_the_way) {
                break;
            }
            let before = acceleration;
            let braked_s = (time_s + STEP_S - begins_s).min(STEP_S);
            if braked_s > 0.0 {
                let harder = acceleration - self.jerk_mps3 * braked_s;
                acceleration = harder.max(-self.deceleration_mps2).min(acceleration);
            }
            let (next, next_other) = (
                (speed + 0.5 * (before + acceleration) * STEP_S).max(0.0),
                if other > 0.0 {
                    (other + threat.acceleration_mps2 * STEP_S).max(0.0)
                } else {
                    other
                },
            );
            if next == 0.0 && next_other == 0.0 {
                // Both stand.
                let last_m = gap_m - 0.5 * STEP_S * (speed - other);
                return if in_the_way { smallest_m.min(last_m) } else { smallest_m };
            }
            gap_m += 0.5 * STEP_S * (other + next_other - speed - next);
            (speed, other) = (next, next_other);
            time_s += STEP_S;
        }
        smallest_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BRAKES: Authority =
        Authority { dead_time_s: 0.1, jerk_mps3: 12.65, deceleration_mps2: 8.3385 };
    const NOW: Overlap = Overlap { in_s: 0.0, out_s: f64::INFINITY };

    fn standing(gap_m: f64) -> Threat {
        Threat { gap_m, speed_mps: 0.0, acceleration_mps2: 0.0, passed_m: 9.0, overlap: NOW }
    }

    #[test]
    fn the_stopping_distance_is_that_of_the_formula() {
        // Dead time, ramp of 0.659 s, then v²/(2 a): by hand for 20 m/s.
        let ramp_s: f64 = 8.3385 / 12.65;
        let after_ramp = 20.0 - 0.5 * 8.3385 * ramp_s;
        let distance = 20.0 * 0.1 + 20.0 * ramp_s - 12.65 * ramp_s.powi(3) / 6.0
            + after_ramp * after_ramp / (2.0 * 8.3385);
        let ego = Ego { speed_mps: 20.0, acceleration_mps2: 0.0 };
        let left = BRAKES.smallest_gap_m(&ego, &standing(100.0), 0.0, 0.6);
        assert!((100.0 - distance - left).abs() < 0.3, "{distance} {left}");
    }

    #[test]
    fn what_leaves_in_time_or_comes_after_the_pass_is_no_threat() {
        let ego = Ego { speed_mps: 20.0, acceleration_mps2: 0.0 };
        let after = |in_s| Overlap { in_s, out_s: f64::INFINITY };
        let passing = Threat {
            gap_m: 5.0,
            speed_mps: 10.0,
            acceleration_mps2: 0.0,
            passed_m: 9.0,
            overlap: after(1.5),
        };
        let unbraked = |threat: &Threat| BRAKES.smallest_gap_m(&ego, threat, 1e3, 0.6);
        assert_eq!(unbraked(&passing), f64::INFINITY, "14 m take 1.4 s");
        assert!(unbraked(&Threat { overlap: after(1.3), ..passing }) < 0.0);
        let braked = BRAKES.smallest_gap_m(&ego, &passing, 0.0, 0.6);
        assert!(braked < 0.0, "braking makes the contact: {braked}");
        let leaving = Threat { gap_m: 60.0, overlap: Overlap { in_s: 0.0, out_s: 0.5 }, ..passing };
        assert!(unbraked(&leaving) > 50.0);
    }

    #[test]
    fn braking_goes_on_until_there_is_room_for_what_comes_in() {
        // Beside the ego at its own speed: braking lets it in.
        let ego = Ego { speed_mps: 15.0, acceleration_mps2: 0.0 };
        let beside = Threat {
            gap_m: -1.0,
            speed_mps: 14.0,
            acceleration_mps2: 0.0,
            passed_m: 9.0,
            overlap: Overlap { in_s: 1.5, out_s: f64::INFINITY },
        };
        assert!(BRAKES.smallest_gap_m(&ego, &beside, 1e3, 0.6) < 0.0);
        assert!(BRAKES.smallest_gap_m(&ego, &beside, 0.0, 0.6) > 0.0);
    }

    proptest! {
        #[test]
        fn braking_later_never_leaves_more_room(
            gap in 1.0..120.0_f64, v in 1.0..40.0_f64, other in 0.0..40.0_f64,
            a in -9.0..2.0_f64, wait in 0.0..2.0_f64,
        ) {
            let ego = Ego { speed_mps: v, acceleration_mps2: 0.0 };
            let threat =
                Threat { gap_m: gap, speed_mps: other, acceleration_mps2: a, passed_m: 9.0, overlap: NOW };
            let sooner = BRAKES.smallest_gap_m(&ego, &threat, wait, 0.6);
            let later = BRAKES.smallest_gap_m(&ego, &threat, wait + 0.1, 0.6);
            // How deep a contact is says nothing.
            prop_assert!(later <= sooner + 1e-9 || later < 0.0, "{sooner} {later}");
        }
    }
}
