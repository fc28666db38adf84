//! A process over points that may grow.

use crate::factor::{Factor, dot};
use crate::kernel::{Hyperparameters, Kind, distance, matern};

/// A Gaussian process with its points.
#[derive(Clone, Debug)]
pub struct Process {
    kinds: Vec<Kind>,
    parameters: Hyperparameters,
    /// Inverse squares of the lengths.
    inverse: Vec<f64>,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    factor: Factor,
    /// (K + n² I)⁻¹ y.
    weights: Vec<f64>,
}

/// A point at which a process is asked again while it grows: the solution so far.
#[derive(Clone, Debug)]
pub struct Ahead {
    /// The point.
    pub point: Vec<f64>,
    covariances: Vec<f64>,
    solved: Vec<f64>,
}

impl Process {
    /// A process through `values` at `points`. The values should have mean 0.
    #[must_use]
    pub fn new(
        kinds: &[Kind],
        parameters: Hyperparameters,
        points: Vec<Vec<f64>>,
        values: Vec<f64>,
    ) -> Self {
        let inverse = parameters.lengths.iter().map(|length| 1.0 / (length * length)).collect();
        let mut process = Self {
            kinds: kinds.to_vec(),
            parameters,
            inverse,
            points: Vec::with_capacity(points.len()),
            values: Vec::with_capacity(values.len()),
            factor: Factor::default(),
            weights: Vec::new(),
        };
        for (point, value) in points.into_iter().zip(values) {
            process.add(point, value);
        }
        process.solve();
        process
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True without a point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Adds points with their values.
    pub fn extend(&mut self, more: impl IntoIterator<Item = (Vec<f64>, f64)>) {
        for (point, value) in more {
            self.add(point, value);
        }
        self.solve();
    }

    /// Keeps the first points alone.
    pub fn truncate(&mut self, points: usize) {
        self.points.truncate(points);
        self.values.truncate(points);
        self.factor.truncate(points);
        self.solve();
    }

    /// Mean at a point: O(n).
    #[must_use]
    pub fn mean(&self, point: &[f64]) -> f64 {
        dot(&self.covariances(point), &self.weights)
    }

    /// Mean and variance at a point: O(n²).
    #[must_use]
    pub fn predict(&self, point: &[f64]) -> (f64, f64) {
        self.predict_again(&mut self.ahead(point.to_vec()))
    }

    /// A point at which the process is asked more than once.
    #[must_use]
    pub fn ahead(&self, point: Vec<f64>) -> Ahead {
        Ahead { point, covariances: Vec::new(), solved: Vec::new() }
    }

    /// Mean and variance there: O(n²) at first, then O(n) for each point that was added since.
    pub fn predict_again(&self, ahead: &mut Ahead) -> (f64, f64) {
        let Ahead { point, covariances, solved } = ahead;
        covariances.truncate(self.len());
        solved.truncate(self.len());
        let new =
            self.points[covariances.len()..].iter().map(|other| self.covariance(point, other));
        covariances.extend(new);
        self.factor.forward_from(solved, covariances);
        let variance = self.variance() - dot(solved, solved);
        (dot(covariances, &self.weights), variance.max(0.0))
    }

    fn add(&mut self, point: Vec<f64>, value: f64) {
        let with = self.covariances(&point);
        let noise = self.parameters.noise;
        self.factor.push(&with, self.variance() + noise * noise);
        self.points.push(point);
        self.values.push(value);
    }

    fn solve(&mut self) {
        self.weights = self.factor.backward(self.factor.forward(&self.values));
    }

    fn variance(&self) -> f64 {
        self.parameters.signal * self.parameters.signal
    }

    fn covariance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.variance() * matern(distance(&self.kinds, &self.inverse, a, b))
    }

    fn covariances(&self, point: &[f64]) -> Vec<f64> {
        self.points.iter().map(|other| self.covariance(point, other)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> Hyperparameters {
        Hyperparameters { lengths: vec![0.3, 0.5], signal: 1.5, noise: 0.1 }
    }

    const KINDS: [Kind; 2] = [Kind::Number, Kind::Word(2)];

    fn points() -> Vec<Vec<f64>> {
        (0..12).map(|k| vec![f64::from(k * 5 % 12) / 12.0, f64::from(k % 2) * 0.6 + 0.2]).collect()
    }

    fn values() -> Vec<f64> {
        points().iter().map(|x| libm::sin(5.0 * x[0]) + x[1]).collect()
    }

    #[test]
    fn a_process_that_grew_is_the_one_that_was_made_at_once() {
        let whole = Process::new(&KINDS, parameters(), points(), values());
        let mut grown =
            Process::new(&KINDS, parameters(), points()[..5].to_vec(), values()[..5].to_vec());
        let mut ahead = grown.ahead(vec![0.4, 0.2]);
        let first = grown.predict_again(&mut ahead);
        grown.extend(points().into_iter().zip(values()).skip(5));
        assert_eq!(grown.predict_again(&mut ahead), whole.predict(&[0.4, 0.2]));
        grown.truncate(5);
        assert_eq!(grown.predict_again(&mut ahead), first);
        assert_eq!(whole.mean(&[0.4, 0.2]), whole.predict(&[0.4, 0.2]).0);
    }

    /// Two points, by hand: K = s² [[1, c], [c, 1]].
    #[test]
    fn two_points_by_hand() {
        let parameters = Hyperparameters { lengths: vec![1.0], signal: 2.0, noise: 0.5 };
        let points = vec![vec![0.0], vec![1.0]];
        let process = Process::new(&[Kind::Number], parameters, points, vec![1.0, -1.0]);
        let covariance = |r: f64| {
            let root = 5.0_f64.sqrt();
            4.0 * (1.0 + root * r + 5.0 / 3.0 * r * r) * libm::exp(-root * r)
        };
        let (own, both) = (4.0 + 0.25, covariance(1.0));
        // The inverse of [[own, both], [both, own]] times (1, −1) is (1, −1) / (own − both).
        let mean = (covariance(0.25) - covariance(0.75)) / (own - both);
        let (k, l) = (covariance(0.25), covariance(0.75));
        let reduced = (own * (k * k + l * l) - 2.0 * both * k * l) / (own * own - both * both);
        let (found_mean, found_variance) = process.predict(&[0.25]);
        assert!((found_mean - mean).abs() < 1e-12, "{found_mean} {mean}");
        assert!((found_variance - (4.0 - reduced)).abs() < 1e-12, "{found_variance}");
    }
}
