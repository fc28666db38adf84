//! Hyperparameters by the marginal likelihood.
//!
//! ```text
//! log p(y) = −½ yᵀ K⁻¹ y − ½ log |K| − m/2 log 2π
//! d log p / d θ = ½ tr( (α αᵀ − K⁻¹) dK/dθ ),   α = K⁻¹ y
//! ```
//!
//! Maximised over the logarithms by steps of the gradient's signs (Riedmiller and Braun, RPROP, 1993), from a few
//! starts. A weak prior bounds lengths that few points cannot determine: log l ~ N(log 0.5 √d', 1). d' is a quarter of
//! the dimensions, and at least one.

use crate::factor::Factor;
use crate::kernel::{Hyperparameters, Kind, covariances_and_slopes, words};
use crate::lanes::{LANES, Lanes};

/// Lengths at which the search begins.
const STARTS: [f64; 2] = [0.3, 1.0];
/// Steps from each start.
const STEPS: usize = 30;
/// Bounds of a length, the signal, the noise and a part.
const BOUNDS: [(f64, f64); 4] = [(0.02, 20.0), (0.05, 20.0), (0.003, 1.0), (0.02, 20.0)];
/// Median of the prior of a part, and the part at which the search begins.
const PART: f64 = 0.5;

/// Hyperparameters for values with mean 0 and deviation 1 at points of the unit cube.
///
/// It costs O(n³) a step: some hundred points are enough.
///
/// # Panics
/// Without a point.
pub fn fit(kinds: &[Kind], points: &[Vec<f64>], values: &[f64]) -> Hyperparameters {
    let problem = Problem::new(kinds, points, values);
    let found = STARTS.map(|start| problem.climb(start));
    let best = found.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are starts");
    problem.parameters(&best.0)
}

