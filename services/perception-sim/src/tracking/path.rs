//! Choice of the target: the nearest track in the ego's path.
//!
//! A track enters the path when it has been within `enter_half_width_m` of the lane's centre for `confirm_s`. It leaves
//! the path beyond `leave_half_width_m`. So a vehicle on the line between two lanes does not flicker, and one noisy
//! scan makes no target. An estimated path is left only after [`Numbers::course_leave_s`].
//!
//! A belief about the road ([`super::belief`]) replaces these limits by the probability of being in the ego's way. The
//! more braking a track would need, the less probability is enough. A vehicle that drives keeps its lane, and
//! meets other errors of the belief wherever it comes. So its probability is a mean over time. One that stands, or
//! changes lanes, has the probability of the scan.
//!
//! A track also counts as within the entry limit if its body comes before the ego's in less than `predict_s`, by its
//! lateral motion. So a cut-in is recognised before the bodies overlap. A track that the ego will be beside by then, or
//! before, stays out, even with a cruise control's hardest braking. Braking only makes the time beside it longer.

use scenario::perception::TargetSelection;

use scenario::event::VEHICLE_WIDTH_M;

use super::numbers::Numbers;

/// Limits of the path.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits {
    enter_m: f64,
    leave_m: f64,
    confirm_s: f64,
    predict_s: f64,
    numbers: Numbers,
}

/// Place and motion of a track across the lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// Lateral position of its centre, m, left positive.
    pub lateral_m: f64,
    /// Lateral speed, m/s.
    pub speed_mps: f64,
    /// Standard deviation of the lateral speed, m/s.
    pub speed_sigma_mps: f64,
    /// Probability that it is in the ego's way, where that is doubtful.
    pub in_way: Option<f64>,
    /// It drives along the road.
    pub drives: bool,
    /// It has been seen to move.
    pub has_moved: bool,
    /// Approach of the ego to it.
    pub approach: Approach,
}

/// Approach of the ego to a track along the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Speed of the track minus the ego's, m/s.
    pub relative_speed_mps: f64,
}

impl Across {
    /// A position without a motion.
    pub fn resting(lateral_m: f64) -> Self {
        let approach = Approach { gap_m: f64::INFINITY, relative_speed_mps: 0.0 };
        Self {
            lateral_m,
            speed_mps: 0.0,
            speed_sigma_mps: 0.0,
            in_way: None,
            drives: false,
            has_moved: false,
            approach,
        }
    }

    /// The same beside a path that is believed. The standard deviation of the path's heading, as a lateral speed, is
    /// `crossing_mps`.
    pub fn on_course(self, in_way: f64, crossing_mps: f64) -> Self {
        let speed_sigma_mps = libm::hypot(self.speed_sigma_mps, crossing_mps);
        Self { in_way: Some(in_way), speed_sigma_mps, ..self }
    }
}

/// Braking that is comfortable, m/s².
pub(super) const COMFORT_MPS2: f64 = 2.5;
/// Hardest braking that a law asks for, m/s²: the default of `controller.min_request_mps2`. A track that needs more is as
/// late as it can be, so that the price ends there. Else each vehicle beside the way is worth braking as it comes near.
const HARDEST_MPS2: f64 = 6.0;
/// Braking that is as bad as braking for nothing, m/s²: the most of a cruise control (ISO 15622). Those behind do not
/// expect it.
const FOR_NOTHING_MPS2: f64 = 5.0;
/// Probability from which a vehicle is followed that needs no braking.
const FOLLOWED: f64 = 0.8;
/// Time over which a driving vehicle's probability is a mean, s: it passes the 60 m in which a curve begins at 30 m/s.
const KEEPS_LANE_S: f64 = 2.0;
/// Lateral speed from which it may be changing lanes, in standard deviations.
const CHANGES_SIGMA: f64 = 2.0;
/// A probability is at least this far from 0 and 1: a belief of 64 hypotheses is no surer.
const LEAST: f64 = 0.01;
/// A target is given up at this share of the probability at which it is taken.
const LEAVES_SHARE: f64 = 0.25;

/// Probability of being in the way from which a track is worth this braking, m/s².
///
/// Braking late costs the square of the braking that is then needed, and braking for nothing costs that of
/// [`FOR_NOTHING_MPS2`]. A track is worth braking if P · a² > (1 - P) · 5². The law eases off for a track that has not
/// moved, and decides by its doubt whether to brake. Easing off for nothing is as bad as comfortable braking.
fn enter_at(braking_mps2: f64, has_moved: bool) -> f64 {
    let for_nothing_mps2 = if has_moved { FOR_NOTHING_MPS2 } else { COMFORT_MPS2 };
    let late = braking_mps2.min(HARDEST_MPS2) / for_nothing_mps2;
    (1.0 / (1.0 + late * late)).min(FOLLOWED)
}

impl Approach {
    /// Constant braking that keeps the ego behind the track at its present speed, m/s².
    pub(super) fn braking_mps2(&self) -> f64 {
        let closing_mps = (-self.relative_speed_mps).max(0.0);
        closing_mps * closing_mps / (2.0 * self.gap_m.max(1.0))
    }

