//! Guess of the active set: the bounds of the inputs, the parts of the light's curve, and the parts
//! of the rows' curves.
//!
//! The active-set method improves it from round to round, and the interior point derives one from
//! its iterate. It is kept from solve to solve for the warm start.

use super::light_curve::LightTangent;
use super::row_curve::{RowTangent, STIFFNESS};
use crate::limits::MAX_ROWS;
use crate::problem::{Problem, Terminal};

/// Bound at which an input is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(i8)]
pub(super) enum Side {
    /// `u_min`.
    Lower = -1,
    /// No bound: the input is free.
    #[default]
    Free = 0,
    /// `u_max`.
    Upper = 1,
}

/// Number of stages compared at once.
const PIECE: usize = 16;

/// Guess, stage by stage.
#[derive(Clone, Debug)]
pub(super) struct WorkingSet {
    /// `sides[k]` belongs to `u_k`.
    pub(super) sides: Vec<Side>,
    /// `light[k]` belongs to stage `k + 1`.
    pub(super) light: Vec<LightTangent>,
    /// `rows[j][k]` belongs to stage `k`; used only with `has_row_tangents`.
    pub(super) rows: [Vec<RowTangent>; MAX_ROWS],
    /// True if the guess holds rows by their tangents.
    pub(super) has_row_tangents: bool,
    /// Slope of the rows' tangents at their limits.
    pub(super) row_stiffness: f64,
}

impl WorkingSet {
    /// Returns a guess with all inputs free and room for horizons up to `max_horizon`.
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            sides: vec![Side::Free; max_horizon],
            light: vec![LightTangent::default(); max_horizon],
            rows: std::array::from_fn(|_| vec![RowTangent::default(); max_horizon + 1]),
            has_row_tangents: false,
            row_stiffness: STIFFNESS,
        }
    }

    /// Frees all inputs and removes the rows.
    pub(super) fn clear(&mut self) {
        self.sides.fill(Side::Free);
        self.has_row_tangents = false;
    }

    /// Returns the number of rows that the guess holds by their tangents.
    pub(super) fn row_count(&self, problem: &Problem) -> usize {
        if self.has_row_tangents { problem.rows.len() } else { 0 }
    }

    /// Moves the guess forward by `steps` and returns the stage up to which it was moved.
    ///
    /// With a terminal cost everything moves. With `x_N = x_f` the last switches belong to the end of the horizon and
    /// keep their distance from it. Only stages before the middle of the longest run of free inputs move.
    pub(super) fn shift(&mut self, problem: &Problem, steps: usize) -> usize {
        let n = problem.horizon;
        let steps = steps.min(n);
        let middle = match problem.terminal {
            Terminal::Equality(_) => middle_of_longest_free_run(&self.sides[..n]).max(steps),
            Terminal::Cost => n,
        };
        self.sides.copy_within(steps..middle, 0);
        self.sides[middle - steps..middle].fill(Side::Free);
        let lit = (problem.light_len + steps).min(n);
        self.light.copy_within(steps.min(lit)..lit, 0);
        if self.has_row_tangents {
            for (tangents, row) in self.rows.iter_mut().zip(&problem.rows) {
                tangents.copy_within(steps..=n, 0);
                tangents[n + 1 - steps..=n].fill(RowTangent::default());
                // The row may have moved since the guess was made.
                for (k, slot) in tangents[..=n].iter_mut().enumerate() {
                    if k < row.from || k > row.to {
                        *slot = RowTangent::default();
                    }
                }
            }
        }
        middle
    }
}

/// Returns the number of stages at which two guesses differ.
pub(super) fn differences(a: &[Side], b: &[Side]) -> usize {
    let differs = |(a, b): (&Side, &Side)| u32::from(*a as i8 != *b as i8);
    a.iter().zip(b).map(differs).sum::<u32>() as usize
}

/// Returns the last stage at which two guesses differ.
pub(super) fn last_difference(a: &[Side], b: &[Side]) -> Option<usize> {
    let mut end = a.len().min(b.len());
    // Equal stages mostly come in long runs, which are skipped in pieces.
    while end > 0 {
        let first = end.saturating_sub(PIECE);
        if differences(&a[first..end], &b[first..end]) > 0 {
            return (first..end).rev().find(|&k| a[k] != b[k]);
        }
        end = first;
    }
    None
}

/// Returns the middle of the longest run of free inputs, or the end without one.
fn middle_of_longest_free_run(sides: &[Side]) -> usize {
    // The common case needs no branch per stage.
    if sides.iter().fold(0, |held, side| held | *side as i8) == 0 {
        return sides.len() - sides.len() / 2;
    }
    let (mut longest, mut middle, mut run) = (0, sides.len(), 0);
    for (k, side) in sides.iter().enumerate() {
        run = if *side == Side::Free { run + 1 } else { 0 };
        if run > longest {
            longest = run;
            middle = k + 1 - run / 2;
        }
    }
    middle
}

#[cfg(test)]
mod tests {
    use super::Side::{Free, Lower, Upper};
    use super::*;
    use crate::{Row, Softness};

    fn problem(terminal: bool) -> Problem {
        let builder = Problem::builder(8)
            .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
            .input_cost(1.0)
            .input_bounds(-1.0, 1.0);
        let builder = if terminal { builder.terminal_equality([0.0; 3]) } else { builder };
        builder.build().expect("a valid problem")
    }

    #[test]
    fn the_end_of_the_guess_stays_with_a_terminal_equality_and_moves_without() {
        let start = [Upper, Upper, Free, Free, Free, Free, Lower, Lower];
        let mut set = WorkingSet::new(8);
        set.sides.copy_from_slice(&start);
        set.shift(&problem(true), 1);
        assert_eq!(set.sides, [Upper, Free, Free, Free, Free, Free, Lower, Lower]);
        set.sides.copy_from_slice(&start);
        set.shift(&problem(false), 1);
        assert_eq!(set.sides, [Upper, Free, Free, Free, Free, Lower, Lower, Free]);
    }

    #[test]
    fn tangents_of_a_row_move_within_its_stages() {
        let mut problem = problem(false);
        let softness = Softness::Hard;
        let row = Row { gradient: [1.0, 0.0, 0.0], from: 2, to: 5, limit: 9.0, softness };
        problem.rows.push(row);
        let mut set = WorkingSet::new(8);
        set.has_row_tangents = true;
        for (stage, tangent) in set.rows[0].iter_mut().enumerate() {
            tangent.slope = stage as f64;
        }
        set.shift(&problem, 1);
        let slopes: Vec<f64> = set.rows[0].iter().map(|tangent| tangent.slope).collect();
        assert_eq!(slopes, [0.0, 0.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn the_last_difference_is_found_in_any_piece() {
        for n in [1, 15, 16, 17, 40] {
            let same = vec![Upper; n];
            assert_eq!(last_difference(&same, &same), None);
            for k in 0..n {
                let mut other = same.clone();
                other[..=k].fill(Free);
                assert_eq!(last_difference(&same, &other), Some(k), "{k} of {n}");
                assert_eq!(differences(&same, &other), k + 1);
            }
        }
    }

    #[test]
    fn a_shift_beyond_the_horizon_frees_everything() {
        let mut set = WorkingSet::new(8);
        set.sides.fill(Upper);
        set.shift(&problem(false), 100);
        assert_eq!(set.sides, [Free; 8]);
    }
}
