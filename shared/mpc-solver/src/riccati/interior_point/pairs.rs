//! Pairs of a slack `s` and a multiplier `λ` whose product is driven to zero.
//!
//! A step towards the product `t` satisfies `λ s⁺ + s λ⁺ = s λ + t`. With `r = (s⁺ − s)/s` the multiplier changes by
//! `t/(sλ) − 1 − r`, relative. The predictor aims at `t = 0`: `r` then tells all about a pair. A step of length `a`
//! is possible while `a max(−r, 1 + r) ≤ 1`, it leaves the product `sλ(1 + a r)(1 − a − a r)`, and what the predictor
//! has neglected gives the corrector's target, `t = τ + sλ r(1 + r)`.
//!
//! Sums and maxima run over four lanes, joined at the end: the same result on every machine, and
//! loops that need not wait for one addition after the other.

/// Compliance that is added to those of rows and light, unit of the limit per unit of its multiplier.
///
/// It moves the limit by `PROXIMAL (μ⁺ − μ)`, which vanishes as the multiplier settles, and keeps the
/// curvature from outgrowing the machine's precision while the slack of an active limit goes to zero.
pub(super) const PROXIMAL: f64 = 1e-12;

/// One pair per stage.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    pub(super) slack: Vec<f64>,
    pub(super) multiplier: Vec<f64>,
    /// `1/s` and `1/λ`.
    pub(super) per_slack: Vec<f64>,
    pub(super) per_multiplier: Vec<f64>,
    /// `r` of the last step computed.
    pub(super) relative: Vec<f64>,
    /// `t`.
    pub(super) target: Vec<f64>,
}

impl Pairs {
    pub(super) fn new(len: usize) -> Self {
        let zeros = || vec![0.0; len];
        Self {
            slack: zeros(),
            multiplier: zeros(),
            per_slack: zeros(),
            per_multiplier: zeros(),
            relative: zeros(),
            target: zeros(),
        }
    }

    /// Sets `1/s` and `1/λ`, and the targets to zero; returns the sum of the products.
    #[inline(always)]
    pub(super) fn invert(&mut self, len: usize) -> f64 {
        let (s, l) = (&self.slack[..len], &self.multiplier[..len]);
        let (ps, pl) = (&mut self.per_slack[..len], &mut self.per_multiplier[..len]);
        for k in 0..len {
            // One division for both.
            let per_product = 1.0 / (s[k] * l[k]);
            ps[k] = l[k] * per_product;
            pl[k] = s[k] * per_product;
        }
        self.target[..len].fill(0.0);
        sum(len, [s, l], |[s, l]| s * l)
    }

    /// Reciprocal of the longest possible predictor step, at least 1.
    #[inline(always)]
    pub(super) fn affine_step_reciprocal(&self, len: usize) -> f64 {
        // max(−r, 1 + r) = ½ + |r + ½|
        0.5 + largest(len, [&self.relative], |[r]| (r + 0.5).abs())
    }

    /// Sum of the products after a predictor step of length `a`.
    #[inline(always)]
    pub(super) fn gap_after_affine(&self, len: usize, a: f64) -> f64 {
        let arrays = [&self.slack[..], &self.multiplier, &self.relative];
        sum(len, arrays, |[s, l, r]| s * l * ((1.0 + a * r) * (1.0 - a - a * r)))
    }

    /// Targets of the corrector.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, len: usize, tau: f64, trust: f64) {
        let (s, l) = (&self.slack[..len], &self.multiplier[..len]);
        let (r, t) = (&self.relative[..len], &mut self.target[..len]);
        for k in 0..len {
            t[k] = tau + trust * (s[k] * l[k]) * (r[k] * (1.0 + r[k]));
        }
    }

    /// Reciprocal of the longest possible step.
    #[inline(always)]
    pub(super) fn step_reciprocal(&self, len: usize) -> f64 {
        let arrays = [&self.relative[..], &self.target, &self.per_slack, &self.per_multiplier];
        largest(len, arrays, |[r, t, ps, pl]| greater(-r, 1.0 + r - t * (ps * pl)))
    }

    /// Whether the slack of entry `k`, rather than its multiplier, goes to zero: by Tapia's indicator, which of
    /// the two has shrunk more in the last step.
    #[inline(always)]
    pub(super) fn is_active(&self, k: usize) -> bool {
        let remaining =
            self.target[k] * (self.per_slack[k] * self.per_multiplier[k]) - self.relative[k];
        1.0 + self.relative[k] < remaining
    }

    /// Takes the part `a` of the step.
    #[inline(always)]
    pub(super) fn advance(&mut self, len: usize, a: f64) {
        let (s, l) = (&mut self.slack[..len], &mut self.multiplier[..len]);
        let (r, t, ps) = (&self.relative[..len], &self.target[..len], &self.per_slack[..len]);
        for k in 0..len {
            s[k] += a * (s[k] * r[k]);
            l[k] += a * (t[k] * ps[k] - l[k] * (1.0 + r[k]));
        }
    }
}

/// The greater of two numbers, as one instruction.
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The largest `f ≥ 0` over the first `len` entries.
#[inline(always)]
pub(super) fn largest<const M: usize>(
    len: usize,
    arrays: [&[f64]; M],
    f: impl Fn([f64; M]) -> f64,
) -> f64 {
    fold(len, arrays, f, greater)
}

/// The sum of `f` over the first `len` entries.
#[inline(always)]
pub(super) fn sum<const M: usize>(
    len: usize,
    arrays: [&[f64]; M],
    f: impl Fn([f64; M]) -> f64,
) -> f64 {
    fold(len, arrays, f, |a, b| a + b)
}

#[inline(always)]
fn fold<const M: usize>(
    len: usize,
    arrays: [&[f64]; M],
    f: impl Fn([f64; M]) -> f64,
    join: impl Fn(f64, f64) -> f64,
) -> f64 {
    let parts = arrays.map(|a| a[..len].as_chunks::<4>());
    let mut lanes = [0.0; 4];
    for i in 0..len / 4 {
        for lane in 0..4 {
            let value = f(std::array::from_fn(|m| parts[m].0[i][lane]));
            lanes[lane] = join(value, lanes[lane]);
        }
    }
    for i in 0..len % 4 {
        let value = f(std::array::from_fn(|m| parts[m].1[i]));
        lanes[i] = join(value, lanes[i]);
    }
    join(join(lanes[0], lanes[1]), join(lanes[2], lanes[3]))
}
