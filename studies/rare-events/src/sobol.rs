//! Sobol's indices: the shares of the variance of a value that its variables explain.
//!
//! ```text
//! S_i  = V(E(g | x_i)) / V(g)              first order: x_i alone
//! ST_i = E(V(g | all but x_i)) / V(g)      total: x_i with all others
//! ```
//!
//! A row has two independent points a and b. For each variable it also has a with the coordinate of b: d + 2 runs.
//! Estimators: Saltelli and others 2010, table 2, rows b (first order) and f (total, Jansen).
//!
//! ```
//! use rare_events::sobol;
//!
//! let g = |u: &Vec<f64>| 2.0 * u[0] + u[1];
//! let rows: Vec<Vec<f64>> =
//!     (0..5_000).map(|row| sobol::row(2, 1, row).iter().map(g).collect()).collect();
//! let found = sobol::of_rows(&rows).expect("it varies");
//! assert!((found[0].first - 0.8).abs() < 0.05 && (found[1].total - 0.2).abs() < 0.05);
//! ```

use crate::monte_carlo::point;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// First order.
    pub first: f64,
    pub total: f64,
}

/// The points of a row by its number: a, b, then a with each coordinate of b.
pub fn row(dimensions: usize, seed: u64, number: u64) -> Vec<Vec<f64>> {
    let both = point(2 * dimensions, seed, number);
    let (a, b) = both.split_at(dimensions);
    let mixed = (0..dimensions).map(|place| {
        let mut mixed = a.to_vec();
        mixed[place] = b[place];
        mixed
    });
    [a.to_vec(), b.to_vec()].into_iter().chain(mixed).collect()
}

/// The indices from the values of rows, in the order of [`row`]. `None` if the value does not vary, or is not finite
/// somewhere.
pub fn of_rows(rows: &[Vec<f64>]) -> Option<Vec<Indices>> {
    let count = rows.len() as f64;
    let both = || rows.iter().flat_map(|row| &row[..2]);
    let mean = both().sum::<f64>() / (2.0 * count);
    let variance = both().map(|g| (g - mean) * (g - mean)).sum::<f64>() / (2.0 * count);
    let of = |place: usize| {
        // The mean is taken off: the estimator is the same and scatters less.
        let first = |row: &Vec<f64>| (row[1] - mean) * (row[place] - row[0]);
        let total = |row: &Vec<f64>| 0.5 * (row[0] - row[place]) * (row[0] - row[place]);
        Indices {
            first: rows.iter().map(first).sum::<f64>() / count / variance,
            total: rows.iter().map(total).sum::<f64>() / count / variance,
        }
    };
    let found: Vec<Indices> = (2..rows.first()?.len()).map(of).collect();
    let is_known = found.iter().all(|one| one.first.is_finite() && one.total.is_finite());
    is_known.then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// g = 2 u0 + u1 + u1 u2: variances 4, 1 and 1 for the product.
    #[test]
    fn a_product_has_total_indices_and_no_first_order_ones() {
        let g = |u: &Vec<f64>| 2.0 * u[0] + u[1] + u[1] * u[2];
        let rows = (0..20_000).map(|number| row(3, 3, number).iter().map(g).collect());
        let found = of_rows(&rows.collect::<Vec<_>>()).expect("it varies");
        let expected = [(4.0, 4.0), (1.0, 2.0), (0.0, 1.0)];
        for (index, (first, total)) in found.iter().zip(expected) {
            assert!((index.first - first / 6.0).abs() < 0.03, "{found:?}");
            assert!((index.total - total / 6.0).abs() < 0.03, "{found:?}");
        }
        assert_eq!(of_rows(&vec![vec![1.0; 4]; 10]), None);
        assert_eq!(of_rows(&[]), None);
    }
}
