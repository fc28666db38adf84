//! Penalty of a row as a curve, and its tangents.
//!
//! `μ ∈ ∂ψ(z)` is zero below the limit. At the limit it is vertical up to the penalty `λ` (without end if hard), and
//! `λ + κ z` beyond. As for the light ([`super::light_curve`]), a tangent replaces the curve in one round. The point
//! reached on it decides the next part. The vertical part is a steep line through the multiplier of the previous round.
//! So the multiplier settles, and the limit is met exactly.
//!
//! A steeper line needs fewer rounds. But it turns the rounding of `z`, some 1e-14 m, into an error of the
//! multiplier. The optimality conditions require 1e-8 of the largest one. The slope is therefore [`STIFFNESS`] times
//! that multiplier ([`super::working_set::WorkingSet::row_stiffness`]).

use crate::problem::Row;

/// Slope that replaces the vertical part, in largest multipliers per unit of the limit.
pub(super) const STIFFNESS: f64 = 3e4;

/// Part of the curve, stored in a whole word. A tangent with one byte and seven unused ones is copied in pieces. Each
/// load then waits for the stores before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u64)]
enum Region {
    /// `z ≤ 0`, `μ = 0`.
    #[default]
    Clear,
    /// `z = 0`.
    Edge,
    /// `μ = λ + κ z`.
    Beyond,
}

/// A tangent `μ = multiplier + slope z`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RowTangent {
    region: Region,
    multiplier: f64,
    /// Slope, ≥ 0.
    pub(super) slope: f64,
}

impl RowTangent {
    /// Returns the tangent on the vertical part, which a line of this slope replaces.
    pub(super) fn edge(multiplier: f64, stiffness: f64) -> Self {
        Self { region: Region::Edge, multiplier, slope: stiffness }
    }

    /// Returns the tangent beyond the limit of a soft row.
    pub(super) fn beyond(penalty: f64, curvature: f64) -> Self {
        Self { region: Region::Beyond, multiplier: penalty, slope: curvature }
    }

    /// Returns whether the tangent adds anything to the problem.
    #[inline(always)]
    pub(super) fn acts(&self) -> bool {
        self.region != Region::Clear
    }

    /// Returns `μ` at `z`; with `z = −limit` the constant along the row's gradient.
    #[inline(always)]
    pub(super) fn at(&self, z: f64) -> f64 {
        self.multiplier + self.slope * z
    }

    /// Projects the point at `z` back to the curve. Returns the new tangent, the multiplier of the point, and its
    /// distance from the curve in units of the limit. The distance is 1 or more when the point changes to another part.
    /// `stiffness` is the slope that replaces the vertical part.
    pub(super) fn project(&self, row: &Row, z: f64, unit: f64, stiffness: f64) -> (Self, f64, f64) {
        let mu = self.at(z);
        let (penalty, curvature) = row.softness.penalty();
        let next = match self.region {
            Region::Clear if z > 1e-10 * unit => Self::edge(0.0, stiffness),
            Region::Clear => *self,
            Region::Edge if mu < 0.0 => Self::default(),
            Region::Edge if mu > penalty => Self::beyond(penalty, curvature),
            Region::Edge => Self::edge(mu, stiffness),
            Region::Beyond if z < 0.0 => Self::edge(penalty, stiffness),
            Region::Beyond => *self,
        };
        let distance = if next.region != self.region {
            1.0
        } else if next.region == Region::Edge {
            z.abs() / unit
        } else {
            0.0
        };
        (next, mu, distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Softness;

    /// Computes `min ½(z − a)² + ψ(z)` one tangent at a time: `z − a + μ = 0`.
    fn minimise(row: &Row, a: f64) -> (f64, f64) {
        let mut tangent = RowTangent::default();
        for _ in 0..20 {
            let z = (a - tangent.multiplier) / (1.0 + tangent.slope);
            let (next, mu, distance) = tangent.project(row, z, 1.0, 1e8);
            if distance < 1e-12 {
                return (z, mu);
            }
            tangent = next;
        }
        panic!("not settled for {a}");
    }

    #[test]
    fn every_part_is_found() {
        let softness = Softness::Soft { linear: 2.0, quadratic: 3.0 };
        let mut row = Row { gradient: [1.0, 0.0, 0.0], from: 1, to: 1, limit: 0.0, softness };
        assert_eq!(minimise(&row, -1.0), (-1.0, 0.0));
        let (z, mu) = minimise(&row, 1.5);
        assert!(z.abs() < 1e-12 && (mu - 1.5).abs() < 1e-6, "{z} {mu}");
        let (z, mu) = minimise(&row, 10.0);
        assert!((z - 2.0).abs() < 1e-12 && (mu - 8.0).abs() < 1e-12, "{z} {mu}");
        row.softness = Softness::Hard;
        let (z, mu) = minimise(&row, 10.0);
        assert!(z.abs() < 1e-12 && (mu - 10.0).abs() < 1e-6, "{z} {mu}");
    }
}
