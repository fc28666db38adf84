//! Length of a step: how much of the longest one is taken, and when both lengths are equal.

/// Fraction of the longest step that is left out while the products are large. A predictor that cannot move leaves out
/// the further fraction. The limiting pair then stays farther from zero and limits the next step less.
const MARGIN: f64 = 0.01;
const SHORT_MARGIN: f64 = 0.1;

/// Iterations without a smaller mean product after which both lengths are equal. The ratio is what counts as smaller.
pub(super) const MOST_STALLED: u32 = 4;
const SMALLER: f64 = 0.9;

/// Result of an iteration.
#[derive(Clone, Copy, Debug)]
pub(in crate::riccati) struct Step {
    /// Mean product of the pairs before the step.
    pub(in crate::riccati) mu: f64,
    /// Geometric mean of the predictor's two lengths.
    pub(super) predictor: f64,
    /// Smaller one of the two lengths taken.
    pub(in crate::riccati) length: f64,
}

impl Step {
    /// Returns whether both steps were nearly full, so that they show which inequalities are
    /// active.
    pub(in crate::riccati) fn is_fast(&self) -> bool {
        self.predictor > 0.8 && self.length > 0.9
    }
}

/// Returns the fraction of the longest possible step that is taken.
#[inline(always)]
pub(super) fn fraction_of_longest(mu: f64, predictor: f64) -> f64 {
    let short = 1.0 - predictor;
    let margin = MARGIN + SHORT_MARGIN * (short * short);
    (1.0 - mu.min(margin)).max(0.5 + 0.5 * predictor).min(0.9995)
}

/// Iterations since the mean product last became smaller.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stall {
    least: f64,
    iterations: u32,
}

impl Default for Stall {
    fn default() -> Self {
        Self { least: f64::INFINITY, iterations: 0 }
    }
}

impl Stall {
    /// Records the mean product of one more iteration; returns whether there was no progress for
    /// too long. This result is permanent.
    pub(super) fn has_lasted(&mut self, mu: f64) -> bool {
        if self.iterations < MOST_STALLED {
            let is_smaller = mu < SMALLER * self.least;
            self.iterations = if is_smaller { 0 } else { self.iterations + 1 };
            self.least = self.least.min(mu);
        }
        self.iterations >= MOST_STALLED
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_left_out_of_a_step_where_the_predictor_is_short() {
        assert_eq!(fraction_of_longest(1e3, 1.0), 0.9995);
        assert_eq!(fraction_of_longest(1e3, 0.9), 1.0 - (MARGIN + SHORT_MARGIN * 0.1_f64.powi(2)));
        assert_eq!(fraction_of_longest(1e3, 0.0), 1.0 - MARGIN - SHORT_MARGIN);
        assert_eq!(fraction_of_longest(1e-3, 0.0), 0.999);
    }

    #[test]
    fn a_stall_begins_after_four_iterations_that_do_not_get_below_the_least_product_and_stays() {
        let mut stall = Stall::default();
        let found =
            [8.0, 14.0, 18.0, 7.0, 13.0, 17.0, 34.0, 6.9, 1.0].map(|mu| stall.has_lasted(mu));
        assert_eq!(found, [false, false, false, false, false, false, false, true, true]);
    }
}
