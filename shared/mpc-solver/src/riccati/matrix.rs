//! Symmetric 3×3 matrices.

use super::lanes::Vector;

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

/// Symmetric matrix as its three rows; the last lanes have no meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<V>(pub(super) [V; 3]);

impl<V: Vector> Rows<V> {
    #[inline(always)]
    pub(super) fn new(m: &Symmetric) -> Self {
        let [m00, m01, m02, m11, m12, m22] = *m;
        Self([
            V::from_array([m00, m01, m02, 0.0]),
            V::from_array([m01, m11, m12, 0.0]),
            V::from_array([m02, m12, m22, 0.0]),
        ])
    }

    /// Returns the entries of the upper triangle.
    #[inline(always)]
    pub(super) fn entries(&self) -> Symmetric {
        let [x, y, z] = self.0;
        let (x, y, z) = (x.to_array(), y.to_array(), z.to_array());
        [x[0], x[1], x[2], y[1], y[2], z[2]]
    }

    /// Adds `weight · g g'`; `g` in the first three lanes.
    #[inline(always)]
    pub(super) fn add_rank_one(&mut self, g: V, weight: f64) {
        let [x, y, z] = self.0;
        let wg = V::all(weight) * g;
        // Both triangles get the products of the upper one.
        let ([_, g1, g2, g3], [w0, w1, _, w3]) = (g.to_array(), wg.to_array());
        let middle = V::from_array([w0, w1, w1, w3]) * V::from_array([g1, g1, g2, g3]);
        self.0 = [x + wg.lane(0) * g, y + middle, z + wg * g.lane(2)];
    }
}

/// Adds `slope · g`.
#[inline(always)]
pub(super) fn add_slope(v: &mut [f64; 3], g: &[f64; 3], slope: f64) {
    for i in 0..3 {
        v[i] += slope * g[i];
    }
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
    use crate::riccati::lanes::Lanes;

    #[test]
    fn factors_solve_regular_and_singular_systems() {
        let mut m = [4.0, 2.0, -1.0, 5.0, 0.5, 3.0];
        let x = [1.0, -2.0, 0.25];
        let found = Factors::new(&m).solve(&product(&m, &x));
        assert!((0..3).all(|i| (found[i] - x[i]).abs() < 1e-12), "{found:?}");
        let mut rows = Rows::<Lanes>::new(&[0.0; 6]);
        rows.add_rank_one(Lanes([1.0, 2.0, 3.0, 0.0]), 0.5);
        m = rows.entries();
        let rhs = product(&m, &x);
        let back = product(&m, &Factors::new(&m).solve(&rhs));
        assert!((0..3).all(|i| (back[i] - rhs[i]).abs() < 1e-9), "{back:?}");
    }
}
