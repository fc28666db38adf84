//! Hyperparameters by the marginal likelihood.
//!
//! ```text
//! log p(y) = −½ yᵀ K⁻¹ y − ½ log |K| − m/2 log 2π
//! d log p / d θ = ½ tr( (α αᵀ − K⁻¹) dK/dθ ),   α = K⁻¹ y
//! ```
//!
//! Maximised over the logarithms by steps of the gradient's signs (Riedmiller and Braun, RPROP, 1993), from a few
//! starts. A weak prior bounds lengths that few points cannot determine: log l ~ N(log 0.5 √d', 1), with d' a quarter
//! of the dimensions and at least one.

use crate::factor::Factor;
use crate::kernel::{Hyperparameters, Kind, covariances_and_slopes};
use crate::lanes::{LANES, Lanes};

/// Lengths at which the search begins.
const STARTS: [f64; 2] = [0.3, 1.0];
/// Steps from each start.
const STEPS: usize = 30;
/// Bounds of a length, the signal and the noise.
const BOUNDS: [(f64, f64); 3] = [(0.02, 20.0), (0.05, 20.0), (0.003, 1.0)];

/// Hyperparameters for values with mean 0 and deviation 1 at points of the unit cube.
///
/// It costs O(n³) a step: some hundred points are enough.
///
/// # Panics
/// Without a point.
#[must_use]
pub fn fit(kinds: &[Kind], points: &[Vec<f64>], values: &[f64]) -> Hyperparameters {
    let problem = Problem::new(kinds, points, values);
    let found = STARTS.map(|start| problem.climb(start));
    let best = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are starts");
    problem.parameters(&best.0)
}

struct Problem<'a> {
    values: &'a [f64],
    dimensions: usize,
    /// Squared differences of each pair of points: for each lane of pairs one row a coordinate.
    squares: Vec<Lanes>,
    prior: f64,
}

impl<'a> Problem<'a> {
    fn new(kinds: &'a [Kind], points: &'a [Vec<f64>], values: &'a [f64]) -> Self {
        let pairs = points.len() * points.len().saturating_sub(1) / 2;
        let mut squares = vec![[0.0; LANES]; pairs.div_ceil(LANES) * kinds.len()];
        let mut pair = 0;
        for (place, a) in points.iter().enumerate() {
            for b in &points[..place] {
                for (coordinate, kind) in kinds.iter().enumerate() {
                    squares[pair / LANES * kinds.len() + coordinate][pair % LANES] =
                        kind.squared(a[coordinate], b[coordinate]);
                }
                pair += 1;
            }
        }
        let quarter = (kinds.len() as f64 / 4.0).max(1.0);
        Self { values, dimensions: kinds.len(), squares, prior: libm::log(0.5 * quarter.sqrt()) }
    }

    fn bounds(&self, place: usize) -> (f64, f64) {
        let (low, high) = BOUNDS[place.saturating_sub(self.dimensions.saturating_sub(1)).min(2)];
        (libm::log(low), libm::log(high))
    }

    fn climb(&self, length: f64) -> (Vec<f64>, f64) {
        let count = self.dimensions + 2;
        let mut at = vec![libm::log(length); self.dimensions];
        at.extend([0.0, libm::log(0.1)]);
        let (mut value, mut gradient) = self.likelihood(&at);
        let mut best = (at.clone(), value);
        let mut steps = vec![0.3_f64; count];
        let mut before = vec![0.0; count];
        for _ in 0..STEPS {
            for place in 0..count {
                let same = gradient[place] * before[place];
                steps[place] = match same {
                    same if same > 0.0 => (steps[place] * 1.2).min(1.0),
                    same if same < 0.0 => (steps[place] * 0.5).max(1e-3),
                    _ => steps[place],
                };
                let (low, high) = self.bounds(place);
                let step = if gradient[place] == 0.0 {
                    0.0
                } else {
                    steps[place].copysign(gradient[place])
                };
                at[place] = (at[place] + step).clamp(low, high);
            }
            std::mem::swap(&mut before, &mut gradient);
            (value, gradient) = self.likelihood(&at);
            if value > best.1 {
                best = (at.clone(), value);
            }
            if steps.iter().all(|step| *step < 5e-3) {
                break;
            }
        }
        best
    }

    fn parameters(&self, at: &[f64]) -> Hyperparameters {
        let lengths = at[..self.dimensions].iter().map(|log| libm::exp(*log)).collect();
        let of = |place: usize| libm::exp(at[self.dimensions + place]);
        Hyperparameters { lengths, signal: of(0), noise: of(1) }
    }