    /// True if the ego is beside the track or before it in `time_s` even if it brakes.
    fn is_beside_in(&self, time_s: f64, numbers: &Numbers) -> bool {
        let braked_s = (time_s - numbers.braking_late_s).max(0.0);
        let gained_m = 0.5 * numbers.cruise_braking_mps2 * braked_s * braked_s;
        self.gap_m + self.relative_speed_mps * time_s + gained_m < 0.0
    }
}

/// One track's membership of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Membership {
    in_path: bool,
    /// Time for which it has been within the entry limit, s.
    within_s: f64,
    /// Time for which it has been beyond the limit to stay, s.
    beyond_s: f64,
    /// Logarithm of the odds of being in the ego's way, where that is doubtful.
    log_odds: Option<f64>,
    /// Probability that it stands beside the ego's way; 0 of one that has moved.
    pub(super) doubt_share: f64,
}

impl PathLimits {
    /// The limits of a scenario. Exact tracks need no confirmation and are not predicted.
    pub fn new(selection: &TargetSelection, exact: bool, numbers: &Numbers) -> Self {
        Self {
            enter_m: selection.enter_half_width_m.value(),
            leave_m: selection.leave_half_width_m.value(),
            confirm_s: if exact { 0.0 } else { selection.confirm_s.value() },
            predict_s: if exact { 0.0 } else { selection.predict_s.value() },
            numbers: *numbers,
        }
    }

    /// Takes note of the track's lateral motion, `dt_s` after the time before.
    pub fn observe(&self, membership: &mut Membership, across: &Across, dt_s: f64) {
        let in_way = across.in_way.map(|now| membership.weigh(now, across, dt_s));
        membership.doubt_share = in_way.filter(|_| !across.has_moved).map_or(0.0, |p| 1.0 - p);
        let (enters, stays) = self.within(&Across { in_way, ..*across });
        let Numbers { wandering_mps, inward_sigma, course_inward_sigma, .. } = self.numbers;
        // Corrections of an estimated course last for some scans, and look like a motion across it.
        let sigma = if in_way.is_some() { course_inward_sigma } else { inward_sigma };
        let moves_mps = wandering_mps.max(sigma * across.speed_sigma_mps);
        if enters || self.comes(across, moves_mps, self.predict_s) {
            membership.within_s += dt_s;
            // Sums of periods miss their total by a rounding.
            membership.in_path |= membership.within_s >= self.confirm_s - 1e-9;
            membership.beyond_s = 0.0;
        } else {
            membership.within_s = 0.0;
            // One that was taken for its motion goes on with it, if more slowly.
            let still_comes = || self.comes(across, 0.5 * wandering_mps, 2.0 * self.predict_s);
            let is_beyond = !stays && !still_comes();
            membership.beyond_s = if is_beyond { membership.beyond_s + dt_s } else { 0.0 };
            // The course lags behind a curve's begin, and takes the lead out of the path for some scans.
            let waits_s = if in_way.is_some() { self.numbers.course_leave_s } else { 0.0 };
            membership.in_path &= !is_beyond || membership.beyond_s < waits_s;
        }
    }

    /// It is within the limits to enter and to stay.
    fn within(&self, across: &Across) -> (bool, bool) {
        if let Some(probability) = across.in_way {
            let enter = enter_at(across.approach.braking_mps2(), across.has_moved);
            return (probability > enter, probability >= LEAVES_SHARE * enter);
        }
        let offset_m = across.lateral_m.abs();
        (offset_m <= self.enter_m, offset_m <= self.leave_m)
    }

    /// A lateral motion of more than `least_mps` takes the body before the ego's in less than `time_s`, and braking helps
    /// then: the ego is not beside it in spite of braking.
    fn comes(&self, across: &Across, least_mps: f64, time_s: f64) -> bool {
        let inward_mps = -across.speed_mps * across.lateral_m.signum();
        let off_m = across.lateral_m.abs() - VEHICLE_WIDTH_M;
        let comes_s = off_m / inward_mps;
        inward_mps > least_mps
            && comes_s < time_s
            && !(comes_s > 0.0 && across.approach.is_beside_in(comes_s, &self.numbers))
    }
}

impl Membership {
    /// Probability of being in the ego's way, by this scan and those before.
    fn weigh(&mut self, now: f64, across: &Across, dt_s: f64) -> f64 {
        let now = now.clamp(LEAST, 1.0 - LEAST);
        let now = libm::log(now / (1.0 - now));
        let keeps_lane =
            across.drives && across.speed_mps.abs() <= CHANGES_SIGMA * across.speed_sigma_mps;
        let log_odds = match self.log_odds {
            Some(before) if keeps_lane => before + (now - before) * (dt_s / KEEPS_LANE_S).min(1.0),
            _ => now,
        };
        self.log_odds = Some(log_odds);
        1.0 / (1.0 + libm::exp(-log_odds))
    }

    /// The track is in the ego's path.
    pub fn in_path(&self) -> bool {
        self.in_path
    }
}

#[cfg(test)]
mod tests;
