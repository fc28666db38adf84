//! Pairs of a slack `s` and a multiplier `λ` whose product is driven to zero.
//!
//! A step towards the product `t` satisfies `λ s⁺ + s λ⁺ = s λ + t`. With `r = (s⁺ − s)/s` the
//! relative change of the multiplier is `t/(sλ) − 1 − r`. The predictor aims at `t = 0`, so `r`
//! alone describes a pair. A length `a` is possible while `−a r ≤ 1` and `a(1 + r) ≤ 1`. The
//! remaining product is
//!
//! ```text
//! sλ(1 + a r)(1 − a − a r) = (1 − a) sλ − a² n,     n = sλ r(1 + r)
//! ```
//!
//! `n` is the second-order term that the predictor neglects, and it gives the corrector's target `t = τ + n`. It
//! belongs to a full step, however. After a short predictor step, single pairs have an `n` of thousands of mean
//! products. Compensating it spoils the step of all others. So only a fraction of `n` counts, up to a multiple of the
//! mean product.

use crate::riccati::lanes::{Lanes, WIDTH};

/// Compliance added to those of rows and light \[unit of the limit per unit of its multiplier\].
///
/// It moves the limit by `PROXIMAL (μ⁺ − μ)`, which vanishes as the multiplier settles. It keeps
/// the curvature within the machine's precision while the slack of an active limit goes to zero.
pub(super) const PROXIMAL: f64 = 1e-12;

/// `1` in every lane.
pub(super) const ONE: Lanes = Lanes::all(1.0);

/// Pairs of [`WIDTH`] stages.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pairs {
    pub(super) slack: Lanes,
    pub(super) multiplier: Lanes,
    /// `1/s` and `1/λ`.
    pub(super) per_slack: Lanes,
    pub(super) per_multiplier: Lanes,
    /// `r` of the last computed step.
    relative: Lanes,
    /// `n` after the predictor, then `t`.
    pub(super) target: Lanes,
}

/// Targets of the corrector, `t = τ + fraction of n`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Targets {
    /// `τ`.
    pub(super) product: f64,
    /// Fraction of `n` that counts.
    pub(super) trust: f64,
    /// Cap on `n`.
    pub(super) most: f64,
}

/// Effect of a predictor step on the pairs, lane by lane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Prediction {
    /// Reciprocal of the longest possible step.
    pub(super) limit: Lanes,
    /// Sum of `n`.
    pub(super) neglected: Lanes,
}

/// Returns `fraction` of the longest possible step, at most a full one; `limit` is its reciprocal, lane by lane.
#[inline(always)]
pub(super) fn length(limit: Lanes, fraction: f64) -> f64 {
    (fraction / limit.largest().max(f64::MIN_POSITIVE)).min(1.0)
}

impl Pairs {
    pub(super) fn new(slack: Lanes, multiplier: Lanes) -> Self {
        Self { slack, multiplier, ..Self::default() }
    }

    pub(super) fn set(&mut self, lane: usize, slack: f64, multiplier: f64) {
        self.slack.0[lane] = slack;
        self.multiplier.0[lane] = multiplier;
    }

    /// Computes `1/s` and `1/λ`; returns the products.
    #[inline(always)]
    pub(super) fn invert(&mut self) -> Lanes {
        let product = self.slack * self.multiplier;
        // One division serves both reciprocals.
        let per_product = ONE / product;
        self.per_slack = self.multiplier * per_product;
        self.per_multiplier = self.slack * per_product;
        product
    }

    /// Records the predictor's `r`.
    #[inline(always)]
    pub(super) fn predict(&mut self, relative: Lanes, prediction: &mut Prediction) {
        let grown = ONE + relative;
        prediction.limit = (-relative).greater(grown.greater(prediction.limit));
        self.target = (self.slack * self.multiplier) * relative * grown;
        prediction.neglected = prediction.neglected + self.target;
    }

    #[inline(always)]
    pub(super) fn set_targets(&mut self, targets: Targets) {
        let Targets { product, trust, most } = targets;
        let neglected = self.target.lesser(Lanes::all(most));
        self.target = Lanes::all(product) + Lanes::all(trust) * neglected;
    }

