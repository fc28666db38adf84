//! A process over points that may grow.

use crate::factor::{Factor, dot};
use crate::kernel::{Hyperparameters, Kernel, Kind};
use crate::lanes::{LANES, Lanes};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// A Gaussian process with its points.
#[derive(Clone, Debug)]
pub struct Process {
    kernel: Kernel,
    noise: f64,
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    factor: Factor,
    /// (K + n² I)⁻¹ y.
    weights: Vec<f64>,
    /// Points at the end that count as expected, and how often such points were taken away.
    expected: usize,
    forgotten: usize,
}

impl Process {
    /// A process through `values` at `points`. The values should have mean 0.
    pub fn new(
        kinds: &[Kind],
        parameters: Hyperparameters,
        points: Vec<Vec<f64>>,
        values: Vec<f64>,
    ) -> Self {
        let mut process = Self {
            kernel: Kernel::new(kinds, &parameters),
            noise: parameters.noise * parameters.noise,
            points: Vec::with_capacity(points.len()),
            values: Vec::with_capacity(values.len()),
            factor: Factor::default(),
            weights: Vec::new(),
            expected: 0,
            forgotten: 0,
        };
        for (point, value) in points.into_iter().zip(values) {
            process.add(point, value);
        }
        process.solve();
        process
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// True without a point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Adds points with their values.
    ///
    /// # Panics
    /// While points are expected.
    pub fn extend(&mut self, more: impl IntoIterator<Item = (Vec<f64>, f64)>) {
        assert_eq!(self.expected, 0, "what is expected comes last");
        for (point, value) in more {
            self.add(point, value);
        }
        self.solve();
    }

    /// Adds a point whose value is not known yet, at its mean. It lowers the variance around it, and leaves all means as
    /// they are: its weight is 0.
    pub fn expect(&mut self, point: Vec<f64>) {
        let mean = self.mean(&point);
        self.add(point, mean);
        self.weights.push(0.0);
        self.expected += 1;
    }

    /// Takes the expected points away.
    pub fn forget_expected(&mut self) {
        let known = self.len() - self.expected;
        self.points.truncate(known);
        self.values.truncate(known);
        self.weights.truncate(known);
        self.factor.truncate(known);
        self.expected = 0;
        self.forgotten += 1;
    }

    /// Mean at a point: O(n).
    pub fn mean(&self, point: &[f64]) -> f64 {
        dot(&self.covariances(point), &self.weights)
    }

    /// Mean and variance at a point: O(n²).
    pub fn predict(&self, point: &[f64]) -> (f64, f64) {
        let covariances = self.covariances(point);
        let solved = self.factor.forward(&covariances);
        let variance = self.kernel.variance(point) - dot(&solved, &solved);
        (dot(&covariances, &self.weights), variance.max(0.0))
    }

    /// Mean and variance at each of the watched points. Each costs O(n²) at first, then O(n) for each point that was
    /// added since.
    pub fn predict_watched(&self, watched: &mut Watched) -> Vec<(f64, f64)> {
        if watched.forgotten != self.forgotten {
            watched.keep(watched.known);
            watched.forgotten = self.forgotten;
        }
        watched.known = self.len() - self.expected;
        let mut predictions = Vec::with_capacity(watched.points.len());
        let blocks = watched.points.chunks(LANES).zip(&mut watched.blocks);
        for (points, Block { covariances: known, solved }) in blocks {
            let marks = self.kernel.marks(points);
            self.kernel.covariances(&marks, &self.points[known.len()..], known);
            self.factor.forward_lanes(solved, known);
            let (mut means, mut explained) = ([0.0; LANES], [0.0; LANES]);
            for ((covariance, solved), weight) in known.iter().zip(&*solved).zip(&self.weights) {
                for lane in 0..LANES {
                    means[lane] += covariance[lane] * weight;
                    explained[lane] += solved[lane] * solved[lane];
                }
            }
            let all = points.iter().zip(means).zip(explained);
            predictions.extend(all.map(|((point, mean), explained)| {
                (mean, (self.kernel.variance(point) - explained).max(0.0))
            }));
        }
        predictions
    }

    fn add(&mut self, point: Vec<f64>, value: f64) {
        let with = self.covariances(&point);
        self.factor.push(&with, self.kernel.variance(&point) + self.noise);
        self.points.push(point);
        self.values.push(value);
    }

    fn solve(&mut self) {
        self.weights = self.factor.backward(self.factor.forward(&self.values));
    }

    fn covariances(&self, point: &[f64]) -> Vec<f64> {
        self.points.iter().map(|other| self.kernel.covariance(point, other)).collect()
    }
}

/// Points at which a process is asked again and again while it grows, with what was computed for them. They belong to
/// one process.
#[derive(Clone, Debug)]
pub struct Watched {
    points: Vec<Vec<f64>>,
    blocks: Vec<Block>,
    /// Points of the process that were not expected ones, and how often it had dropped such points.
    known: usize,
    forgotten: usize,
}

/// Points that are computed side by side: for each point of the process one number a lane.
#[derive(Clone, Debug, Default)]
struct Block {
    covariances: Vec<Lanes>,
    /// L⁻¹ k(x).
    solved: Vec<Lanes>,
}

impl Watched {
    /// Points that no process has been asked at.
    pub fn new(points: Vec<Vec<f64>>) -> Self {
        let blocks = vec![Block::default(); points.len().div_ceil(LANES)];
        Self { points, blocks, known: 0, forgotten: 0 }
    }

