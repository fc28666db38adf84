//! Which track is the target: the nearest one in the ego's path.
//!
//! A track enters the path when it has been within `enter_half_width_m` of the lane's centre for
//! `confirm_s`, and leaves it when it is beyond `leave_half_width_m`: a vehicle on the line between
//! two lanes does not flicker, and one glance of noise makes no target.

use scenario::perception::TargetSelection;

/// Limits of the path.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits {
    enter_m: f64,
    leave_m: f64,
    confirm_s: f64,
}

/// One track's membership of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Membership {
    in_path: bool,
    /// Time for which it has been within the entry limit, s.
    within_s: f64,
}

impl PathLimits {
    /// The limits of a scenario. Exact tracks need no confirmation.
    #[must_use]
    pub fn new(selection: &TargetSelection, exact: bool) -> Self {
        Self {
            enter_m: selection.enter_half_width_m.value(),
            leave_m: selection.leave_half_width_m.value(),
            confirm_s: if exact { 0.0 } else { selection.confirm_s.value() },
        }
    }

    /// Membership of a track that was there before the run began: nobody need confirm it.
    #[must_use]
    pub fn long_known(&self, lateral_m: f64) -> Membership {
        let in_path = lateral_m.abs() <= self.enter_m;
        Membership { in_path, within_s: if in_path { self.confirm_s } else { 0.0 } }
    }

    /// Takes note of the track's lateral position, `dt_s` after the time before.
    pub fn observe(&self, membership: &mut Membership, lateral_m: f64, dt_s: f64) {
        let offset = lateral_m.abs();
        if offset <= self.enter_m {
            membership.within_s += dt_s;
            // Sums of periods miss their total by a rounding.
            membership.in_path |= membership.within_s >= self.confirm_s - 1e-9;
        } else {
            membership.within_s = 0.0;
            membership.in_path &= offset <= self.leave_m;
        }
    }
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
                limits.observe(&mut membership, lateral_m, 0.05);
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
    fn one_glance_of_noise_makes_no_target() {
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
    fn exact_tracks_and_those_of_the_start_count_at_once() {
        let exact = PathLimits::new(&TargetSelection::default(), true);
        let mut membership = Membership::default();
        exact.observe(&mut membership, 1.0, 0.0);
        assert!(membership.in_path());
        assert!(limits().long_known(-1.0).in_path());
        assert!(!limits().long_known(2.0).in_path());
    }
}
