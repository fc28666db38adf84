//! When the ego is beside an object, depending on what the ego does.
//!
//! If it brakes, it first keeps its acceleration until the brakes bite (dead time). Then its deceleration grows by the
//! brake's jerk up to its authority. It ends when the ego is no faster than the object and far enough behind it. The
//! object keeps the acceleration that was estimated, until it stands. Both are integrated in steps of [`STEP_S`]. The
//! time ends when the ego has passed, or has fallen back behind the object.

const STEP_S: f64 = 0.02;
/// Longest prediction, s: a car at 70 m/s with 0.85 g stands before.
const LONGEST_S: f64 = 10.0;
/// Time until an ego asks for its brakes that never does, s.
pub const NEVER_S: f64 = f64::INFINITY;

/// Capability of the vehicle's emergency brakes.
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
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

/// Obstacle that may be in the way, along the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threat {
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// The ego has passed it when this far beyond its rear, m: both lengths.
    pub passed_m: f64,
}

/// The time in which the two are beside each other along the road.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beside {
    pub first_s: f64,
    /// Its end, s; infinite if it does not end.
    pub last_s: f64,
    /// Speed of the ego over the other at the start, m/s.
    pub first_mps: f64,
}

impl Authority {
    /// Time when the ego is beside `threat`, or nearer behind it than `clear_m`, if it asks for its brakes in `asks_s`.
    /// `None`: never, or it has passed.
    pub fn beside(&self, ego: &Ego, threat: &Threat, asks_s: f64, clear_m: f64) -> Option<Beside> {
        let begins_s = asks_s + self.dead_time_s;
        let (mut gap_m, mut speed, mut other) = (threat.gap_m, ego.speed_mps, threat.speed_mps);
        let mut acceleration = ego.acceleration_mps2;
        let mut beside: Option<Beside> = None;
        let mut time_s = 0.0;
        while time_s < LONGEST_S {
            let closing = speed - other;
            if gap_m < clear_m && gap_m > -threat.passed_m {
                let last_s = f64::INFINITY;
                beside.get_or_insert(Beside { first_s: time_s, last_s, first_mps: closing });
            } else if let Some(beside) = beside {
                return Some(Beside { last_s: time_s, ..beside });
            } else if gap_m <= -threat.passed_m {
                return None;
            }
            let settled = closing <= 0.0 && threat.acceleration_mps2 >= acceleration.min(0.0);
            let both_stand = time_s > 0.0 && speed == 0.0 && other == 0.0;
            if both_stand || settled && gap_m >= clear_m {
                break;
            }
            let before = acceleration;
            let braked_s = (time_s + STEP_S - begins_s).clamp(0.0, STEP_S);
            let harder = acceleration - self.jerk_mps3 * braked_s;
            acceleration = harder.max(-self.deceleration_mps2).min(acceleration);
            let next = (speed + 0.5 * (before + acceleration) * STEP_S).max(0.0);
            let next_other = match other > 0.0 {
                true => (other + threat.acceleration_mps2 * STEP_S).max(0.0),
                false => other,
            };
            gap_m += 0.5 * STEP_S * (other + next_other - speed - next);
            (speed, other) = (next, next_other);
            time_s += STEP_S;
        }
        beside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BRAKES: Authority =
        Authority { dead_time_s: 0.1, jerk_mps3: 12.65, deceleration_mps2: 8.3385 };

    fn threat(gap_m: f64, speed_mps: f64) -> Threat {
        Threat { gap_m, speed_mps, acceleration_mps2: 0.0, passed_m: 9.0 }
    }

    fn cruising(speed_mps: f64) -> Ego {
        Ego { speed_mps, acceleration_mps2: 0.0 }
    }

    #[test]
    fn the_stopping_distance_is_that_of_the_formula() {
        // Dead time, ramp of 0.659 s, then v²/(2 a): by hand for 20 m/s.
        let ramp_s: f64 = 8.3385 / 12.65;
        let after_ramp = 20.0 - 0.5 * 8.3385 * ramp_s;
        let distance_m = 20.0 * 0.1 + 20.0 * ramp_s - 12.65 * ramp_s.powi(3) / 6.0
            + after_ramp * after_ramp / (2.0 * 8.3385);
        let stops =
            |gap_m: f64| BRAKES.beside(&cruising(20.0), &threat(gap_m, 0.0), 0.0, 0.0).is_none();
        assert!(stops(distance_m + 0.3) && !stops(distance_m - 0.3), "{distance_m}");
    }

    #[test]
    fn a_pass_ends_when_both_lengths_are_behind() {
        let ego = cruising(20.0);
        let beside = BRAKES.beside(&ego, &threat(5.0, 10.0), NEVER_S, 0.0).expect("it passes");
        assert!((beside.first_s - 0.5).abs() < 0.05 && (beside.last_s - 1.4).abs() < 0.05);
        assert_eq!(beside.first_mps, 10.0);
        let braked = BRAKES.beside(&ego, &threat(5.0, 10.0), 0.0, 0.0);
        let braked = braked.expect("the distance is too short");
        assert!(braked.last_s > beside.last_s && braked.first_mps < 10.0, "{braked:?}");
        assert_eq!(BRAKES.beside(&ego, &threat(-9.5, 10.0), NEVER_S, 0.0), None, "passed");
        assert_eq!(BRAKES.beside(&ego, &threat(5.0, 21.0), NEVER_S, 0.0), None, "faster");
    }

    #[test]
    fn braking_beside_a_vehicle_lets_it_go_ahead() {
        let ego = cruising(15.0);
        let beside = BRAKES.beside(&ego, &threat(-1.0, 14.0), 0.0, 0.6);
        let beside = beside.expect("it is beside");
        assert!(beside.first_s == 0.0 && beside.last_s < 2.0, "{beside:?}");
        let beside = BRAKES.beside(&ego, &threat(-1.0, 15.5), NEVER_S, 0.0).expect("beside");
        assert!(beside.last_s > 1.9, "{beside:?}");
    }

    #[test]
    fn letting_go_of_the_brakes_closes_up_again() {
        let released = BRAKES.beside(&cruising(16.0), &threat(5.0, 10.0), NEVER_S, 0.0);
        assert!(released.is_some(), "3 m/s are left when the brakes are off");
        let ego = Ego { speed_mps: 16.0, acceleration_mps2: -8.0 };
        assert_eq!(BRAKES.beside(&ego, &threat(5.0, 10.0), f64::NEG_INFINITY, 0.0), None);
    }

    proptest! {
        #[test]
        fn braking_later_never_comes_later_to_the_contact(
            gap in 1.0..120.0_f64, v in 1.0..40.0_f64, other in 0.0..40.0_f64,
            a in -9.0..2.0_f64, wait in 0.0..2.0_f64,
        ) {
            let threat =
                Threat { gap_m: gap, speed_mps: other, acceleration_mps2: a, passed_m: 9.0 };
            let first_s = |wait_s| {
                let beside = BRAKES.beside(&cruising(v), &threat, wait_s, 0.6);
                beside.map_or(f64::INFINITY, |beside| beside.first_s)
            };
            prop_assert!(first_s(wait + 0.1) <= first_s(wait) + STEP_S);
        }
    }
}
