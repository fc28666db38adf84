//! Switches: a change from one bound to the other needs an input between them.
//!
//! Behind the last stage at which a row acts, the costate varies slowly from stage to stage. The optimal input then
//! passes from one bound to the other through at least one stage between them. A forward sweep with a wrong multiplier
//! may still end with neighbours at opposite bounds. Held there, the terminal equality loses its last free input, and
//! its multiplier diverges. One of the two is therefore freed. It is the other one if exactly one was free before (the
//! switch moves), else the one with the smaller excess.
//!
//! A switch moves by one stage, and by half the number of stages that would compensate the free input's excess. Each
//! stage that changes from one bound to the other compensates the range between them.
//!
//! Ahead of an acting row, in the working set or by its tangent, the costate jumps. There, neighbours at opposite
//! bounds can be right. If they are right elsewhere, the sweep that finds the sides unchanged settles before this rule
//! applies. A switch stays closed if freeing one of the two only restored the sides.

use crate::riccati::working_set::Side;

/// Largest number of further stages that a switch moves at once.
const MOST_STAGES: f64 = 8.0;
/// Fraction of the compensating stages by which a switch moves; the rest of the trajectory
/// compensates some of the excess.
const SHARE: f64 = 0.5;

/// Frees one of each pair of neighbours at opposite bounds, from stage `from` on.
///
/// `before` are the sides of the guess, `unclamped` the inputs before clamping to `sides`,
/// `settled` a switch that is right. Returns the last switch at which an input was freed.
pub(super) fn free_switches(
    sides: &mut [Side],
    before: &[Side],
    unclamped: &[f64],
    from: usize,
    settled: Option<usize>,
    (u_min, u_max): (f64, f64),
) -> Option<usize> {
    let excess = |k: usize| (unclamped[k] - u_max).max(u_min - unclamped[k]);
    let stages = |k: usize| {
        let taken_over = excess(k) / (u_max - u_min);
        (SHARE * taken_over).clamp(0.0, MOST_STAGES) as usize
    };
    let first = from.max(1);
    if !has_switch(&sides[first - 1..]) {
        return None;
    }
    let mut last = None;
    let mut k = first;
    while k < sides.len() {
        let (left, right) = (sides[k - 1], sides[k]);
        if left as i8 * right as i8 != -1 || settled == Some(k) {
            k += 1;
            continue;
        }
        let freed = match (before[k - 1] == Side::Free, before[k] == Side::Free) {
            (true, false) => {
                let run = sides[k..].iter().take_while(|side| **side == right).count();
                let moved = stages(k - 1).min(run - 1);
                sides[k..k + moved].fill(left);
                k + moved
            }
            (false, true) => {
                let run =
                    sides[first - 1..k].iter().rev().take_while(|side| **side == left).count();
                let moved = stages(k).min(run - 1);
                sides[k - moved..k].fill(right);
                k - 1 - moved
            }
            _ if excess(k - 1) < excess(k) => k - 1,
            _ => k,
        };
        sides[freed] = Side::Free;
        last = Some(k);
        k = k.max(freed) + 1;
    }
    last
}

/// Returns whether any neighbours are at opposite bounds, without a branch per stage.
fn has_switch(sides: &[Side]) -> bool {
    let opposite = Side::Lower as i8 ^ Side::Upper as i8;
    let pairs = sides.iter().zip(sides.iter().skip(1));
    pairs.fold(false, |found, (left, right)| found | (*left as i8 ^ *right as i8 == opposite))
}

#[cfg(test)]
mod tests {
    use super::Side::{Free, Lower, Upper};
    use super::*;

    #[test]
    fn the_switch_moves_by_one_stage_or_frees_the_smaller_excess() {
        let unclamped = [1.9, 1.7, -1.2, -1.9];
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Upper, Free, Lower, Lower], &unclamped, 0, None, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Free, Lower]);
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Upper, Upper, Free, Lower], &unclamped, 0, None, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Free, Lower, Lower]);
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Free; 4], &unclamped, 0, None, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Free, Lower]);
        // A settled switch is left as it is.
        let mut sides = [Upper, Upper, Lower, Lower];
        let settled = Some(2);
        let freed = free_switches(&mut sides, &[Free; 4], &unclamped, 0, settled, (-1.0, 1.0));
        assert_eq!((sides, freed), ([Upper, Upper, Lower, Lower], None));
        // Ahead of an acting row nothing changes.
        let mut sides = [Upper, Upper, Lower, Lower];
        free_switches(&mut sides, &[Free; 4], &unclamped, 3, None, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Lower, Lower]);
    }

    #[test]
    fn a_large_excess_moves_the_switch_by_several_stages_within_its_runs() {
        // The excess is four ranges; half of it moves the switch.
        let unclamped = [1.5, 9.0, -2.0, -2.0, -2.0, -2.0];
        let mut sides = [Upper, Upper, Lower, Lower, Lower, Lower];
        let before = [Upper, Free, Lower, Lower, Lower, Lower];
        free_switches(&mut sides, &before, &unclamped, 0, None, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Upper, Upper, Upper, Free, Lower]);
        // The switch moves left at most to the last stage at which a row acts.
        let unclamped = [2.0, 2.0, 2.0, -1e9, -2.0];
        let mut sides = [Upper, Upper, Upper, Lower, Lower];
        let before = [Upper, Upper, Upper, Free, Lower];
        free_switches(&mut sides, &before, &unclamped, 2, None, (-1.0, 1.0));
        assert_eq!(sides, [Upper, Free, Lower, Lower, Lower]);
    }
}
