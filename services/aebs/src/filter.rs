//! Filters with fixed gains: a position, and the rate at which it changes.
//!
//! An alpha-beta filter is the steady state of a Kalman filter for a position that is measured with
//! standard deviation `sigma` once in each period T, whose rate is changed by white acceleration of
//! standard deviation `a`. Its gains follow from the tracking index alone:
//!
//! ```text
//! L = a T² / sigma      r = (4 + L - sqrt(8 L + L²)) / 4      alpha = 1 - r²
//! beta = 2 (2 - alpha) - 4 sqrt(1 - alpha)
//! ```
//!
//! Source: Kalata, The tracking index: a generalized parameter for alpha-beta and alpha-beta-gamma target
//! trackers, IEEE Trans. Aerospace and Electronic Systems 20 (1984) 174.

/// Gains of an alpha-beta filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// On the position.
    pub alpha: f64,
    /// On the rate, times the period.
    pub beta: f64,
}

impl Gains {
    /// Gains for a tracking index (dimensionless, above 0).
    #[must_use]
    pub fn of_index(index: f64) -> Self {
        let index = index.clamp(1e-6, 1e3);
        let r = 0.25 * (4.0 + index - (8.0 * index + index * index).sqrt());
        let alpha = 1.0 - r * r;
        Self { alpha, beta: 2.0 * (2.0 - alpha) - 4.0 * (1.0 - alpha).sqrt() }
    }

    /// Gains of the `n`-th measurement of a new object (from 2 on): least squares over all of them,
    /// until the steady state is reached.
    #[must_use]
    pub fn of_count(n: u32) -> Self {
        let n = f64::from(n.max(2));
        let below = n * (n + 1.0);
        Self { alpha: 2.0 * (2.0 * n - 1.0) / below, beta: 6.0 / below }
    }

    /// The stronger of two.
    #[must_use]
    pub fn at_least(self, other: Self) -> Self {
        if self.alpha >= other.alpha { self } else { other }
    }
}

/// A position with its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AlphaBeta {
    /// Position, m.
    pub position_m: f64,
    /// Rate, m/s.
    pub rate_mps: f64,
}

impl AlphaBeta {
    /// Moves on by `period_s`.
    pub fn predict(&mut self, period_s: f64) {
        self.position_m += self.rate_mps * period_s;
    }

    /// Takes a measured position at the time predicted to.
    pub fn update(&mut self, measured_m: f64, period_s: f64, gains: Gains) {
        let miss = measured_m - self.position_m;
        self.position_m += gains.alpha * miss;
        self.rate_mps += gains.beta * miss / period_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_agree_with_the_published_table() {
        // Kalata's relation L² = beta² / (1 - alpha) holds for every index.
        for index in [0.01, 0.1, 0.5, 1.0, 4.0] {
            let Gains { alpha, beta } = Gains::of_index(index);
            assert!((beta * beta / (1.0 - alpha) - index * index).abs() < 1e-9 * index * index);
            assert!(alpha > 0.0 && alpha < 1.0);
        }
    }

    #[test]
    fn the_first_gains_are_those_of_least_squares() {
        // Two points: the line through both.
        let two = Gains::of_count(2);
        assert!((two.alpha - 1.0).abs() < 1e-12 && (two.beta - 1.0).abs() < 1e-12);
        // A line without noise is found by two measurements and kept.
        let mut filter = AlphaBeta { position_m: 1.0, rate_mps: 0.0 };
        for n in 2..20_u32 {
            filter.predict(0.05);
            filter.update(1.0 - 0.8 * 0.05 * f64::from(n - 1), 0.05, Gains::of_count(n));
            assert!((filter.rate_mps + 0.8).abs() < 1e-9, "{n}: {filter:?}");
        }
    }
}
