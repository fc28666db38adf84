//! Signs that an attempt will not settle.
//!
//! The method has no safeguard: it settles within a few rounds, or it wanders until the rounds run
//! out. The signs below detect a wandering attempt. The interior point follows a cold attempt that
//! was given up.
//!
//! All limits were measured. Attempts on the paper's drives that settle stay clear of them. From the third round on at
//! most 26 of 100 inputs change, and at least 49 are free. At most 22 stages violate a row.
//!
//! 1. More inputs change sides in one round than a falling line allows. The line starts at two fifths in the third
//!    round (35 of 100, 30, 25, …). It ends at a thirtieth in the tenth. The guess then alternates between patterns, or
//!    converges more slowly than the interior point. In 4,117 random problems this ends 25 attempts that would have
//!    settled, and 218 others four rounds earlier on average.
//! 2. Fewer than four inputs are free with a terminal equality. Or fewer than a quarter are free from the seventh round
//!    on, in any problem. Near the time-optimal solution each round moves a switch by one stage, and many stages
//!    remain. 5 of 554 random problems with fewer than four free inputs after the first round settled.
//! 3. More than a quarter of the stages violate a row; two fifths in the first two rounds of a problem with the light.
//!    An arc of active stages needs more than [`super::rows::MAX_WORKING_ROWS`] multipliers. The first round
//!    has neither rows nor light. There this sign ends 67 % of the attempts on random problems in which a row will act.
//!    With the light it ends 50 %. 25 of these 6,048 attempts would have settled; the others would have ended at least
//!    one round later.
//!
//! A guess from an iterate of the interior point has five rounds. A round may change as many sides of inputs, and parts
//! of the rows' curves, as the remaining rounds can settle. That is five with two or more rounds left, and one with one
//! left. 4,081 of 5,139 attempts on 12,000 random problems settled. 16 of these had more than five changes in the first
//! round (of 365). 23 had more than one in the second (of 535, with three rounds). A failed attempt is repeated after
//! another iteration.

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
        let wanders = self.round >= 3 && (alternates || is_bang_bang);
        self.changed > 0 && (is_over_determined || wanders)
    }

    /// Returns whether an iterate's guess needs more than the `left` rounds. `parts` counts the
    /// rows that moved to another part of their curves.
    pub(super) fn refutes_iterate(&self, parts: usize, left: u32) -> bool {
        self.changed + parts > if left > 1 { 5 } else { 1 }
    }

    /// Returns the largest number of stages that may violate a row.
    pub(super) fn most_violated(&self, has_light: bool) -> usize {
        if has_light && self.round <= 2 { 2 * self.horizon / 5 } else { self.horizon / 4 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(round: u32, changed: usize) -> Progress {
        Progress { round, horizon: 100, changed, free: 60, has_terminal_equality: false }
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
    fn an_iterates_guess_may_change_what_the_rounds_left_can_settle() {
        assert!(!progress(1, 3).refutes_iterate(2, 2));
        assert!(progress(1, 3).refutes_iterate(3, 2));
        assert!(!progress(2, 0).refutes_iterate(1, 1));
        assert!(progress(2, 1).refutes_iterate(1, 1));
    }
}
