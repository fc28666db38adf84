//! Signs that an attempt will not settle.
//!
//! The method has no safeguard: it settles within a few rounds, or it wanders until the rounds run
//! out. The signs below detect a wandering attempt. The interior point follows a cold attempt that
//! was given up, and the cold attempt follows a warm one.
//!
//! All limits were measured. Attempts on the paper's drives all settle, after at most 15 rounds, and stay clear of the
//! limits. From the third round on at most 26 of 100 inputs change, and at least 49 are free. At most 22 stages violate
//! a row. In 4,618 random problems, 1,402 attempts settled with up to 18 rounds and without sign 3. Five of them took
//! more than 15.
//!
//! 1. More inputs change sides in one round than a falling line allows. The line starts at two fifths in the third
//!    round (35 of 100, 30, 25, …). It ends at a thirtieth in the tenth. The guess then alternates between patterns, or
//!    converges more slowly than the interior point. In 4,117 random problems this ends 25 attempts that would have
//!    settled, and 218 others four rounds earlier on average.
//! 2. Fewer than four inputs are free with a terminal equality. Or fewer than a quarter are free from the seventh round
//!    on, in any problem. Near the time-optimal solution each round moves a switch by one stage, and many stages
//!    remain. 5 of 554 random problems with fewer than four free inputs after the first round settled.
//! 3. The inputs are at the same sides as two rounds before, but not as in the last round. Two guesses lead to each
//!    other.
//! 4. More than a quarter of the stages violate a row; two fifths in the first two rounds of a problem with the light.
//!    An arc of active stages needs more than [`super::rows::MAX_WORKING_ROWS`] multipliers. The first round
//!    has neither rows nor light. There this sign ends 67 % of the attempts on random problems in which a row will act.
//!    With the light it ends 50 %. 25 of these 6,048 attempts would have settled; the others would have ended at least
//!    one round later.
//! 5. With a terminal equality and without the light: three rounds bring no new minimum of changed sides, and more than
//!    two change. The sides then repeat in a cycle. With the light, the rounds in between can belong to its margins.
//!
//! A guess from the previous solution is dropped once a third of its inputs change sides in a round. With row tangents
//! it is a tenth.
//!
//! A guess from an iterate of the interior point has five rounds. A round may change as many sides of inputs, and parts
//! of the rows' curves, as the remaining rounds can settle. That is five with two or more rounds left, and one with one
//! left. 4,081 of 5,139 attempts on 12,000 random problems settled. 16 of these had more than five changes in the first
//! round (of 365). 23 had more than one in the second (of 535, with three rounds). Once only the rows' multipliers
//! change, the distances from their limits fall geometrically. The attempt is dropped where the remaining rounds do not
//! suffice at this rate ([`Approach`]). A failed attempt is repeated after another iteration.

/// Round from which on the permitted number of changed sides is constant.
const LAST_ROUND: u32 = 10;

/// Smallest number of free inputs that meet three terminal conditions and leave one to choose.
const LEAST_FREE: usize = 4;

/// State of an attempt after a round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub(super) round: u32,
    pub(super) horizon: usize,
    /// Number of inputs that changed sides.
    pub(super) changed: usize,
    /// True if the sides are those of the round before the last.
    pub(super) returns: bool,
    /// Number of inputs between their bounds.
    pub(super) free: usize,
    /// True if the last state is fixed.
    pub(super) has_terminal_equality: bool,
}

impl Progress {
    /// Returns whether a cold attempt wanders.
    pub(super) fn is_hopeless(&self) -> bool {
        let n = self.horizon;
        let left = LAST_ROUND.saturating_sub(self.round) as usize;
        let alternates = self.changed > (left * n / 20).max(n / 30);
        let is_bang_bang = self.round >= 7 && self.free < n / 4;
        let is_over_determined = self.has_terminal_equality && self.free < LEAST_FREE;
        let wanders = self.round >= 3 && (alternates || is_bang_bang || self.returns);
        self.changed > 0 && (is_over_determined || wanders)
    }

    /// Returns whether a guess from the previous solution is wrong.
    pub(super) fn refutes_guess(&self, has_row_tangents: bool) -> bool {
        self.changed > self.horizon / if has_row_tangents { 10 } else { 3 }
    }

    /// Returns whether an iterate's guess needs more than the `left` rounds. `parts` counts the
    /// rows that moved to another part of their curves.
    pub(super) fn refutes_iterate(&self, parts: usize, left: u32) -> bool {
        self.changed + parts > if left > 1 { 5 } else { 1 }
    }