    /// Records the step's `r`.
    #[inline(always)]
    pub(super) fn correct(&mut self, relative: Lanes, limit: &mut Lanes) {
        self.relative = relative;
        *limit = (-relative).greater((-self.change()).greater(*limit));
    }

    /// Returns the relative change of the multiplier.
    #[inline(always)]
    fn change(&self) -> Lanes {
        self.target * (self.per_slack * self.per_multiplier) - (ONE + self.relative)
    }

    /// Returns, lane by lane, whether the slack rather than its multiplier goes to zero. Tapia's
    /// indicator decides: the one that shrank more in the last step.
    #[inline(always)]
    pub(super) fn are_active(&self) -> [bool; WIDTH] {
        let (slack, multiplier) = (self.relative.0, self.change().0);
        std::array::from_fn(|lane| slack[lane] < multiplier[lane])
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, length: f64) {
        let (length, r) = (Lanes::all(length), self.relative);
        self.slack = self.slack + length * (self.slack * r);
        let change = self.target * self.per_slack - self.multiplier * (ONE + r);
        self.multiplier = self.multiplier + length * change;
    }
}

/// Returns the block and the lane of stage `k`.
#[inline(always)]
pub(super) fn place(k: usize) -> (usize, usize) {
    (k / WIDTH, k % WIDTH)
}

/// Adds `slope · g` for four stages.
#[inline(always)]
pub(super) fn add_slope(v: &mut [Lanes; 3], g: &[Lanes; 3], slope: Lanes) {
    for i in 0..3 {
        v[i] = v[i] + slope * g[i];
    }
}

/// Returns `g'x` for four stages.
#[inline(always)]
pub(super) fn product(g: &[Lanes; 3], x: &[Lanes; 3]) -> Lanes {
    g[0] * x[0] + g[1] * x[1] + g[2] * x[2]
}

/// Inputs and states of [`WIDTH`] stages, or their changes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathBlock {
    pub(super) u: Lanes,
    pub(super) x: [Lanes; 3],
}

impl PathBlock {
    #[inline(always)]
    pub(super) fn set_state(&mut self, lane: usize, x: &[f64; 3]) {
        for i in 0..3 {
            self.x[i].0[lane] = x[i];
        }
    }

    /// Adds another trajectory's block.
    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.u = self.u + other.u;
        for i in 0..3 {
            self.x[i] = self.x[i] + other.x[i];
        }
    }
}

/// Returns a zero trajectory with room for `max_horizon` steps.
pub(super) fn path(max_horizon: usize) -> Vec<PathBlock> {
    vec![PathBlock::default(); max_horizon / WIDTH + 1]
}

/// Returns `x_k`.
pub(super) fn state(path: &[PathBlock], k: usize) -> [f64; 3] {
    let (j, lane) = place(k);
    path[j].x.map(|lanes| lanes.0[lane])
}

/// Returns the block of `values` that begins at an entry.
#[inline(always)]
pub(super) fn block<T>(values: &[T], first: usize) -> &[T; WIDTH] {
    values[first..].first_chunk().expect("there is room for whole blocks")
}

/// As [`block`], to be changed.
#[inline(always)]
pub(super) fn block_mut<T>(values: &mut [T], first: usize) -> &mut [T; WIDTH] {
    values[first..].first_chunk_mut().expect("there is room for whole blocks")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_makes_up_for_what_was_neglected_up_to_a_limit() {
        let mut pairs = Pairs::new(ONE, ONE);
        for (neglected, target) in [(-1.0, 0.5), (2.0, 2.0), (100.0, 3.0)] {
            pairs.target = Lanes::all(neglected);
            pairs.set_targets(Targets { product: 1.0, trust: 0.5, most: 4.0 });
            assert_eq!(pairs.target.0, [target; WIDTH]);
        }
    }

    #[test]
    fn a_step_goes_as_far_as_slack_and_multiplier_both_can() {
        let mut pairs = Pairs::new(ONE, ONE);
        pairs.invert();
        // The slack reaches zero half of the way; the multiplier grows.
        let mut limit = Lanes::default();
        pairs.correct(Lanes::all(-2.0), &mut limit);
        let length = length(limit, 0.5);
        assert_eq!(length, 0.25);
        pairs.advance(length);
        assert_eq!((pairs.slack.0[0], pairs.multiplier.0[0]), (0.5, 1.25));
    }
}
