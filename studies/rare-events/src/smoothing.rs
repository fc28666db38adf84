//! Smooth weights that lead from the nominal density to the event (Papaioannou, Geyer, Straub 2019, section 3).
//!
//! The event's indicator is replaced by `Φ(-g / s)`. A level's width s is the smallest for which the weights of its points
//! do not scatter too much. With s towards 0 the weights become the indicator.

use crate::normal;

/// Coefficient of variation that a level's weights may have. Source: Papaioannou, Geyer, Straub 2019, section 3.2.
const TARGET: f64 = 1.5;
/// Halvings of the search for a width.
const HALVINGS: usize = 50;
/// Narrowest width as a share of the first.
const NARROWEST: f64 = 1e-6;

/// The widths of a sequence of levels.
#[derive(Debug)]
pub(crate) struct Smoothing {
    width: f64,
    narrowest: f64,
}

impl Smoothing {
    /// Before the first level, whose values these are.
    pub(crate) fn before(values: &[f64]) -> Self {
        let finite: Vec<f64> = values.iter().map(|v| v.abs()).filter(|v| v.is_finite()).collect();
        let largest = finite.into_iter().fold(0.0, f64::max);
        // At ten times the largest value all points weigh nearly the same.
        let width = 10.0 * largest.max(f64::MIN_POSITIVE / NARROWEST);
        Self { width, narrowest: NARROWEST * width }
    }

    /// Weights of points, by the next width. Together they are worth as much as a level of `count` points is.
    pub(crate) fn weights(&mut self, values: &[f64], ratios: &[f64], count: f64) -> Vec<f64> {
        let worth = count / (1.0 + TARGET * TARGET);
        let at = |width: f64| -> Vec<f64> {
            values.iter().zip(ratios).map(|(g, ratio)| normal::cdf(-g / width) * ratio).collect()
        };
        let (mut low, mut high) = (libm::log(self.narrowest), libm::log(self.width));
        if effective(&at(libm::exp(low))) >= worth {
            high = low;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if effective(&at(libm::exp(middle))) >= worth { high = middle } else { low = middle }
        }
        self.width = libm::exp(high);
        at(self.width)
    }

    /// True if the indicator differs little from the smooth weights on points of the density that was fitted to them.
    pub(crate) fn is_settled(&self, values: &[f64]) -> bool {
        let over = |g: &f64| if *g < 0.0 { 1.0 / normal::cdf(-g / self.width) } else { 0.0 };
        variation(&values.iter().map(over).collect::<Vec<_>>()) <= TARGET
    }
}

/// Number of even weights that determine a mean as well as these.
fn effective(weights: &[f64]) -> f64 {
    let (sum, squares) = weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Coefficient of variation; infinite without a mean.
fn variation(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
    let found = libm::sqrt(square) / mean;
    if found.is_nan() { f64::INFINITY } else { found }
}
