//! Choice of the target: the nearest track in the ego's path.
//!
//! A track enters the path when it has been within `enter_half_width_m` of the lane's centre for `confirm_s`. It leaves
//! the path beyond `leave_half_width_m`. So a vehicle on the line between two lanes does not flicker, and one noisy
//! scan makes no target. An estimated path is left only after [`Numbers::course_leave_s`].
//!
//! Where the road ahead is a belief ([`super::belief`]), the probability of being in the ego's way replaces these
//! limits. The more braking a track would need, the less probability is enough. A vehicle that drives keeps its lane, and
//! meets other errors of the belief wherever it comes. So its probability is a mean over time. One that stands, or
//! changes lanes, has the probability of the scan.
//!
//! A track also counts as within the entry limit if its body comes before the ego's in less than `predict_s`, by its
//! lateral motion. So a cut-in is recognised before the bodies overlap. A track that the ego will have passed by then
//! stays out. So does a track that it will be beside by then, even with a cruise control's hardest braking. Braking only
//! makes the time beside it longer.

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
    /// Length of the track, m.
    pub length_m: f64,
}

impl Across {
    /// A position without a motion.
    #[must_use]
    pub fn resting(lateral_m: f64) -> Self {
        let approach = Approach { gap_m: f64::INFINITY, relative_speed_mps: 0.0, length_m: 0.0 };
        Self {
            lateral_m,
            speed_mps: 0.0,
            speed_sigma_mps: 0.0,
            in_way: None,
            drives: false,
            approach,
        }
    }
}

impl Across {
    /// The same beside a path that is believed. The standard deviation of the path's heading, as a lateral speed, is
    /// `crossing_mps`.
    #[must_use]
    pub fn on_course(self, in_way: f64, crossing_mps: f64) -> Self {
        let speed_sigma_mps = libm::hypot(self.speed_sigma_mps, crossing_mps);
        Self { in_way: Some(in_way), speed_sigma_mps, ..self }
    }
}

/// Braking that is comfortable, m/s².
const COMFORT_MPS2: f64 = 2.5;
/// Price of braking for nothing. It surprises those behind, so it is as bad as having to brake with 5 m/s², the most of
/// a cruise control (ISO 15622).
const FOR_NOTHING: f64 = 4.0;
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
/// Braking late costs the square of the braking that is then needed, in multiples of what is comfortable. Braking for
/// nothing costs [`FOR_NOTHING`]. A track is worth braking if P · (a / 2.5)² > (1 - P) · 4.
fn enter_at(braking_mps2: f64) -> f64 {
    let late = braking_mps2 / COMFORT_MPS2;
    (1.0 / (1.0 + late * late / FOR_NOTHING)).min(FOLLOWED)
}

impl Approach {
    /// Constant braking that keeps the ego behind the track at its present speed, m/s².
    fn braking_mps2(&self) -> f64 {
        let closing_mps = (-self.relative_speed_mps).max(0.0);
        closing_mps * closing_mps / (2.0 * self.gap_m.max(1.0))
    }

    /// True if the ego has passed the track in `time_s` with both speeds constant.
    fn is_passed_in(&self, time_s: f64, numbers: &Numbers) -> bool {
        self.gap_m + self.relative_speed_mps * time_s < -(self.length_m + numbers.ego_length_m)
    }

    /// True if the ego is beside the track in `time_s` even if it brakes.
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
}

impl PathLimits {
    /// The limits of a scenario. Exact tracks need no confirmation and are not predicted.
    #[must_use]
    pub fn new(selection: &TargetSelection, exact: bool, numbers: &Numbers) -> Self {
        Self {
            enter_m: selection.enter_half_width_m.value(),
            leave_m: selection.leave_half_width_m.value(),
            confirm_s: if exact { 0.0 } else { selection.confirm_s.value() },
            predict_s: if exact { 0.0 } else { selection.predict_s.value() },
            numbers: *numbers,
        }
    }

    /// Membership of a track that was there before the run began: it is confirmed.
    #[must_use]
    pub fn long_known(&self, lateral_m: f64) -> Membership {
        let in_path = lateral_m.abs() <= self.enter_m;
        let within_s = if in_path { self.confirm_s } else { 0.0 };
        Membership { in_path, within_s, ..Membership::default() }
    }

    /// Takes note of the track's lateral motion, `dt_s` after the time before.
    pub fn observe(&self, membership: &mut Membership, across: &Across, dt_s: f64) {
        let in_way = across.in_way.map(|now| membership.weigh(now, across, dt_s));
        let (enters, stays) = self.within(&Across { in_way, ..*across });
        if enters || self.cuts_in(across) {
            membership.within_s += dt_s;
            // Sums of periods miss their total by a rounding.
            membership.in_path |= membership.within_s >= self.confirm_s - 1e-9;
            membership.beyond_s = 0.0;
        } else {
            membership.within_s = 0.0;
            let is_beyond = !stays && !self.still_comes(across);
            membership.beyond_s = if is_beyond { membership.beyond_s + dt_s } else { 0.0 };
            // The course lags behind a curve's begin, and takes the lead out of the path for some scans.
            let waits_s = if in_way.is_some() { self.numbers.course_leave_s } else { 0.0 };
            membership.in_path &= !is_beyond || membership.beyond_s < waits_s;
        }
    }

