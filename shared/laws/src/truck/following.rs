//! The gap behind a target, which of the three modes is on (equations (14) to (16)), the acceleration there ((17) and
//! (18)), and the brakes as the last resort.

use super::settings::{FollowKeys, GapKeys};
use law::Target;

// Constants of this page are inferred, as the law behind a target is. Those without a reason changed none of the figures
// in `settings` at half and double.

/// Least time headways of d_min, and of d_stop and the desired gap, s.
const LEAST_HEADWAY_S: f64 = 0.8;
const STOP_HEADWAY_S: f64 = 1.0;
/// Deceleration of both in d_stop, the least gap when both brake to a standstill, m/s².
const STOPPING_MPS2: f64 = 4.0;
/// Largest acceleration of mode 1, and least and largest of mode 2, m/s².
const FREE_MOST_MPS2: f64 = 0.25;
const FOLLOW_MPS2: (f64, f64) = (-0.8, 0.3);
/// Mode 3: acceleration behind a target that is at least as fast, m/s², more of it per closing speed, 1/s, and the least
/// one, m/s².
const WARN_MPS2: f64 = -0.8;
const WARN_PER_S: f64 = 0.3;
const WARN_LEAST_MPS2: f64 = -2.5;
/// Jerk while the request falls, and while it rises, m/s³.
pub(super) const JERKS_MPS3: (f64, f64) = (1.5, 1.0);
/// Needed deceleration below which the service brakes are let go, m/s².
const BRAKE_TO_MPS2: f64 = 0.2;

/// Decision of the radar layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// 1: the plan drives.
    #[default]
    Predictive,
    /// 2: the target's speed and gap are followed.
    Follow,
    /// 3: too close; the driver is warned, and brakes may be used.
    Warn,
}

/// Gaps at one moment, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// d_des (14).
    pub desired_m: f64,
    /// d_max, d_min and d_stop (15).
    pub max_m: f64,
    /// Lower end of the band.
    pub min_m: f64,
    /// Below it the driver is warned.
    pub stop_m: f64,
}

impl Spacing {
    /// Gaps at ego speed `speed_mps`, target speed `target_mps` and `grade`. `grade` is the mean from the lead on; 0 if
    /// it is not known.
    pub fn new(keys: &GapKeys, speed_mps: f64, target_mps: f64, grade: f64) -> Self {
        let standstill_m = keys.standstill_distance_m;
        let slope_m = keys.uphill_m * grade.max(0.0) + keys.downhill_m * grade.min(0.0);
        let headway_m = STOP_HEADWAY_S * speed_mps;
        let desired_m = (keys.time_headway_s * target_mps + standstill_m + keys.offset_m - slope_m)
            .max(headway_m + standstill_m);
        let min_m = (desired_m - keys.below_m).max(LEAST_HEADWAY_S * speed_mps + standstill_m);
        let closing = (speed_mps * speed_mps - target_mps * target_mps).max(0.0);
        let stop_m = standstill_m + headway_m + closing / (2.0 * STOPPING_MPS2);
        Self { desired_m, max_m: desired_m + keys.above_m, min_m, stop_m: min_m.min(stop_m) }
    }

    /// Mode (16) after `before`.
    pub fn mode(&self, keys: &GapKeys, target: &Target, before: Mode) -> Mode {
        let relative_mps = target.relative_speed_mps;
        let room_m = (target.gap_m - self.desired_m).max(0.1);
        let risk =
            relative_mps < 0.0 && relative_mps * relative_mps / (2.0 * keys.drag_mps2) > room_m;
        if target.gap_m < self.stop_m {
            Mode::Warn
        } else if target.gap_m > self.max_m + keys.hysteresis_m && !risk {
            Mode::Predictive
        } else if target.gap_m < self.max_m || risk || before == Mode::Warn {
            Mode::Follow
        } else {
            before
        }
    }
}

/// Gap that is to be left when both stand, m, and time headway that a slower lead leaves, s.
const LEFT_M: f64 = 4.0;
const LEFT_S: f64 = 1.0;
/// The lead counts as braking from here on, m/s².
const LEAD_BRAKES_MPS2: f64 = -0.7;
/// Margin over the deceleration that is needed, and the most that is asked for, m/s².
const BRAKING_MARGIN: f64 = 1.25;
const MOST_MPS2: f64 = 6.0;

/// The speed that is aimed at, m/s (17).
pub(crate) fn target_speed_mps(
    keys: &FollowKeys,
    economic_mps: f64,
    target_mps: f64,
    spacing: &Spacing,
    gap_m: f64,
) -> f64 {
    let far = gap_m > spacing.max_m + keys.approach_from_m;
    economic_mps.min(target_mps + if far { keys.approach_mps } else { 0.0 })
}

