//! The density that importance sampling draws from: a normal one with a share of the nominal one.

use crate::factor::Factor;
use rand_core::Rng;

/// Share of the points that come from the nominal density. No weight exceeds its inverse, so that a bad fit costs runs
/// and not the estimate.
const DEFENSIVE: f64 = 0.1;

#[derive(Clone, Debug)]
pub(crate) struct Gaussian {
    mean: Vec<f64>,
    factor: Factor,
}

impl Gaussian {
    pub(crate) fn nominal(dimensions: usize) -> Self {
        Self { mean: vec![0.0; dimensions], factor: Factor::identity(dimensions) }
    }

    /// The fit to weighted points; `None` without weight.
    ///
    /// The covariance is drawn towards the nominal one with the weight of as many points as it has free entries. Fewer
    /// points determine it badly, and a density that is too narrow misses parts of the event.
    pub(crate) fn fitted(points: &[Vec<f64>], weights: &[f64]) -> Option<Self> {
        let whole: f64 = weights.iter().sum();
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        if whole.is_nan() || whole <= 0.0 {
            return None;
        }
        let dimensions = points.first()?.len();
        let pairs = || points.iter().zip(weights).filter(|(_, w)| **w > 0.0);
        let mean: Vec<f64> =
            (0..dimensions).map(|i| pairs().map(|(u, w)| w * u[i]).sum::<f64>() / whole).collect();
        let free = dimensions * (dimensions + 1) / 2;
        let (effective, prior) = (whole * whole / squares, free as f64);
        let entry = |i: usize, j: usize| {
            let sum: f64 = pairs().map(|(u, w)| w * (u[i] - mean[i]) * (u[j] - mean[j])).sum();
            let nominal = if i == j { prior } else { 0.0 };
            (effective * sum / whole + nominal) / (effective + prior)
        };
        let covariance: Vec<Vec<f64>> =
            (0..dimensions).map(|i| (0..dimensions).map(|j| entry(i, j)).collect()).collect();
        let factor = Factor::of(&covariance)?;
        Some(Self { mean, factor })
    }

    /// Draws a point, from the nominal density in its share.
    pub(crate) fn draw(&self, generator: &mut impl Rng) -> Vec<f64> {
        let is_nominal = random::uniform(generator) < DEFENSIVE;
        let u: Vec<f64> = self.mean.iter().map(|_| random::normal(generator)).collect();
        if is_nominal {
            return u;
        }
        let moved = self.factor.times(&u);
        moved.iter().zip(&self.mean).map(|(a, b)| a + b).collect()
    }

    /// Nominal density over this one.
    pub(crate) fn ratio(&self, point: &[f64]) -> f64 {
        let centred: Vec<f64> = point.iter().zip(&self.mean).map(|(u, m)| u - m).collect();
        let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        let own = -0.5 * square(&self.factor.solve(&centred)) - self.factor.log_determinant();
        let fitted_over_nominal = libm::exp(own + 0.5 * square(point));
        1.0 / ((1.0 - DEFENSIVE) * fitted_over_nominal + DEFENSIVE)
    }
}