    /// It is within the limits to enter and to stay.
    fn within(&self, across: &Across) -> (bool, bool) {
        if let Some(probability) = across.in_way {
            let enter = enter_at(across.approach.braking_mps2());
            return (probability > enter, probability >= LEAVES_SHARE * enter);
        }
        let offset_m = across.lateral_m.abs();
        (offset_m <= self.enter_m, offset_m <= self.leave_m)
    }

    /// The lateral motion will take the body before the ego's in less than `predict_s`.
    fn cuts_in(&self, across: &Across) -> bool {
        let Numbers { wandering_mps, inward_sigma, course_inward_sigma, .. } = self.numbers;
        // Corrections of an estimated course last for some scans, and look like a motion across it.
        let inward_sigma = if across.in_way.is_some() { course_inward_sigma } else { inward_sigma };
        let inward_mps = -across.speed_mps * across.lateral_m.signum();
        inward_mps > wandering_mps.max(inward_sigma * across.speed_sigma_mps)
            && across.lateral_m.abs() - inward_mps * self.predict_s < VEHICLE_WIDTH_M
            && !braking_is_vain(across, inward_mps, &self.numbers)
    }

    /// A track that was taken into the path for its motion goes on with it, if more slowly.
    fn still_comes(&self, across: &Across) -> bool {
        let inward_mps = -across.speed_mps * across.lateral_m.signum();
        let reach_m = 2.0 * self.predict_s * inward_mps;
        inward_mps > 0.5 * self.numbers.wandering_mps
            && across.lateral_m.abs() - reach_m < VEHICLE_WIDTH_M
            && !braking_is_vain(across, inward_mps, &self.numbers)
    }
}

