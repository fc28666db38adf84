//! Variables that depend on each other: a Gaussian copula by correlations of ranks.
//!
//! Spearman's correlation ρ of two variables belongs to the correlation `2 sin(π ρ / 6)` of their normal coordinates
//! (Kruskal 1958, equation 6.3). It does not depend on the distributions of the variables.

use crate::Distribution;
use crate::factor::Factor;
use std::f64::consts::PI;
use thiserror::Error;

/// Variables with their distributions and correlations.
#[derive(Clone, Debug, PartialEq)]
pub struct Copula {
    distributions: Vec<Distribution>,
    factor: Factor,
}

/// Correlations that no variables have.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CopulaError {
    /// One of them is not a correlation.
    #[error("a rank correlation of {0}, expected a number between -1 and 1")]
    Range(f64),
    /// They contradict each other.
    #[error("the rank correlations contradict each other: no variables have all of them")]
    Contradiction,
}

impl Copula {
    /// Variables with rank correlations between pairs, by their places.
    ///
    /// # Errors
    /// [`CopulaError`].
    pub fn new(
        distributions: Vec<Distribution>,
        correlations: &[(usize, usize, f64)],
    ) -> Result<Self, CopulaError> {
        let count = distributions.len();
        let mut matrix: Vec<Vec<f64>> = (0..count)
            .map(|i| (0..count).map(|j| if i == j { 1.0 } else { 0.0 }).collect())
            .collect();
        for &(i, j, rank) in correlations {
            if !(rank > -1.0 && rank < 1.0) {
                return Err(CopulaError::Range(rank));
            }
            let of_normals = 2.0 * libm::sin(PI * rank / 6.0);
            matrix[i][j] = of_normals;
            matrix[j][i] = of_normals;
        }
        let factor = Factor::of(&matrix).ok_or(CopulaError::Contradiction)?;
        Ok(Self { distributions, factor })
    }

    /// Number of variables.
    pub fn dimensions(&self) -> usize {
        self.distributions.len()
    }

    pub fn values(&self, point: &[f64]) -> Vec<f64> {
        let normals = self.factor.times(point);
        self.distributions.iter().zip(normals).map(|(of, z)| of.at(z)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_pcg::Pcg64;

    /// Spearman's correlation of the values of two variables.
    fn ranks_correlate(values: &[Vec<f64>]) -> f64 {
        let ranks = |place: usize| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|a, b| values[*a][place].total_cmp(&values[*b][place]));
            let mut ranks = vec![0.0; values.len()];
            order.iter().enumerate().for_each(|(rank, index)| ranks[*index] = rank as f64);
            ranks
        };
        let (a, b, n) = (ranks(0), ranks(1), values.len() as f64);
        let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum();
        1.0 - 6.0 * squares / (n * (n * n - 1.0))
    }

    #[test]
    fn values_have_the_rank_correlation_that_was_asked_for() {
        let distributions =
            vec!["lognormal(1, 1)".parse().expect("one"), "uniform(0, 1)".parse().expect("one")];
        let copula = Copula::new(distributions, &[(0, 1, -0.6)]).expect("a correlation");
        let mut generator = Pcg64::seed_from_u64(5);
        let mut draw = |_| {
            let point = [random::normal(&mut generator), random::normal(&mut generator)];
            copula.values(&point)
        };
        let values: Vec<Vec<f64>> = (0..20_000).map(&mut draw).collect();
        let found = ranks_correlate(&values);
        assert!((found + 0.6).abs() < 0.02, "{found}");
    }

    #[test]
    fn impossible_correlations_are_refused() {
        let three = || vec!["normal(0, 1)".parse().expect("one"); 3];
        let wrong = [(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)];
        assert_eq!(Copula::new(three(), &wrong), Err(CopulaError::Contradiction));
        assert_eq!(Copula::new(three(), &[(0, 1, 1.0)]), Err(CopulaError::Range(1.0)));
    }
}
