//! Limits of the study, and the worst window of a drive against a limit over speed. A changed limit is an entry of
//! its own in CHANGELOG.md.
//!
//! All stand since 2026-11-21 unless they say another date. Source: ISO 15622:2018, as secondary sources give it.
//! "Chosen" marks a value without that source.

use supervise::DriveStep;

/// Time gap at which a target must be acquired at the latest, s.
pub const LONGEST_TIME_GAP_S: f64 = 2.2;
/// Shortest time gap that a law may keep, s.
pub const SHORTEST_TIME_GAP_S: f64 = 0.8;
/// Least gap during an automatic deceleration, m. Chosen.
pub const LEAST_GAP_M: f64 = 0.5;
/// Speed that the ego may lose beside slower traffic, m/s. Chosen.
pub const SLOWER_BESIDE_MPS: f64 = 2.0;
/// Difference of a request from the cruise's that counts as a reaction, m/s². Chosen.
pub const REACTION_MPS2: f64 = 0.05;
/// Speed below which a vehicle stands, m/s. Chosen.
pub const STANDING_MPS: f64 = 0.05;
/// Largest speed of a vehicle that holds, m/s. Chosen.
pub const CREEP_MPS: f64 = 2.0 * STANDING_MPS;
/// Time for which the ego has to stand still, s.
pub const HOLD_S: f64 = 3.0;
/// Time in which the ego has to follow a lead that moves off, s. Chosen.
pub const MOVE_OFF_S: f64 = 3.0;

/// A class of curve capability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Class {
    pub name: &'static str,
    pub radius_m: f64,
    /// Design value of the lateral acceleration, m/s².
    pub lateral_mps2: f64,
}

impl Class {
    /// All classes. Since 2026-11-26; ISO 15622:2010, as secondary sources give it.
    pub const ALL: [Self; 3] = [
        Self { name: "ii", radius_m: 500.0, lateral_mps2: 2.0 },
        Self { name: "iii", radius_m: 250.0, lateral_mps2: 2.3 },
        Self { name: "iv", radius_m: 125.0, lateral_mps2: 2.3 },
    ];
}

/// Allowed excess of the ego's lateral acceleration, m/s². Since 2026-11-26. Chosen: 1 m/s more, and the driver's
/// steering.
pub const CURVE_LATERAL_MARGIN_MPS2: f64 = 0.3;
/// Least time gap at which the ego must have begun to slow down, as a share of the one it kept. Since 2026-11-26; ISO
/// 15622:2010, as secondary sources give it.
pub const LEAST_SHARE_OF_TIME_GAP: f64 = 2.0 / 3.0;
/// Time for which the ego follows in the curve before the target slows down, s. Since 2026-11-26; the same source.
pub const STEADY_S: f64 = 10.0;
/// Deceleration from which the ego slows down, m/s². Since 2026-11-26. Chosen: more than following needs.
pub const BEGINS_TO_SLOW_MPS2: f64 = 0.3;
/// Time for which the target may be lost, or the neighbour followed, s. Since 2026-11-26. Chosen.
pub const MAX_TARGET_LOST_S: f64 = 0.0;

/// Radii of the bends, m, and speeds before them, m/s. Since 2026-11-28. Chosen: from a street's corner to a motorway,
/// the most braking and some of the least for each.
pub const BENDS: [(u16, u16); 8] =
    [(30, 15), (30, 40), (60, 15), (60, 25), (125, 25), (125, 40), (250, 33), (500, 40)];
/// Largest lateral acceleration in a bend that shows in time, as a share of the accepted one. Since 2026-11-28. Chosen:
/// passengers do not feel a tenth more.
pub const BEND_LATERAL_SHARE: f64 = 1.1;
/// Hardest braking for a bend that shows in time, and for another one, m/s². Since 2026-11-28. The first is a comfortable
/// driver's limit, the second ISO 15622's above 20 m/s.
pub const BEND_BRAKING_MPS2: (f64, f64) = (2.5, 3.5);

