//! Interacting multiple models: a bank of Kalman filters that assume different manoeuvres of the target. Each is
//! weighted by its predictions.
//!
//! Each step mixes the filters' states by the probabilities of a change of model and moves each on. Then each takes
//! the measurement in, and is weighted anew:
//!
//! ```text
//! c_j = Σ_i p_ij mu_i       x0_j = Σ_i p_ij mu_i x_i / c_j        P0_j likewise, with the spread of means
//! mu_j+ = c_j L_j / Σ c L   L_j: likelihood of the measurements in filter j
//! ```
//!
//! Source: Blom and Bar-Shalom, The interacting multiple model algorithm for systems with Markovian
//! switching coefficients, IEEE Trans. Automatic Control 33 (1988) 780.

use std::array::from_fn;

use kalman::{Gaussian, Innovation};

/// Least probability of a model, so that it can come back.
const LEAST_WEIGHT: f64 = 1e-4;

/// A bank of `M` filters on the same `N` elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bank<const N: usize, const M: usize> {
    filters: [Gaussian<N>; M],
    /// Probability of each model.
    pub(super) weights: [f64; M],
    combined: Gaussian<N>,
}

impl<const N: usize, const M: usize> Bank<N, M> {
    /// Filters that start with the given states; the first is the likely one.
    pub fn new(filters: [Gaussian<N>; M]) -> Self {
        let mut weights = [0.1 / M as f64; M];
        weights[0] += 0.9;
        Self { filters, weights, combined: mixture(&filters, &weights) }
    }

    /// Mixes the filters and then moves each on. `change[i]` is the probability that model `i` ends within the step;
    /// every other one is equally likely to follow.
    pub fn predict(&mut self, change: &[f64; M], mut advance: impl FnMut(usize, &mut Gaussian<N>)) {
        let others = (M - 1) as f64;
        let before = self.filters;
        let shares: [[f64; M]; M] = from_fn(|to| {
            from_fn(|from| {
                let probability =
                    if to == from { 1.0 - change[from] } else { change[from] / others };
                probability * self.weights[from]
            })
        });
        for (to, filter) in self.filters.iter_mut().enumerate() {
            let total: f64 = shares[to].iter().sum();
            self.weights[to] = total;
            *filter = mixture(&before, &shares[to].map(|share| share / total));
            advance(to, filter);
        }
        self.combined = mixture(&self.filters, &self.weights);
    }

    /// Changes the state of each filter in the same way.
    pub fn change(&mut self, change: impl FnMut(&mut Gaussian<N>)) {
        self.filters.iter_mut().for_each(change);
        self.combined = mixture(&self.filters, &self.weights);
    }

    /// The bank's expectation and its covariance, the models' disagreement included.
    pub fn combined(&self) -> &Gaussian<N> {
        &self.combined
    }

    /// The measurement of element `m` beside the prediction of the least certain model: what a gate
    /// has to let through.
    pub fn widest(&self, m: usize, measured: f64, variance: f64) -> Innovation {
        let mut widest = self.filters[0].innovation(m, measured, variance);
        for filter in &self.filters[1..] {
            let other = filter.innovation(m, measured, variance);
            if other.variance > widest.variance {
                widest = other;
            }
        }
        widest
    }

    /// Takes measurements of single elements, (element, value, variance), into every filter.
    pub fn correct(&mut self, measurements: &[(usize, f64, f64)]) {
        // Half the squared distance, and the likelihood's factor before the exponential.
        let (mut distances, mut factors) = ([0.0; M], [1.0; M]);
        for (model, filter) in self.filters.iter_mut().enumerate() {
            for &(m, measured, variance) in measurements {
                let innovation = filter.innovation(m, measured, variance);
                filter.correct(m, &innovation);
                distances[model] +=
                    0.5 * innovation.residual * innovation.residual / innovation.variance;
                factors[model] /= innovation.variance;
            }
        }
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        for model in 0..M {
            let farther = std::f64::consts::LOG2_E * (nearest - distances[model]);
            let likelihood = factors[model].sqrt() * libm::exp2(farther);
            self.weights[model] *= likelihood;
        }
        let total: f64 = self.weights.iter().sum();
        self.weights = self.weights.map(|weight| (weight / total).max(LEAST_WEIGHT));
        let total: f64 = self.weights.iter().sum();
        self.weights = self.weights.map(|weight| weight / total);
        self.combined = mixture(&self.filters, &self.weights);
    }
}

