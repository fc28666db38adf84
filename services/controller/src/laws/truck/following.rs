//! Accelerations behind a target: equations (17) and (18), and the brakes as the last resort.

use super::settings::FollowKeys;
use super::spacing::{Mode, Spacing};
use super::target_filter::Estimate;

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
    target: &Estimate,
) -> f64 {
    match mode {
        Mode::Predictive => {
            (keys.free_per_s * (aim_mps - speed_mps)).clamp(keys.free_min_mps2, keys.free_max_mps2)
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
            gentle_mps2.clamp(keys.follow_min_mps2, keys.follow_max_mps2)
        }
        Mode::Warn => (keys.warn_mps2 + keys.warn_per_s * target.relative_speed_mps.min(0.0))
            .max(keys.warn_min_mps2),
    }
}

/// The deceleration that keeps the truck off the target, m/s², 0 when there is time.
///
/// Behind a braking lead the truck must come to rest behind the lead's own stop. Behind a slower lead it must lose the
/// difference before the headway falls to a second.
pub(crate) fn needed_deceleration_mps2(speed_mps: f64, target: &Estimate) -> f64 {
    let lead_mps = (speed_mps + target.relative_speed_mps).max(0.0);
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
    /// The engine brake.
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
        target: &Estimate,
    ) -> Means {
        let needed_mps2 = needed_deceleration_mps2(speed_mps, target);
        let (from_mps2, to_mps2) = (keys.brake_from_mps2, keys.brake_to_mps2);
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
