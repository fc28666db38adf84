//! Which track is the target: the nearest one in the ego's path.
//!
//! A track enters the path when it has been within `enter_half_width_m` of the lane's centre for
//! `confirm_s`, and leaves it when it is beyond `leave_half_width_m`: a vehicle on the line between
//! two lanes does not flicker, and one noisy scan makes no target. A track also counts as within the
//! entry limit when its lateral motion will take its body before the ego's in less than `predict_s`: a
//! cut-in is recognised before the bodies overlap. One that the ego will have passed by then stays out: to
//! brake for it would make the contact.

use scenario::perception::TargetSelection;

use scenario::event::VEHICLE_WIDTH_M;

/// Slower lateral motion is wandering within the lane, m/s.
const LEAST_LATERAL_SPEED_MPS: f64 = 0.3;
/// The lateral speed has to exceed its standard deviation by this factor to be believed.
const BELIEVED_SIGMA: f64 = 2.0;

/// Length that is assumed of the ego, m.
const EGO_LENGTH_M: f64 = 4.5;

/// Limits of the path.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits {
    enter_m: f64,
    leave_m: f64,
    confirm_s: f64,
    predict_s: f64,
}

/// Where a track is across the lanes, and how it moves there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// Lateral position of its centre, m, left positive.
    pub lateral_m: f64,
    /// Lateral speed, m/s.
    pub speed_mps: f64,
    /// Standard deviation of the lateral speed, m/s.
    pub speed_sigma_mps: f64,
    /// Time until the ego has passed it if both keep their speeds, s; infinite if it does not.
    pub passed_s: f64,
}

impl Across {
    /// A position without a motion.
    #[must_use]
    pub fn resting(lateral_m: f64) -> Self {
        Self { lateral_m, speed_mps: 0.0, speed_sigma_mps: 0.0, passed_s: f64::INFINITY }
    }
}

/// One track's membership of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Membership {
    in_path: bool,
    /// Time for which it has been within the entry limit, s.
    within_s: f64,
}

impl PathLimits {
    /// The limits of a scenario. Exact tracks need no confirmation and are not predicted.
    #[must_use]
    pub fn new(selection: &TargetSelection, exact: bool) -> Self {
        Self {
            enter_m: selection.enter_half_width_m.value(),
            leave_m: selection.leave_half_width_m.value(),
            confirm_s: if exact { 0.0 } else { selection.confirm_s.value() },
            predict_s: if exact { 0.0 } else { selection.predict_s.value() },
        }
    }

    /// Membership of a track that was there before the run began: it is confirmed.
    #[must_use]
    pub fn long_known(&self, lateral_m: f64) -> Membership {
        let in_path = lateral_m.abs() <= self.enter_m;
        Membership { in_path, within_s: if in_path { self.confirm_s } else { 0.0 } }
    }

    /// Takes note of the track's lateral motion, `dt_s` after the time before.
    pub fn observe(&self, membership: &mut Membership, across: &Across, dt_s: f64) {
        let offset = across.lateral_m.abs();
        if offset <= self.enter_m || self.cuts_in(across) {
            membership.within_s += dt_s;
            // Sums of periods miss their total by a rounding.
            membership.in_path |= membership.within_s >= self.confirm_s - 1e-9;
        } else {
            membership.within_s = 0.0;
            membership.in_path &= offset <= self.leave_m || self.still_comes(across);
        }
    }

    /// The lateral motion will take the body before the ego's in less than `predict_s`.
    fn cuts_in(&self, across: &Across) -> bool {
        let inward_mps = -across.speed_mps * across.lateral_m.signum();
        inward_mps > LEAST_LATERAL_SPEED_MPS.max(BELIEVED_SIGMA * across.speed_sigma_mps)
            && across.lateral_m.abs() - inward_mps * self.predict_s < VEHICLE_WIDTH_M
            && !passes_first(across, inward_mps)
    }

    /// A track that was taken into the path for its motion goes on with it, if more slowly.
    fn still_comes(&self, across: &Across) -> bool {
        let inward_mps = -across.speed_mps * across.lateral_m.signum();
        let reach_m = 2.0 * self.predict_s * inward_mps;
        inward_mps > 0.5 * LEAST_LATERAL_SPEED_MPS
            && across.lateral_m.abs() - reach_m < VEHICLE_WIDTH_M
            && !passes_first(across, inward_mps)
    }
}

/// The ego passes the track before its body comes before the ego's: to brake would make the contact.
fn passes_first(across: &Across, inward_mps: f64) -> bool {
    (across.lateral_m.abs() - VEHICLE_WIDTH_M) / inward_mps > across.passed_s
}

/// Time until an ego is past a track, s.
#[must_use]
pub fn passed_s(gap_m: f64, relative_speed_mps: f64, length_m: f64) -> f64 {
    let way_m = gap_m + length_m + EGO_LENGTH_M;
    if relative_speed_mps < 0.0 { way_m / -relative_speed_mps } else { f64::INFINITY }
}

impl Membership {
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
        PathLimits::new(&TargetSelection::default(), false)
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
    }

    #[test]
    fn what_is_passed_before_it_comes_in_stays_out() {
        let within = |gap_m: f64, lateral_m: f64| {
            let passed_s = passed_s(gap_m, -10.0, 4.5);
            let across = Across { lateral_m, speed_mps: -1.0, speed_sigma_mps: 0.1, passed_s };
            let mut membership = Membership::default();
            for _ in 0..2 {
                limits().observe(&mut membership, &across, 0.05);
            }
            membership.in_path()
        };
        // 0.9 m to the side take 0.9 s; from 1 m the pass takes 1 s, from behind the bumper less.
        assert!(within(1.0, 2.7) && !within(-1.0, 2.7));
        assert!(within(-1.0, 1.5), "it is in the way already");
        assert_eq!(passed_s(20.0, 0.5, 4.5), f64::INFINITY, "it goes away");
    }

    #[test]
    fn exact_tracks_and_those_of_the_start_count_at_once() {
        let exact = PathLimits::new(&TargetSelection::default(), true);
        let mut membership = Membership::default();
        exact.observe(&mut membership, &Across::resting(1.0), 0.0);
        assert!(membership.in_path());
        assert!(limits().long_known(-1.0).in_path());
        assert!(!limits().long_known(2.0).in_path());
    }
}
