//! Products of `A` and `B` with symmetric matrices stored row by row.
//!
//! The columns of a symmetric `P` are its rows. `P A`, column by column, is therefore three sums of
//! rows; after a transposition the same three sums give `A'P A`.

use super::{CHAIN, GENERAL, LinearQuadratic, PLAIN, Shape};
use crate::riccati::lanes::Vector;
use crate::riccati::matrix::Rows;

/// `A` and `B` in the form that sums of rows need.
pub(super) struct Dynamics<V> {
    a: [V; 6],
    b: [V; 3],
    /// Diagonal of `A'` and the two below it, in their rows.
    diagonals: [V; 3],
    s: V,
}

impl<V: Vector> Dynamics<V> {
    #[inline(always)]
    pub(super) fn new(lq: &LinearQuadratic) -> Self {
        let [a00, a01, a02, a11, a12, a22] = lq.a;
        let [s0, s1, s2] = lq.s;
        let [b0, b1, b2] = lq.b;
        Self {
            a: [V::all(a00), V::all(a01), V::all(a02), V::all(a11), V::all(a12), V::all(a22)],
            b: [V::all(b0), V::all(b1), V::all(b2)],
            diagonals: [
                V::from_array([a00, a11, a22, 0.0]),
                V::from_array([0.0, a01, a12, 0.0]),
                V::from_array([0.0, 0.0, a02, 0.0]),
            ],
            s: V::from_array([s0, s1, s2, 0.0]),
        }
    }

    /// `P B`.
    #[inline(always)]
    pub(super) fn times_b<const SHAPE: Shape>(&self, p: &Rows<V>) -> V {
        let ([b0, b1, b2], [x, y, z]) = (self.b, p.0);
        if SHAPE >= CHAIN { b2 * z } else { (b0 * x + b1 * y) + b2 * z }
    }

    /// `F = A'P B + s'`.
    #[inline(always)]
    pub(super) fn crossed<const SHAPE: Shape>(&self, pb: V) -> V {
        let [kept, beside, corner] = self.diagonals;
        let [p0, p1, p2, _] = pb.to_array();
        let ahead = beside * V::from_array([p0, p0, p1, p2]);
        if SHAPE == PLAIN {
            ahead + kept * pb
        } else {
            ((corner * pb.lane(0) + ahead) + kept * pb) + self.s
        }
    }

    /// `A' M` for the rows of `M`.
    #[inline(always)]
    fn transposed_times<const SHAPE: Shape>(&self, [x, y, z]: [V; 3]) -> [V; 3] {
        let [a00, a01, a02, a11, a12, a22] = self.a;
        let (kept_x, kept_y) = if SHAPE != GENERAL { (x, y) } else { (a00 * x, a11 * y) };
        let ahead = if SHAPE == PLAIN { a12 * y } else { a02 * x + a12 * y };
        [kept_x, a01 * x + kept_y, ahead + a22 * z]
    }

    /// `A'P A`.
    #[inline(always)]
    pub(super) fn congruence<const SHAPE: Shape>(&self, p: &Rows<V>) -> Rows<V> {
        let [c0, c1, c2] = self.transposed_times::<SHAPE>(p.0);
        let (c0, c1, c2) = (c0.to_array(), c1.to_array(), c2.to_array());
        let [x, y, z] = self.transposed_times::<SHAPE>([
            V::from_array([c0[0], c1[0], c2[0], 0.0]),
            V::from_array([c0[1], c1[1], c2[1], 0.0]),
            V::from_array([c0[2], c1[2], c2[2], 0.0]),
        ]);
        // The entry below the diagonal is the same number, except for rounding.
        let (i, j, k) = (x.to_array(), y.to_array(), z.to_array());
        if SHAPE == GENERAL {
            Rows::new(&[i[0], i[1], i[2], j[1], j[2], k[2]])
        } else {
            Rows([x, y, V::from_array([k[0], j[2], k[2], k[3]])])
        }
    }
}
