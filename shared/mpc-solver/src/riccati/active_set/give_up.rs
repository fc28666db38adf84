//! When an attempt is given up.
//!
//! The method has no safeguard: it settles within a few rounds, or it wanders until the rounds run out. An attempt that
//! wanders is known by the signs below, and what follows it is the interior point (cold) or the cold attempt (warm).
//! Their limits were measured. Attempts on the paper's drives all settle, after 15 rounds at most, and stay clear of the limits
//! (from the third round on at most 26 of 100 inputs change and at least 49 are free; at most 22 stages violate a row). Of
//! 4,618 random problems 1,402 settled with up to 18 rounds and without the third sign; five of them took more than 15.
//!
//! 1. More inputs change sides in one round than a line allows that falls from two fifths of them in the third round (35 of 100,
//!    30, 25, …) to a thirtieth in the tenth: the guess alternates between patterns, or it comes nearer so slowly that the interior
//!    point is there before it. Of 4,117 random problems it ends 25 attempts that would have settled, and 218 that would not, four
//!    rounds earlier in the mean.
//! 2. The terminal equality is left with fewer than four free inputs, or any problem with fewer than a quarter of them free
//!    from the seventh round on: near the time-optimal solution every round moves a switch by one
//!    stage, and there are many stages to go. Of 554 random problems left with fewer than four by the first round 5 settled.
//! 3. The inputs are at the same sides as two rounds before, and not at those of the last round: two guesses that lead to
//!    each other.
//! 4. More than a quarter of the stages violate a row (in the first two rounds of a problem with the light: two fifths): an arc of
//!    active stages is more than [`super::complementarity::MAX_WORKING_ROWS`] multipliers can hold. In the first round, which
//!    knows neither rows nor light, this ends 67 % of the attempts on random problems in which a row will act, with the light 50 %;
//!    of these 6,048 attempts 25 would have settled, the others would have ended a round later or more.
//! 5. With a terminal equality and without the light: three rounds have brought no new least number of changed sides, and more
//!    than two still change: the sides go round in a circle. With the light, the rounds in between can belong to its margins.
//! 6. Nothing changes but the working rows, and none of them is new: a row that the inputs cannot influence is violated.
//!
//! A guess from the previous solution is good or it is not: it is dropped as soon as a tenth of its inputs change sides in one
//! round when rows are in it by their tangents, else a third.
//!
//! A guess from an iterate of the interior point has five rounds. What a round may change, sides of inputs and parts of the
//! rows' curves together, is what the rounds left can settle: five with two rounds left or more, one with one. Of 5,139
//! attempts on 12,000 random problems 4,081 settled, 16 of them after more than five changes in the first round (of 365) and 23
//! after more than one in the second (of 535, with three rounds). Once nothing changes but the rows' multipliers, the
//! distances from their limits fall in proportion: where the rounds left would not do at this pace, the attempt is dropped ([`Approach`]). An
//! attempt that fails is repeated after another iteration.

/// The round from which on the inputs that may change sides are no longer fewer from round to round.
const LAST_ROUND: u32 = 10;

/// Fewest free inputs with which three conditions at the end can be met and one is left to choose.
const LEAST_FREE: usize = 4;

/// What a round has led to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub(super) round: u32,
    pub(super) horizon: usize,
    /// Inputs that have changed sides.
    pub(super) changed: usize,
    /// Whether they are at the sides of the round before last.
    pub(super) returns: bool,
    /// Inputs between their bounds.
    pub(super) free: usize,
    /// Whether the end is fixed.
    pub(super) has_terminal_equality: bool,
}

impl Progress {
    /// Whether a cold attempt shows that it wanders.
    pub(super) fn is_hopeless(&self) -> bool {
        let n = self.horizon;
        let left = LAST_ROUND.saturating_sub(self.round) as usize;
        let alternates = self.changed > (left * n / 20).max(n / 30);
        let is_bang_bang = self.round >= 7 && self.free < n / 4;
        let is_over_determined = self.has_terminal_equality && self.free < LEAST_FREE;
        let wanders = self.round >= 3 && (alternates || is_bang_bang || self.returns);
        self.changed > 0 && (is_over_determined || wanders)
    }

    /// Whether a given guess has turned out wrong.
    pub(super) fn refutes_guess(&self, has_row_tangents: bool) -> bool {
        self.changed > self.horizon / if has_row_tangents { 10 } else { 3 }
    }

    /// Whether an iterate's guess needs more rounds than the `left` ones, when rows have come to other `parts` of their
    /// curves.
    pub(super) fn refutes_iterate(&self, parts: usize, left: u32) -> bool {
        self.changed + parts > if left > 1 { 5 } else { 1 }
    }

    /// Most stages that may violate a row.
    pub(super) fn most_violated(&self, is_first_with_light: bool) -> usize {
        if is_first_with_light { 2 * self.horizon / 5 } else { self.horizon / 4 }
    }
}

/// Rounds without a new least number of changed sides after which a cold attempt has stalled.
const MOST_STALLED: u32 = 3;
/// Most changes that one or two switches on their way make.
const FEW_CHANGES: usize = 2;

/// How the number of changed sides goes down from round to round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Descent {
    least: usize,
    /// Rounds since it was reached first.
    rounds: u32,
}

impl Descent {
    pub(super) fn new() -> Self {
        Self { least: usize::MAX, rounds: 0 }
    }

    /// Takes what one more round has changed; whether there has been no progress for too long.
    pub(super) fn has_stalled(&mut self, changed: usize) -> bool {
        self.rounds = if changed < self.least { 0 } else { self.rounds + 1 };
        self.least = self.least.min(changed);
        self.rounds >= MOST_STALLED && changed > FEW_CHANGES
    }
}

/// How the rows of an iterate's guess come to their limits while nothing else changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach {
    /// Distance at which they have come.
    end: f64,
    /// Distance after the round before, if that changed nothing else.
    before: Option<f64>,
}

impl Approach {
    pub(super) fn new(end: f64) -> Self {
        Self { end, before: None }
    }

    /// Takes the distance that a round has left; whether, at the pace of the last one, the `left` rounds do not suffice.
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
