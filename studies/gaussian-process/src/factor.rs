//! A Cholesky factor that grows by rows.

use multiversion::multiversion;

use crate::lanes::{LANES, Lanes};

/// The lower factor of a symmetric positive definite matrix, row by row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Factor {
    rows: Vec<Vec<f64>>,
}

impl Factor {
    /// Adds a row of the matrix: covariances with the rows before it, and its own. A row that depends on the others
    /// gets the least diagonal that keeps the factor regular.
    pub fn push(&mut self, with: &[f64], own: f64) {
        let mut row = self.forward(with);
        let left = own - dot(&row, &row);
        row.push(left.max(1e-12 * own).sqrt());
        self.rows.push(row);
    }

    /// Keeps the first rows alone.
    pub fn truncate(&mut self, rows: usize) {
        self.rows.truncate(rows);
    }

    /// Solves L z = b.
    pub fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut z = Vec::with_capacity(b.len() + 1);
        for (row, b) in self.rows.iter().zip(b) {
            let place = z.len();
            z.push((b - dot(&row[..place], &z)) / row[place]);
        }
        z
    }

    /// The next components of z for several b at once, one in each lane. `z` holds what is solved.
    pub fn forward_lanes(&self, z: &mut Vec<Lanes>, b: &[Lanes]) {
        forward_lanes(&self.rows, 0, z, b);
    }

    /// The columns from `first` on of the matrix's inverse, one in each lane, from the row `first` on. `z` is room.
    pub fn inverse_lanes(&self, first: usize, z: &mut Vec<Lanes>) {
        let mut units = vec![[0.0; LANES]; self.rows.len() - first];
        for (lane, unit) in units.iter_mut().enumerate().take(LANES) {
            unit[lane] = 1.0;
        }
        z.clear();
        // Before the first column the solution is 0.
        forward_lanes(&self.rows[first..], first, z, &units);
        backward_lanes(&self.rows[first..], first, z);
    }

    /// Solves Lᵀ x = z.
    pub fn backward(&self, mut z: Vec<f64>) -> Vec<f64> {
        for place in (0..z.len()).rev() {
            let row = &self.rows[place];
            let x = z[place] / row[place];
            z[place] = x;
            for (z, l) in z[..place].iter_mut().zip(row) {
                *z -= x * l;
            }
        }
        z
    }

    /// Half of the logarithm of the matrix's determinant.
    pub fn half_log_determinant(&self) -> f64 {
        self.rows.iter().map(|row| libm::log(row[row.len() - 1])).sum()
    }
}

/// Solves L z = b from a row on: `rows` begin there, and the solution before column `first` is 0.
#[multiversion(targets("x86_64+avx2"))]
fn forward_lanes(rows: &[Vec<f64>], first: usize, z: &mut Vec<Lanes>, b: &[Lanes]) {
    for (row, b) in rows[z.len()..].iter().zip(&b[z.len()..]) {
        let mut sums = [0.0; LANES];
        for (l, z) in row[first..].iter().zip(z.iter()) {
            for lane in 0..LANES {
                sums[lane] += l * z[lane];
            }
        }
        let own = row[first + z.len()];
        let mut next = [0.0; LANES];
        for lane in 0..LANES {
            next[lane] = (b[lane] - sums[lane]) / own;
        }
        z.push(next);
    }
}

/// Solves Lᵀ x = z down to column `first`, where `rows` begin.
#[multiversion(targets("x86_64+avx2"))]
fn backward_lanes(rows: &[Vec<f64>], first: usize, z: &mut [Lanes]) {
    for place in (0..z.len()).rev() {
        let row = &rows[place][first..];
        let (before, rest) = z.split_at_mut(place);
        let x = &mut rest[0];
        for x in x.iter_mut() {
            *x /= row[place];
        }
        for (z, l) in before.iter_mut().zip(row) {
            for lane in 0..LANES {
                z[lane] -= x[lane] * l;
            }
        }
    }
}

/// The scalar product, in eight sums that a processor can do side by side.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a8.zip(b8) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let pairs = [sums[0] + sums[4], sums[1] + sums[5], sums[2] + sums[6], sums[3] + sums[7]];
    (pairs[0] + pairs[2]) + (pairs[1] + pairs[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_solves_its_matrix() {
        // M = A Aᵀ + I for a fixed A.
        let n = 23;
        let a = |i: usize, j: usize| (((i * 7 + j * 13) % 11) as f64 - 5.0) / 5.0;
        let m = |i: usize, j: usize| {
            (0..n).map(|k| a(i, k) * a(j, k)).sum::<f64>() + if i == j { 1.0 } else { 0.0 }
        };
        let mut factor = Factor::default();
        for i in 0..n {
            factor.push(&(0..i).map(|j| m(i, j)).collect::<Vec<_>>(), m(i, i));
        }
        let x: Vec<f64> = (0..n).map(|i| i as f64 - 3.0).collect();
        let b: Vec<f64> = (0..n).map(|i| (0..n).map(|j| m(i, j) * x[j]).sum()).collect();
        let found = factor.backward(factor.forward(&b));
        assert!(found.iter().zip(&x).all(|(found, x)| (found - x).abs() < 1e-9), "{found:?}");
        // Other right sides beside it change nothing, and neither does a solution in two parts.
        let lanes: Vec<Lanes> =
            b.iter().map(|b| std::array::from_fn(|lane| b * (lane as f64 - 2.0))).collect();
        let mut part = factor.clone();
        part.truncate(10);
        let mut z = Vec::new();
        part.forward_lanes(&mut z, &lanes);
        assert_eq!(z.len(), 10);
        factor.forward_lanes(&mut z, &lanes);
        let alone = factor.forward(&b);
        for (z, alone) in z.iter().zip(&alone) {
            assert!((z[3] - alone).abs() < 1e-12 && z[2] == 0.0, "{z:?} {alone}");
        }
        for first in [0, 16, 20] {
            factor.inverse_lanes(first, &mut z);
            for lane in 0..LANES.min(n - first) {
                let mut unit = vec![0.0; n];
                unit[first + lane] = 1.0;
                let column = factor.backward(factor.forward(&unit));
                for (z, column) in z.iter().zip(&column[first..]) {
                    assert!((z[lane] - column).abs() < 1e-12, "{first} {lane}");
                }
            }
        }
    }

    #[test]
    fn a_row_that_repeats_another_keeps_the_factor_regular() {
        let mut factor = Factor::default();
        factor.push(&[], 2.0);
        factor.push(&[2.0], 2.0);
        assert_eq!(factor.rows.len(), 2);
        assert!(factor.forward(&[1.0, 1.0]).iter().all(|z| z.is_finite()));
    }
}