/// Mean and covariance of a mixture.
fn mixture<const N: usize, const M: usize>(
    parts: &[Gaussian<N>; M],
    shares: &[f64; M],
) -> Gaussian<N> {
    let mean: [f64; N] =
        from_fn(|i| parts.iter().zip(shares).map(|(part, share)| share * part.mean[i]).sum());
    let mut covariance = [[0.0; N]; N];
    for (part, share) in parts.iter().zip(shares) {
        let off: [f64; N] = from_fn(|i| part.mean[i] - mean[i]);
        for i in 0..N {
            for j in i..N {
                covariance[i][j] += share * (part.covariance[i][j] + off[i] * off[j]);
            }
        }
    }
    for i in 0..N {
        for j in 0..i {
            covariance[i][j] = covariance[j][i];
        }
    }
    Gaussian { mean, covariance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bank() -> Bank<1, 2> {
        Bank::new([Gaussian::independent([0.0], [1.0]); 2])
    }

    /// One step of a random walk whose step is small in the first model and large in the second.
    fn step(bank: &mut Bank<1, 2>, measured: f64) {
        bank.predict(&[0.05, 0.2], |model, filter| {
            filter.spread(&[[1.0]], &[1.0], [0.01, 4.0][model]);
        });
        bank.correct(&[(0, measured, 0.1)]);
    }

    #[test]
    fn the_model_that_predicts_well_gets_the_weight() {
        let mut bank = bank();
        for _ in 0..50 {
            step(&mut bank, 0.0);
        }
        assert!(bank.weights[0] > 0.8, "{:?}", bank.weights);
        let calm = bank.combined().covariance[0][0];
        step(&mut bank, 3.0);
        assert!(bank.weights[1] > 0.9, "{:?}", bank.weights);
        assert!(bank.combined().mean[0] > 2.5);
        assert!(bank.combined().covariance[0][0] > 1.5 * calm);
    }

    #[test]
    fn weights_sum_to_one_and_stay_above_zero() {
        let mut bank = bank();
        for measured in [0.0, 1e6, -1e6, 1e-9, 0.0, 1e12] {
            step(&mut bank, measured);
            let total: f64 = bank.weights.iter().sum();
            assert!((total - 1.0).abs() < 1e-12);
            assert!(bank.weights.iter().all(|&weight| weight >= 0.9 * LEAST_WEIGHT));
        }
    }

    #[test]
    fn a_mixture_of_two_points_is_as_wide_as_their_distance() {
        let parts = [-1.0, 1.0].map(|mean| Gaussian::independent([mean], [0.5]));
        let both = mixture(&parts, &[0.5, 0.5]);
        assert_eq!((both.mean, both.covariance), ([0.0], [[1.5]]));
    }

    #[track_caller]
    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }

    /// A bank whose two filters are at 0 and at 2 with these variances.
    fn apart(variances: [f64; 2]) -> Bank<1, 2> {
        let at = |mean: f64, variance: f64| Gaussian::independent([mean], [variance]);
        Bank::new([at(0.0, variances[0]), at(2.0, variances[1])])
    }

    #[test]
    fn the_first_model_is_the_likely_one() {
        assert_near(bank().weights[0], 0.95);
        assert_near(bank().weights[1], 0.05);
        let three = Bank::<1, 3>::new([Gaussian::independent([0.0], [1.0]); 3]);
        assert_near(three.weights[0], 0.9 + 0.1 / 3.0);
        assert_near(three.weights[2], 0.1 / 3.0);
    }

    #[test]
    fn filters_are_mixed_by_the_changes_of_model() {
        let mut bank = apart([1.0, 3.0]);
        bank.predict(&[0.1, 0.4], |model, filter| filter.mean[0] += [10.0, 20.0][model]);
        // From the second model come 0.02 of 0.875, and stay 0.03 of 0.125.
        assert_near(bank.weights[0], 0.875);
        assert_near(bank.weights[1], 0.125);
        let (into_first, into_second) = (0.02 / 0.875, 0.03 / 0.125);
        for (model, share, moved) in [(0, into_first, 10.0), (1, into_second, 20.0)] {
            let filter = &bank.filters[model];
            assert_near(filter.mean[0], 2.0 * share + moved);
            let within = 1.0 * (1.0 - share) + 3.0 * share;
            assert_near(filter.covariance[0][0], within + 4.0 * share * (1.0 - share));
        }
        let mean = 0.875 * bank.filters[0].mean[0] + 0.125 * bank.filters[1].mean[0];
        assert_near(bank.combined().mean[0], mean);
        // Each of the other two models is equally likely to follow.
        let mut three = Bank::<1, 3>::new([Gaussian::independent([0.0], [1.0]); 3]);
        three.predict(&[0.3, 0.0, 0.0], |_, _| ());
        let first = 0.9 + 0.1 / 3.0;
        assert_near(three.weights[0], 0.7 * first);
        assert_near(three.weights[1], 0.1 / 3.0 + 0.15 * first);
    }

    #[test]
    fn a_measurement_weights_the_filters_by_its_likelihood() {
        let mut bank = apart([1.0, 3.0]);
        bank.correct(&[(0, 1.0, 1.0)]);
        // Variances of 2 and 4, residuals of 1 and -1.
        assert_near(bank.filters[0].mean[0], 0.5);
        assert_near(bank.filters[1].mean[0], 2.0 - 0.75);
        let likelihoods =
            [0.95 * libm::exp(-0.25) / f64::sqrt(2.0), 0.05 * libm::exp(-0.125) / f64::sqrt(4.0)];
        let first = likelihoods[0] / (likelihoods[0] + likelihoods[1]);
        assert_near(bank.weights[0], first);
        assert_near(bank.weights[1], 1.0 - first);
    }

    #[test]
    fn a_gate_follows_the_least_certain_model() {
        for (variances, residual, variance) in [([1.0, 3.0], 3.0, 3.5), ([3.0, 1.0], 5.0, 3.5)] {
            let widest = apart(variances).widest(0, 5.0, 0.5);
            assert_eq!((widest.residual, widest.variance), (residual, variance));
        }
    }

    #[test]
    fn all_filters_are_changed_alike() {
        let mut bank = apart([1.0, 1.0]);
        bank.change(|filter| filter.mean[0] += 1.0);
        bank.change(|filter| filter.mean[0] *= 2.0);
        assert_eq!(bank.filters.map(|filter| filter.mean[0]), [2.0, 6.0]);
    }
}