    /// Returns the largest number of stages that may violate a row.
    pub(super) fn most_violated(&self, is_first_with_light: bool) -> usize {
        if is_first_with_light { 2 * self.horizon / 5 } else { self.horizon / 4 }
    }
}

/// Number of rounds without a new minimum of changed sides after which a cold attempt has stalled.
const MOST_STALLED: u32 = 3;
/// Largest number of changes that one or two moving switches make.
const FEW_CHANGES: usize = 2;

/// Smallest number of changed sides so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Descent {
    least: usize,
    /// Rounds since the minimum was first reached.
    rounds: u32,
}

impl Descent {
    pub(super) fn new() -> Self {
        Self { least: usize::MAX, rounds: 0 }
    }

    /// Records the changes of one more round; returns whether there was no progress for too long.
    pub(super) fn has_stalled(&mut self, changed: usize) -> bool {
        self.rounds = if changed < self.least { 0 } else { self.rounds + 1 };
        self.least = self.least.min(changed);
        self.rounds >= MOST_STALLED && changed > FEW_CHANGES
    }
}

/// Convergence of an iterate's rows to their limits while nothing else changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach {
    /// Distance that counts as reached.
    end: f64,
    /// Distance after the previous round, if that round changed nothing else.
    before: Option<f64>,
}

impl Approach {
    pub(super) fn new(end: f64) -> Self {
        Self { end, before: None }
    }

    /// Records the distance left by a round; returns whether the `left` rounds do not suffice at
    /// the last rate.
    pub(super) fn is_too_slow(&mut self, is_at_rest: bool, distance: f64, left: u32) -> bool {
        let before = self.before.filter(|_| is_at_rest);
        self.before = is_at_rest.then_some(distance);
        before.is_some_and(|before| {
            let pace = distance / before;
            (0..left).fold(distance, |distance, _| distance * pace) > self.end
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(round: u32, changed: usize) -> Progress {
        let (returns, has_terminal_equality) = (false, false);
        Progress { round, horizon: 100, changed, returns, free: 60, has_terminal_equality }
    }

    #[test]
    fn a_cold_attempt_is_given_up_above_a_line_that_falls_from_round_to_round() {
        for (round, most) in [(3, 35), (4, 30), (9, 5), (10, 3), (14, 3)] {
            assert!(!progress(round, most).is_hopeless(), "{round}");
            assert!(progress(round, most + 1).is_hopeless(), "{round}");
        }
        assert!(!progress(2, 100).is_hopeless(), "the first two rounds may change anything");
    }

    #[test]
    fn a_terminal_equality_needs_more_free_inputs_than_it_has_conditions() {
        let with_free = |free| Progress { free, has_terminal_equality: true, ..progress(1, 90) };
        assert!(with_free(3).is_hopeless());
        assert!(!with_free(4).is_hopeless());
        assert!(!Progress { changed: 0, ..with_free(3) }.is_hopeless(), "nothing is left to do");
    }

    #[test]
    fn sides_that_change_no_less_for_three_rounds_have_stalled() {
        let has_stalled = |changed: &[usize]| {
            let mut descent = Descent::new();
            changed.iter().map(|&changed| descent.has_stalled(changed)).collect::<Vec<_>>()
        };
        assert_eq!(has_stalled(&[40, 6, 7, 6, 9]), [false, false, false, false, true]);
        assert_eq!(has_stalled(&[40, 6, 7, 6, 5, 8]), [false; 6], "a new least number");
        assert_eq!(has_stalled(&[40, 2, 2, 2, 2, 2]), [false; 6], "a switch on its way");
    }

    #[test]
    fn an_approach_that_would_not_arrive_is_too_slow() {
        let mut approach = Approach::new(1e-8);
        assert!(!approach.is_too_slow(true, 1e-4, 3), "nothing is known of its pace");
        assert!(!approach.is_too_slow(true, 5e-6, 3));
        assert!(approach.is_too_slow(true, 2e-6, 2));
        assert!(!approach.is_too_slow(false, 1.0, 1), "something else has changed");
        assert!(!approach.is_too_slow(true, 1e-7, 1));
    }

    #[test]
    fn an_iterates_guess_may_change_what_the_rounds_left_can_settle() {
        assert!(!progress(1, 3).refutes_iterate(2, 2));
        assert!(progress(1, 3).refutes_iterate(3, 2));
        assert!(!progress(2, 0).refutes_iterate(1, 1));
        assert!(progress(2, 1).refutes_iterate(1, 1));
    }
}