/// Braking does not help then. When the track's body comes before the ego's, the ego has passed it, or is beside it in
/// spite of braking.
fn braking_is_vain(across: &Across, inward_mps: f64, numbers: &Numbers) -> bool {
    let comes_s = (across.lateral_m.abs() - VEHICLE_WIDTH_M) / inward_mps;
    comes_s > 0.0
        && (across.approach.is_passed_in(comes_s, numbers)
            || across.approach.is_beside_in(comes_s, numbers))
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
    #[must_use]
    pub fn in_path(&self) -> bool {
        self.in_path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> PathLimits {
        PathLimits::new(&TargetSelection::default(), false, &Numbers::DEFAULT)
    }

    fn history(laterals: &[f64]) -> Vec<bool> {
        let (limits, mut membership) = (limits(), Membership::default());
        laterals
            .iter()
            .map(|&lateral_m| {
                limits.observe(&mut membership, &Across::resting(lateral_m), 0.05);
                membership.in_path()
            })
            .collect()
    }

    #[test]
    fn a_cut_in_is_a_target_when_it_is_confirmed() {
        assert_eq!(
            history(&[3.0, 2.0, 1.7, 1.6, 1.5, 1.0]),
            [false, false, false, false, true, true]
        );
    }

    #[test]
    fn one_noisy_scan_makes_no_target() {
        assert_eq!(history(&[1.9, 1.5, 1.9, -1.5, 1.9]), [false; 5]);
    }

    #[test]
    fn a_cut_out_ends_at_the_wider_limit() {
        assert_eq!(
            history(&[0.0, 0.0, 1.9, -2.2, 2.3, 1.9]),
            [false, true, true, true, false, false]
        );
    }

    #[test]
    fn a_cut_in_is_recognised_before_the_bodies_overlap() {
        let within = |across: &Across| {
            let mut membership = Membership::default();
            for _ in 0..2 {
                limits().observe(&mut membership, across, 0.05);
            }
            membership.in_path()
        };
        let moving = |lateral_m, speed_mps| Across {
            speed_mps,
            speed_sigma_mps: 0.1,
            ..Across::resting(lateral_m)
        };
        assert!(within(&moving(2.7, -1.0)) && within(&moving(-2.7, 1.0)));
        assert!(!within(&moving(3.1, -1.0)), "that is more than 1.2 s ahead");
        assert!(!within(&moving(2.7, 1.0)) && !within(&moving(-2.7, -1.0)), "it moves away");
        assert!(!within(&moving(2.0, -0.25)), "it wanders in its lane");
        let vague = Across { speed_sigma_mps: 0.6, ..moving(2.7, -1.0) };
        assert!(!within(&vague), "the motion is not certain");
        let on_course = |speed_mps: f64| moving(2.7, speed_mps).on_course(0.1, 0.24);
        assert!(within(&on_course(-1.2)) && !within(&on_course(-1.0)), "the course is not certain");
    }

    #[test]
    fn threats_that_braking_does_not_avoid_stay_out() {
        let within = |gap_m: f64, relative_speed_mps: f64, lateral_m: f64| {
            let approach = Approach { gap_m, relative_speed_mps, length_m: 4.5 };
            let across = Across {
                lateral_m,
                speed_mps: -1.0,
                speed_sigma_mps: 0.1,
                in_way: None,
                drives: true,
                approach,
            };
            let mut membership = Membership::default();
            for _ in 0..2 {
                limits().observe(&mut membership, &across, 0.05);
            }
            membership.in_path()
        };
        // 0.9 m to the side take 0.9 s, in which the cruise control wins 0.4 m.
        assert!(!within(-1.0, -10.0, 2.7), "it is passed by then");
        assert!(!within(8.4, -10.0, 2.7), "the ego is beside it by then");
        assert!(within(8.8, -10.0, 2.7), "the ego stays behind it if it brakes");
        assert!(within(-1.0, -10.0, 1.5), "it is in the way already");
        assert!(within(1.0, 0.5, 2.7), "it goes away");
    }

    #[test]
    fn prices_decide_where_the_path_is_doubtful() {
        // 20 m/s towards what stands: 2.5 m/s² at 80 m, 5 m/s² at 40 m.
        let within = |gap_m: f64, probability: f64| {
            let approach = Approach { gap_m, relative_speed_mps: -20.0, length_m: 4.5 };
            let in_way = Some(probability);
            limits().within(&Across { in_way, approach, ..Across::resting(0.0) })
        };
        assert_eq!(within(80.0, 0.81), (true, true));
        assert_eq!(within(80.0, 0.79), (false, true), "braking for nothing is four times as bad");
        assert_eq!(within(80.0, 0.19), (false, false));
        assert_eq!(within(40.0, 0.51), (true, true), "as bad as braking with 5 m/s²");
        assert_eq!((within(40.0, 0.49), within(40.0, 0.12)), ((false, true), (false, false)));
        // A lead that goes along needs no braking.
        let in_way = Some(0.81);
        let lead = Across { in_way, ..Across::resting(3.5) };
        assert_eq!(limits().within(&lead), (true, true), "the probability alone decides");
    }

    #[test]
    fn an_estimated_path_is_left_after_a_time() {
        let (limits, mut membership) = (limits(), limits().long_known(0.0));
        let mut scans_in_path = |in_way: f64, scans: u32| {
            let across = Across::resting(0.0).on_course(in_way, 0.0);
            (0..scans)
                .filter(|_| {
                    limits.observe(&mut membership, &across, 0.05);
                    membership.in_path()
                })
                .count()
        };
        assert_eq!(scans_in_path(0.1, 9), 9, "it may come back");
        assert_eq!(scans_in_path(0.3, 1), 1);
        let stays = scans_in_path(0.1, 20);
        assert!((9..=10).contains(&stays), "{stays} scans");
    }

    #[test]
    fn exact_tracks_and_those_of_the_start_count_at_once() {
        let exact = PathLimits::new(&TargetSelection::default(), true, &Numbers::DEFAULT);
        let mut membership = Membership::default();
        exact.observe(&mut membership, &Across::resting(1.0), 0.0);
        assert!(membership.in_path());
        assert!(limits().long_known(-1.0).in_path());
        assert!(!limits().long_known(2.0).in_path());
    }

    #[test]
    fn an_approach_ends_beside_the_track_or_behind_it() {
        let approach = Approach { gap_m: 10.0, relative_speed_mps: -10.0, length_m: 4.5 };
        let passed = |time_s: f64| approach.is_passed_in(time_s, &Numbers::DEFAULT);
        // Both lengths are 9 m.
        assert!(passed(1.91) && !passed(1.89) && !passed(-1.91));
        let beside = |gap_m: f64, time_s: f64| {
            Approach { gap_m, ..approach }.is_beside_in(time_s, &Numbers::DEFAULT)
        };
        // From 0.5 s on the ego brakes with 5 m/s²: it gains 2.5 m in a second.
        assert!(beside(12.4, 1.5) && !beside(12.6, 1.5));
        assert!(beside(3.9, 0.4) && !beside(4.1, 0.4));
    }

    #[test]
    fn a_heading_that_is_not_known_makes_a_lateral_speed_uncertain() {
        let across = Across { speed_sigma_mps: 0.3, ..Across::resting(1.0) };
        let on_course = across.on_course(0.7, 0.4);
        assert!((on_course.speed_sigma_mps - 0.5).abs() < 1e-12 && on_course.in_way == Some(0.7));
    }

    /// In the path for its motion: it goes on at half of the speed, and for twice the time.
    #[test]
    fn an_object_that_moves_in_still_comes_if_more_slowly() {
        let comes = |lateral_m: f64, speed_mps: f64| {
            let across = Across { speed_mps, ..Across::resting(lateral_m) };
            limits().still_comes(&across)
        };
        // 1.8 m, the bodies' width, and 2.4 s.
        assert!(comes(2.3, -0.25) && !comes(2.5, -0.25) && comes(-2.3, 0.25) && !comes(-2.5, 0.25));
        assert!(comes(1.9, -0.16) && !comes(1.9, -0.14) && !comes(2.3, 0.25));
    }
}