/// The desired acceleration, m/s² (18).
pub(crate) fn acceleration_mps2(
    keys: &FollowKeys,
    mode: Mode,
    speed_mps: f64,
    aim_mps: f64,
    spacing: &Spacing,
    target: &Target,
) -> f64 {
    match mode {
        Mode::Predictive => {
            (keys.free_per_s * (aim_mps - speed_mps)).clamp(keys.free_min_mps2, FREE_MOST_MPS2)
        }
        Mode::Follow => {
            let error_m = target.gap_m - spacing.desired_m;
            let outside_m =
                (target.gap_m - spacing.max_m).max(0.0) + (target.gap_m - spacing.min_m).min(0.0);
            let per_s = if outside_m == 0.0 { keys.inside_per_s } else { keys.outside_per_s };
            let wanted_mps2 = per_s * (aim_mps - speed_mps)
                + keys.pull_per_s2 * error_m
                + keys.outside_per_s2 * outside_m;
            // With room left, no more deceleration than the room needs.
            let closing_mps = (-target.relative_speed_mps).max(0.0);
            let gentle_mps2 = if wanted_mps2 < 0.0 && closing_mps > 0.0 && error_m > 2.0 {
                wanted_mps2.max(-1.3 * closing_mps * closing_mps / (2.0 * error_m) - 0.02)
            } else {
                wanted_mps2
            };
            gentle_mps2.clamp(FOLLOW_MPS2.0, FOLLOW_MPS2.1)
        }
        Mode::Warn => {
            (WARN_MPS2 + WARN_PER_S * target.relative_speed_mps.min(0.0)).max(WARN_LEAST_MPS2)
        }
    }
}

/// The deceleration that keeps the truck off the target, m/s², 0 when there is time.
///
/// Behind a braking lead the truck must come to rest behind the lead's own stop. Behind a slower lead it must lose the
/// difference before the headway falls to a second.
pub(crate) fn needed_deceleration_mps2(speed_mps: f64, target: &Target) -> f64 {
    let lead_mps = target.lead(speed_mps).speed_mps;
    let closing_mps = (-target.relative_speed_mps).max(0.0);
    let room_m = (target.gap_m - LEFT_M - LEFT_S * lead_mps).max(1.0);
    let closing_mps2 = closing_mps * closing_mps / (2.0 * room_m);
    if target.acceleration_mps2 > LEAD_BRAKES_MPS2 {
        return closing_mps2;
    }
    let lead_stops_m = lead_mps * lead_mps / (-2.0 * target.acceleration_mps2);
    let room_m = (target.gap_m - LEFT_M).max(0.5) + lead_stops_m;
    closing_mps2.max(speed_mps * speed_mps / (2.0 * room_m))
}

/// Means by which the truck keeps its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Means {
    /// Drag.
    Engine,
    EngineBrake,
    /// The service brakes as well, and the acceleration that they must give at least, m/s².
    ServiceBrake(f64),
}

/// The means at one moment, with the memory that keeps the brakes from fluttering.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LastResort {
    on: bool,
}

impl LastResort {
    /// The engine brake below the band, the service brakes too close or when much is needed.
    pub(crate) fn update(
        &mut self,
        keys: &FollowKeys,
        mode: Mode,
        speed_mps: f64,
        spacing: &Spacing,
        target: &Target,
    ) -> Means {
        let needed_mps2 = needed_deceleration_mps2(speed_mps, target);
        let (from_mps2, to_mps2) = (keys.brake_from_mps2, BRAKE_TO_MPS2);
        self.on = needed_mps2 > from_mps2 || (self.on && needed_mps2 > to_mps2);
        if self.on {
            Means::ServiceBrake(-(BRAKING_MARGIN * needed_mps2).min(MOST_MPS2))
        } else if mode == Mode::Warn {
            Means::ServiceBrake(0.0)
        } else if target.gap_m < spacing.min_m || needed_mps2 > to_mps2 {
            Means::EngineBrake
        } else {
            Means::Engine
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_smaller_uphill_and_larger_downhill() {
        let keys = &GapKeys::default();
        let flat = Spacing::new(keys, 20.0, 20.0, 0.0);
        assert_eq!(flat.desired_m, 51.0);
        assert_eq!(Spacing::new(keys, 20.0, 20.0, 0.02).desired_m, 46.0);
        assert_eq!(Spacing::new(keys, 20.0, 20.0, -0.02).desired_m, 61.0);
        assert_eq!((flat.max_m, flat.min_m, flat.stop_m), (66.0, 39.0, 25.0));
        assert_eq!(Spacing::new(keys, 20.0, 0.0, 0.0).desired_m, 25.0);
    }

    #[test]
    fn modes_follow_the_gap_with_hysteresis() {
        let keys = &GapKeys::default();
        let spacing = Spacing::new(keys, 20.0, 20.0, 0.0);
        let at =
            |gap_m, relative_speed_mps| Target { gap_m, relative_speed_mps, ..Target::default() };
        assert_eq!(spacing.mode(keys, &at(24.0, 0.0), Mode::Follow), Mode::Warn);
        assert_eq!(spacing.mode(keys, &at(67.0, 0.0), Mode::Follow), Mode::Follow);
        assert_eq!(spacing.mode(keys, &at(67.0, 0.0), Mode::Predictive), Mode::Predictive);
        assert_eq!(spacing.mode(keys, &at(70.0, 0.0), Mode::Follow), Mode::Predictive);
        assert_eq!(spacing.mode(keys, &at(100.0, -4.0), Mode::Predictive), Mode::Follow);
        assert_eq!(spacing.mode(keys, &at(27.0, 0.0), Mode::Warn), Mode::Follow);
    }
}
