//! Symmetric 3×3 matrices.

/// A symmetric matrix: entries 00, 01, 02, 11, 12, 22.
pub(super) type Symmetric = [f64; 6];

/// `M v`.
#[inline(always)]
pub(super) fn product(m: &Symmetric, v: &[f64; 3]) -> [f64; 3] {
    [
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[1] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[2] * v[0] + m[4] * v[1] + m[5] * v[2],
    ]
}

/// Factors `M = L D L'` of a positive semidefinite matrix.
///
/// A term far below the precision of `M` keeps the factors regular for a singular `M`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    d: [f64; 3],
    l10: f64,
    l20: f64,
    l21: f64,
}

impl Factors {
    pub(super) fn new(m: &Symmetric) -> Self {
        let tiny = 1e-300;
        let d0 = m[0] * (1.0 + 1e-14) + tiny;
        let (l10, l20) = (m[1] / d0, m[2] / d0);
        let d1 = (m[3] - l10 * m[1]).max(1e-14 * m[3]) + tiny;
        let m21 = m[4] - l10 * m[2];
        let l21 = m21 / d1;
        let d2 = (m[5] - l20 * m[2] - l21 * m21).max(1e-14 * m[5]) + tiny;
        Self { d: [d0, d1, d2], l10, l20, l21 }
    }

    /// `M⁻¹ rhs`.
    pub(super) fn solve(&self, rhs: &[f64; 3]) -> [f64; 3] {
        let z0 = rhs[0];
        let z1 = rhs[1] - self.l10 * z0;
        let z2 = rhs[2] - self.l20 * z0 - self.l21 * z1;
        let y2 = z2 / self.d[2];
        let y1 = z1 / self.d[1] - self.l21 * y2;
        [z0 / self.d[0] - self.l10 * y1 - self.l20 * y2, y1, y2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_solve_regular_and_singular_systems() {
        let mut m = [4.0, 2.0, -1.0, 5.0, 0.5, 3.0];
        let x = [1.0, -2.0, 0.25];
        let found = Factors::new(&m).solve(&product(&m, &x));
        assert!((0..3).all(|i| (found[i] - x[i]).abs() < 1e-12), "{found:?}");
        // Rank one.
        m = [0.5, 1.0, 1.5, 2.0, 3.0, 4.5];
        let rhs = product(&m, &x);
        let back = product(&m, &Factors::new(&m).solve(&rhs));
        assert!((0..3).all(|i| (back[i] - rhs[i]).abs() < 1e-9), "{back:?}");
    }
}