struct Problem<'a> {
    kinds: &'a [Kind],
    values: &'a [f64],
    dimensions: usize,
    /// The word of the branch that both points of a pair have, of each pair; empty without a branch.
    both: Vec<Option<usize>>,
    words: Vec<Option<usize>>,
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
        let branch = kinds.iter().position(|kind| matches!(kind, Kind::Branch(_)));
        let word = |point: &Vec<f64>| branch.map(|at| kinds[at].mark(point[at]) as usize);
        let words: Vec<Option<usize>> = points.iter().map(word).collect();
        let mut both = Vec::new();
        if branch.is_some() {
            for (place, a) in words.iter().enumerate() {
                both.extend(words[..place].iter().map(|b| a.filter(|_| a == b)));
            }
        }
        let prior = libm::log(0.5 * quarter.sqrt());
        Self { kinds, values, dimensions: kinds.len(), both, words, squares, prior }
    }

    fn bounds(&self, place: usize) -> (f64, f64) {
        let (low, high) = match place.checked_sub(self.dimensions) {
            None => BOUNDS[0],
            Some(after) => BOUNDS[1 + after.min(2)],
        };
        (libm::log(low), libm::log(high))
    }

    /// Squared differences by which a part of the covariance falls: `has` says which coordinates count.
    fn inverse(&self, lengths: &[f64], has: impl Fn(&Kind) -> bool) -> Vec<f64> {
        let of =
            |(kind, length): (&Kind, &f64)| if has(kind) { 1.0 / (length * length) } else { 0.0 };
        self.kinds.iter().zip(lengths).map(of).collect()
    }

    fn climb(&self, length: f64) -> (Vec<f64>, f64) {
        let mut at = vec![libm::log(length); self.dimensions];
        at.extend([0.0, libm::log(0.1)]);
        at.extend(std::iter::repeat_n(libm::log(PART), words(self.kinds)));
        let count = at.len();
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
        let parts = (self.dimensions + 2..at.len()).map(|place| libm::exp(at[place])).collect();
        Hyperparameters { lengths, signal: of(0), noise: of(1), parts }
    }

    /// The logarithm of likelihood times prior, and its gradient.
    fn likelihood(&self, at: &[f64]) -> (f64, Vec<f64>) {
        let (n, d) = (self.values.len(), self.dimensions);
        let Hyperparameters { lengths, signal, noise, parts } = self.parameters(at);
        let variance = signal * signal;
        let common = self.inverse(&lengths, |kind| matches!(kind, Kind::Number | Kind::Word(_)));
        let all = self.inverse(&lengths, |kind| !matches!(kind, Kind::Branch(_)));
        let mut terms = vec![self.term(common, variance, None)];
        if !self.both.is_empty() {
            let variances: Vec<f64> = parts.iter().map(|part| part * part).collect();
            terms.push(self.term(all, 1.0, Some(&variances)));
        }
        let first = |row: usize| row * row.saturating_sub(1) / 2;
        let mut factor = Factor::default();
        let mut with = Vec::with_capacity(n);
        for row in 0..n {
            let pairs = first(row)..first(row) + row;
            with.clear();
            with.extend(pairs.map(|pair| {
                terms.iter().map(|term| term.covariances.as_flattened()[pair]).sum::<f64>()
            }));
            let part = self.words[row].map_or(0.0, |word| parts[word] * parts[word]);
            factor.push(&with, variance + part + noise * noise);
        }
        let half = factor.forward(self.values);
        let fitted: f64 = half.iter().map(|z| z * z).sum();
        let alpha = factor.backward(half);
        let value = -0.5 * fitted - factor.half_log_determinant();
        // tr((α αᵀ − K⁻¹) dK): of the symmetric matrices twice the lower part, and the diagonal.
        let mut gradient = vec![0.0; at.len()];
        let mut weights = vec![[0.0; LANES]; self.squares.len() / d.max(1)];
        let mut columns = Vec::with_capacity(n);
        for block in (0..n).step_by(LANES) {
            factor.inverse_lanes(block, &mut columns);
            for before in block..(block + LANES).min(n) {
                let column = |row: usize| columns[row - block][before - block];
                let diagonal = alpha[before] * alpha[before] - column(before);
                gradient[d] += diagonal * variance;
                gradient[d + 1] += diagonal * noise * noise;
                if let Some(word) = self.words[before] {
                    gradient[d + 2 + word] += diagonal * parts[word] * parts[word];
                }
                for row in before + 1..n {
                    let weight = alpha[row] * alpha[before] - column(row);
                    weights.as_flattened_mut()[first(row) + before] = weight;
                }
            }
        }
        for (place, term) in terms.iter().enumerate() {
            let products = weights.as_flattened().iter().zip(term.covariances.as_flattened());
            let products = products.map(|(weight, covariance)| 2.0 * weight * covariance);
            if place == 0 {
                gradient[d] += products.sum::<f64>();
            } else {
                for (product, word) in products.zip(&self.both) {
                    if let Some(word) = word {
                        gradient[d + 2 + word] += product;
                    }
                }
            }
            for ((weights, slopes), squares) in
                weights.iter().zip(&term.slopes).zip(self.squares.chunks_exact(d))
            {
                for ((gradient, square), inverse) in
                    gradient[..d].iter_mut().zip(squares).zip(&term.inverse)
                {
                    let mut sum = 0.0;
                    for lane in 0..LANES {
                        sum += weights[lane] * slopes[lane] * square[lane];
                    }
                    *gradient += sum * inverse;
                }
            }
        }
        let mut prior = 0.0;
        for (place, log) in at.iter().enumerate() {
            let off = match place.checked_sub(d) {
                None => log - self.prior,
                Some(0 | 1) => continue,
                Some(_) => log - libm::log(PART),
            };
            prior -= 0.5 * off * off;
            gradient[place] -= off;
        }
        (value + prior, gradient)
    }

    /// A term of the covariance of all pairs. With `parts`, only a pair of one word has its part.
    fn term(&self, inverse: Vec<f64>, variance: f64, parts: Option<&[f64]>) -> Term {
        let blocks = self.squares.len() / self.dimensions.max(1);
        let mut found = [Vec::with_capacity(blocks), Vec::with_capacity(blocks)];
        covariances_and_slopes(&self.squares, &inverse, variance, &mut found);
        if let Some(parts) = parts {
            for values in &mut found {
                for (value, word) in values.as_flattened_mut().iter_mut().zip(&self.both) {
                    *value *= word.map_or(0.0, |word| parts[word]);
                }
            }
        }
        let [covariances, slopes] = found;
        Term { inverse, covariances, slopes }
    }
}