    fn keep(&mut self, known: usize) {
        for Block { covariances, solved } in &mut self.blocks {
            covariances.truncate(known);
            solved.truncate(known);
        }
    }

    pub fn points(&self) -> &[Vec<f64>] {
        &self.points
    }
}

/// Expected amount by which a normal value is below `target`.
///
/// ```
/// use gaussian_process::expected_improvement;
///
/// assert_eq!(expected_improvement((1.0, 0.0), 3.0), 2.0, "a certain value");
/// let even = expected_improvement((0.0, 1.0), 0.0);
/// assert!((even - 0.398_942_280_4).abs() < 1e-9, "half of the mean deviation");
/// ```
pub fn expected_improvement((mean, variance): (f64, f64), target: f64) -> f64 {
    let (gain, deviation) = (target - mean, variance.sqrt());
    if deviation <= 1e-12 {
        return gain.max(0.0);
    }
    let z = gain / deviation;
    let density = libm::exp(-0.5 * z * z) / TAU.sqrt();
    let below = 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
    (gain * below + deviation * density).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> Hyperparameters {
        Hyperparameters { lengths: vec![0.3, 0.5], signal: 1.5, noise: 0.1, parts: vec![] }
    }

    const KINDS: [Kind; 2] = [Kind::Number, Kind::Word(2)];

    fn points() -> Vec<Vec<f64>> {
        (0..12).map(|k| vec![f64::from(k * 5 % 12) / 12.0, f64::from(k % 2) * 0.6 + 0.2]).collect()
    }

    fn values() -> Vec<f64> {
        points().iter().map(|x| libm::sin(5.0 * x[0]) + x[1]).collect()
    }

    fn near(a: (f64, f64), b: (f64, f64)) -> bool {
        (a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12
    }

    #[test]
    fn a_process_that_grew_is_the_one_that_was_made_at_once() {
        let whole = Process::new(&KINDS, parameters(), points(), values());
        let mut grown =
            Process::new(&KINDS, parameters(), points()[..5].to_vec(), values()[..5].to_vec());
        let asked: Vec<Vec<f64>> = (0..11).map(|k| vec![0.09 * f64::from(k), 0.2]).collect();
        let mut watched = Watched::new(asked.clone());
        let first = grown.predict_watched(&mut watched);
        grown.expect(vec![0.4, 0.2]);
        grown.expect(vec![0.9, 0.2]);
        let expecting = grown.predict_watched(&mut watched);
        for (place, point) in asked.iter().enumerate() {
            assert!(near(expecting[place], grown.predict(point)), "{point:?}");
            assert_eq!(expecting[place].0, first[place].0, "the means stay");
            assert!(expecting[place].1 < first[place].1);
        }
        grown.forget_expected();
        assert_eq!(grown.predict_watched(&mut watched), first);
        grown.expect(vec![0.1, 0.2]);
        grown.forget_expected();
        grown.extend(points().into_iter().zip(values()).skip(5));
        let all = grown.predict_watched(&mut watched);
        for (found, point) in all.into_iter().zip(&asked) {
            assert!(near(found, whole.predict(point)), "{point:?}");
            assert_eq!(whole.mean(point), whole.predict(point).0);
        }
    }

    /// Two points, by hand: K = s² [[1, c], [c, 1]].
    #[test]
    fn two_points_by_hand() {
        let parameters =
            Hyperparameters { lengths: vec![1.0], signal: 2.0, noise: 0.5, parts: vec![] };
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
