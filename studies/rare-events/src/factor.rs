//! Cholesky factors of small symmetric matrices.

/// A lower triangular matrix `L`, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Factor(Vec<Vec<f64>>);

impl Factor {
    /// The factor of a symmetric matrix; `None` if the matrix is not positive definite.
    pub(crate) fn of(matrix: &[Vec<f64>]) -> Option<Self> {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(matrix.len());
        for (i, row) in matrix.iter().enumerate() {
            let mut new = Vec::with_capacity(i + 1);
            for j in 0..i {
                let known: f64 = (0..j).map(|k| new[k] * rows[j][k]).sum();
                new.push((row[j] - known) / rows[j][j]);
            }
            let rest = row[i] - new.iter().map(|x| x * x).sum::<f64>();
            // A rest of rounding is not a variance.
            if rest.is_nan() || rest <= 1e-12 * row[i].abs() {
                return None;
            }
            new.push(libm::sqrt(rest));
            rows.push(new);
        }
        Some(Self(rows))
    }

    pub(crate) fn identity(dimensions: usize) -> Self {
        let row = |i: usize| (0..=i).map(|j| if i == j { 1.0 } else { 0.0 }).collect();
        Self((0..dimensions).map(row).collect())
    }

    /// `L v`.
    pub(crate) fn times(&self, v: &[f64]) -> Vec<f64> {
        self.0.iter().map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum()).collect()
    }

    /// `L⁻¹ v`.
    pub(crate) fn solve(&self, v: &[f64]) -> Vec<f64> {
        let mut x: Vec<f64> = Vec::with_capacity(v.len());
        for (i, row) in self.0.iter().enumerate() {
            let known: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
            x.push((v[i] - known) / row[i]);
        }
        x
    }

    pub(crate) fn log_determinant(&self) -> f64 {
        self.0.iter().enumerate().map(|(i, row)| libm::log(row[i])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_times_its_transpose_is_the_matrix() {
        let matrix = vec![vec![4.0, 2.0, -1.0], vec![2.0, 5.0, 0.5], vec![-1.0, 0.5, 3.0]];
        let factor = Factor::of(&matrix).expect("positive definite");
        for (i, row) in matrix.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let product: f64 = (0..=i.min(j)).map(|k| factor.0[i][k] * factor.0[j][k]).sum();
                assert!((product - entry).abs() < 1e-12);
            }
        }
        let v = [1.0, -2.0, 0.5];
        let back = factor.solve(&factor.times(&v));
        assert!(back.iter().zip(v).all(|(a, b)| (a - b).abs() < 1e-12));
        // det = 4 (15 - 0.25) - 2 (6 + 0.5) - (1 + 5) = 40.
        assert!((2.0 * factor.log_determinant() - libm::log(40.0)).abs() < 1e-12);
        assert_eq!(Factor::of(&[vec![1.0, 1.0], vec![1.0, 1.0]]), None);
    }
}