    /// The logarithm of likelihood times prior, and its gradient.
    fn likelihood(&self, at: &[f64]) -> (f64, Vec<f64>) {
        let (n, d) = (self.values.len(), self.dimensions);
        let Hyperparameters { lengths, signal, noise } = self.parameters(at);
        let inverse: Vec<f64> = lengths.iter().map(|length| 1.0 / (length * length)).collect();
        let variance = signal * signal;
        let mut factor = Factor::default();
        let blocks = self.squares.len() / d.max(1);
        let mut found = [Vec::with_capacity(blocks), Vec::with_capacity(blocks)];
        covariances_and_slopes(&self.squares, &inverse, variance, &mut found);
        let [covariances, slopes] = &found;
        let covariances = covariances.as_flattened();
        let first = |row: usize| row * row.saturating_sub(1) / 2;
        for row in 0..n {
            factor.push(&covariances[first(row)..first(row) + row], variance + noise * noise);
        }
        let half = factor.forward(self.values);
        let fitted: f64 = half.iter().map(|z| z * z).sum();
        let alpha = factor.backward(half);
        let value = -0.5 * fitted - factor.half_log_determinant();
        // tr((α αᵀ − K⁻¹) dK): of the symmetric matrices twice the lower part, and the diagonal.
        let mut gradient = vec![0.0; d + 2];
        let mut diagonal = 0.0;
        let mut weights = vec![[0.0; LANES]; blocks];
        let mut columns = Vec::with_capacity(n);
        for block in (0..n).step_by(LANES) {
            factor.inverse_lanes(block, &mut columns);
            for before in block..(block + LANES).min(n) {
                let column = |row: usize| columns[row - block][before - block];
                diagonal += alpha[before] * alpha[before] - column(before);
                for row in before + 1..n {
                    let weight = alpha[row] * alpha[before] - column(row);
                    weights.as_flattened_mut()[first(row) + before] = weight;
                }
            }
        }
        let products = weights.as_flattened().iter().zip(covariances);
        gradient[d] += 2.0 * products.map(|(weight, covariance)| weight * covariance).sum::<f64>();
        for ((weights, slopes), squares) in
            weights.iter().zip(slopes).zip(self.squares.chunks_exact(d))
        {
            for ((gradient, square), inverse) in gradient[..d].iter_mut().zip(squares).zip(&inverse)
            {
                let mut sum = 0.0;
                for lane in 0..LANES {
                    sum += weights[lane] * slopes[lane] * square[lane];
                }
                *gradient += sum * inverse;
            }
        }
        gradient[d] += diagonal * variance;
        gradient[d + 1] = diagonal * noise * noise;
        let mut prior = 0.0;
        for (gradient, log) in gradient[..d].iter_mut().zip(at) {
            let off = log - self.prior;
            prior -= 0.5 * off * off;
            *gradient -= off;
        }
        (value + prior, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that fill the square, in an order without a pattern.
    fn points(count: usize) -> Vec<Vec<f64>> {
        let part = |k: usize, by: f64| (k as f64 * by).fract();
        (1..=count).map(|k| vec![part(k, 0.754_877_666), part(k, 0.569_840_29)]).collect()
    }

    #[test]
    fn the_gradient_is_that_of_the_likelihood() {
        let points = points(15);
        let values: Vec<f64> = points.iter().map(|x| libm::sin(6.0 * x[0]) - 0.3 * x[1]).collect();
        let kinds = [Kind::Number, Kind::Word(3)];
        let problem = Problem::new(&kinds, &points, &values);
        let at = [-0.5, 0.2, 0.1, -2.0];
        let (_, gradient) = problem.likelihood(&at);
        for place in 0..4 {
            let moved = |by: f64| {
                let mut at = at;
                at[place] += by;
                problem.likelihood(&at).0
            };
            let by_difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            let off = (gradient[place] - by_difference).abs();
            assert!(
                off < 1e-4 * (1.0 + by_difference.abs()),
                "{place}: {gradient:?} {by_difference}"
            );
        }
    }

    #[test]
    fn a_coordinate_without_effect_gets_a_long_length() {
        let points = points(60);
        let values: Vec<f64> = points.iter().map(|x| 1.4 * libm::sin(7.0 * x[0])).collect();
        let found = fit(&[Kind::Number; 2], &points, &values);
        assert!(found.lengths[1] > 3.0 * found.lengths[0], "{found:?}");
        assert!(found.noise < 0.05, "{found:?}");
    }

    #[test]
    fn noise_is_told_from_the_function() {
        let points = points(80);
        let noise = |k: usize| 0.4 * ((k as f64 * 0.618_034).fract() - 0.5) * 12.0_f64.sqrt();
        let values: Vec<f64> =
            points.iter().enumerate().map(|(k, x)| libm::cos(4.0 * x[1]) + noise(k)).collect();
        let found = fit(&[Kind::Number; 2], &points, &values);
        assert!((0.25..0.55).contains(&found.noise), "{found:?}");
    }
}