/// A term of the covariance: of each pair the covariance and its slope.
struct Term {
    inverse: Vec<f64>,
    covariances: Vec<Lanes>,
    slopes: Vec<Lanes>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that fill the square, in an order without a pattern.
    fn points(count: usize) -> Vec<Vec<f64>> {
        let part = |k: usize, by: f64| (k as f64 * by).fract();
        (1..=count).map(|k| vec![part(k, 0.754_877_666), part(k, 0.569_840_29)]).collect()
    }

    /// Compares the gradient with differences of the likelihood, in every direction.
    #[track_caller]
    fn assert_gradient(problem: &Problem, at: &[f64]) {
        let (_, gradient) = problem.likelihood(at);
        for place in 0..at.len() {
            let moved = |by: f64| {
                let mut at = at.to_vec();
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
    fn the_gradient_is_that_of_the_likelihood() {
        let points = points(15);
        let values: Vec<f64> = points.iter().map(|x| libm::sin(6.0 * x[0]) - 0.3 * x[1]).collect();
        let kinds = [Kind::Number, Kind::Word(3)];
        let problem = Problem::new(&kinds, &points, &values);
        assert_gradient(&problem, &[-0.5, 0.2, 0.1, -2.0]);
    }

    #[test]
    fn the_gradient_is_that_of_the_likelihood_with_a_branch() {
        let points: Vec<Vec<f64>> = points(18)
            .into_iter()
            .map(|x| vec![x[0], x[1], (3.0 * x[0] + 7.0 * x[1]).fract()])
            .collect();
        let values: Vec<f64> = points.iter().map(|x| libm::sin(6.0 * x[0]) - 0.3 * x[1]).collect();
        let kinds = [Kind::Number, Kind::Branch(3), Kind::Own];
        let problem = Problem::new(&kinds, &points, &values);
        assert_gradient(&problem, &[-0.5, 0.2, -0.9, 0.1, -2.0, -0.3, 0.4, -1.0]);
    }

    #[test]
    fn the_word_that_matters_has_the_largest_part() {
        let points: Vec<Vec<f64>> = points(60)
            .into_iter()
            .map(|x| vec![x[0], (5.0 * x[0] + 3.0 * x[1]).fract(), x[1]])
            .collect();
        let value = |x: &Vec<f64>| {
            let part = if (0.25..0.5).contains(&x[1]) { libm::sin(9.0 * x[2]) } else { 0.0 };
            0.5 * libm::sin(3.0 * x[0]) + part
        };
        let values: Vec<f64> = points.iter().map(value).collect();
        let found = fit(&[Kind::Number, Kind::Branch(4), Kind::Own], &points, &values);
        let others = [0, 2, 3].map(|word| found.parts[word]);
        assert!(others.iter().all(|part| found.parts[1] > 3.0 * part), "{found:?}");
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
    fn noise_is_distinguished_from_the_function() {
        let points = points(80);
        let noise = |k: usize| 0.4 * ((k as f64 * 0.618_034).fract() - 0.5) * 12.0_f64.sqrt();
        let values: Vec<f64> =
            points.iter().enumerate().map(|(k, x)| libm::cos(4.0 * x[1]) + noise(k)).collect();
        let found = fit(&[Kind::Number; 2], &points, &values);
        assert!((0.25..0.55).contains(&found.noise), "{found:?}");
    }
}