/// Speeds between which the limits fall linearly, m/s.
const SLOW_MPS: f64 = 5.0;
const FAST_MPS: f64 = 20.0;

/// A limit that depends on the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// At 5 m/s and below.
    slow: f64,
    /// At 20 m/s and above.
    fast: f64,
    /// Time over which the figure is averaged, s.
    window_s: f64,
}

/// Deceleration, m/s², averaged over 2 s.
pub const DECELERATION: Limit = Limit { slow: 5.0, fast: 3.5, window_s: 2.0 };
/// Acceleration, m/s², averaged over 2 s.
pub const ACCELERATION: Limit = Limit { slow: 4.0, fast: 2.0, window_s: 2.0 };
/// Jerk while the deceleration builds up, m/s³, averaged over 1 s.
pub const JERK: Limit = Limit { slow: 5.0, fast: 2.5, window_s: 1.0 };

impl Limit {
    pub fn at(self, speed_mps: f64) -> f64 {
        let share = ((speed_mps - SLOW_MPS) / (FAST_MPS - SLOW_MPS)).clamp(0.0, 1.0);
        self.slow + share * (self.fast - self.slow)
    }

    /// Mean and limit of the window whose mean change of `quantity` per second comes nearest to its limit, or is
    /// farthest beyond it. The limit is that at the speed in which the window begins.
    /// `None` for a drive shorter than a window.
    pub fn worst(
        self,
        steps: &[DriveStep],
        quantity: impl Fn(&DriveStep) -> f64,
    ) -> Option<(f64, f64)> {
        let windows = steps.iter().filter_map(|begin| {
            let until_s = begin.time_s + self.window_s - 1e-6;
            let end = steps.get(steps.partition_point(|step| step.time_s < until_s))?;
            let mean = (quantity(end) - quantity(begin)) / (end.time_s - begin.time_s);
            Some((mean, self.at(begin.speed_mps)))
        });
        windows.reduce(|worst, one| if one.0 - one.1 > worst.0 - worst.1 { one } else { worst })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Braking with `deceleration_mps2` from 1 s to 4 s.
    fn drive(deceleration_mps2: f64) -> Vec<DriveStep> {
        (0..600)
            .map(|step| {
                let time_s = 0.01 * f64::from(step);
                let braking_s = (time_s - 1.0).clamp(0.0, 3.0);
                let brakes = (1.0..4.0).contains(&time_s);
                DriveStep {
                    time_s,
                    speed_mps: 20.0 - deceleration_mps2 * braking_s,
                    acceleration_mps2: if brakes { -deceleration_mps2 } else { 0.0 },
                    ..DriveStep::default()
                }
            })
            .collect()
    }

    #[test]
    fn limits_fall_between_5_and_20_metres_a_second() {
        assert_eq!((DECELERATION.at(0.0), DECELERATION.at(30.0)), (5.0, 3.5));
        assert!((DECELERATION.at(12.5) - 4.25).abs() < 1e-12);
        assert!((JERK.at(12.5) - 3.75).abs() < 1e-12);
    }

    #[test]
    fn the_worst_window_is_the_one_nearest_to_its_limit() {
        let steps = drive(3.0);
        let worst = DECELERATION.worst(&steps, |step| -step.speed_mps).expect("6 s hold windows");
        assert!((worst.0 - 3.0).abs() < 1e-9 && worst.1 < 3.6, "{worst:?}");
        let jerk = JERK.worst(&steps, |step| -step.acceleration_mps2).expect("6 s hold windows");
        assert!((jerk.0 - 3.0).abs() < 1e-9 && (jerk.1 - 2.5).abs() < 1e-9, "{jerk:?}");
        assert_eq!(DECELERATION.worst(&steps[..100], |step| -step.speed_mps), None);
    }
}
