//! A switch from one bound to the other needs an input between them.
//!
//! Behind the last stage at which a row acts, the costate varies slowly from stage to stage, so that the optimal input
//! passes from one bound to the other through at least one stage between them. A forward sweep from a
//! wrong multiplier may nevertheless end with neighbours at opposite bounds; held there, the terminal equality
//! loses its last free input and its multiplier explodes. So one of the two is set free: the other one if
//! exactly one was free before (the switch then moves by one stage), else the one that exceeds its
//! bound by less.
//!
//! Ahead of a row that acts the costate jumps, and neighbours at opposite bounds can be right. Should they be right
//! elsewhere, the sweep that finds the sides unchanged settles before this rule is asked.

use crate::riccati::working_set::Side;

/// Frees one of each pair of neighbours at opposite bounds, from stage `from` on.
///
/// `before` are the sides of the guess, `unclamped` the inputs that were clamped to `sides`.
pub(super) fn free_switches(
    sides: &mut [Side],
    before: &[Side],
    unclamped: &[f64],
    from: usize,
    (u_min, u_max): (f64, f64),
) {
    let excess = |k: usize| (unclamped[k] - u_max).max(u_min - unclamped[k]);
    for k in from.max(1)..sides.len() {
        let is_switch = sides[k - 1] as i8 * sides[k] as i8 == -1;
        if !is_switch {
            continue;
        }
        let freed = match (before[k - 1] == Side::Free, before[k] == Side::Free) {
            (true, false) => k,
            (false, true) => k - 1,
            _ if excess(k - 1) < excess(k) => k - 1,
            _ => k,
        };
        sides[freed] = Side::Free;
    }
}

#[cfg(test)]
mod tests {
    use super::Side::{Free, Lower, Upper};
    use super::*;

    #[test]
    fn the_switch_moves_by_one_stage_or_frees_the_smaller_excess() {
        let unclamped = [9.0, 7.0, -2.0, -9.0];
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Upper, Free, Lower, Lower], &unclamped, 0, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Free, Lower]);
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Upper, Upper, Free, Lower], &unclamped, 0, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Free, Lower, Lower]);
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Free; 4], &unclamped, 0, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Free, Lower]);
        // Ahead of a row that acts nothing is changed.
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Free; 4], &unclamped, 3, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Lower, Lower]);
    }
}
