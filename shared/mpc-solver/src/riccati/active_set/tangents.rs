//! Tangents in place of the curves of light and rows: each round renews them.

use super::{ON_CURVE, Point, RowChange};
use crate::problem::{Problem, dot};
use crate::riccati::curve::Curve;
use crate::riccati::working_set::WorkingSet;

impl WorkingSet {
    /// Moves the light's tangents to where the last step led, and writes the multipliers there. Returns the largest
    /// relative distance from the curve. `is_first` places tangents at the margins of a trajectory without the light.
    pub(super) fn renew_light(
        &mut self,
        problem: &Problem,
        is_first: bool,
        point: &mut Point,
    ) -> f64 {
        let Some(cost) = problem.light.as_ref().filter(|_| problem.light_len > 0) else {
            return 0.0;
        };
        let curve = Curve::of_light(cost);
        let stages = problem.light_stages().iter().zip(&point.states[1..]);
        let margins = stages.map(|(stage, x)| dot(&stage.gradient, x) + stage.offset);
        let tangents = self.light[1..].iter_mut().zip(margins.clone());
        if is_first {
            let best = margins.fold(f64::NEG_INFINITY, f64::max);
            tangents.for_each(|(tangent, margin)| *tangent = curve.start(margin, best));
            return f64::INFINITY;
        }
        let mut worst: f64 = 0.0;
        for ((tangent, margin), alpha) in tangents.zip(&mut point.multipliers.light[1..]) {
            let (next, reached, distance) = curve.project(tangent, margin);
            (*tangent, *alpha) = (next, reached);
            worst = worst.max(distance);
        }
        worst
    }

    /// Renews the rows' tangents, and writes the multipliers there.
    pub(super) fn renew_rows(&mut self, problem: &Problem, point: &mut Point) -> RowChange {
        let mut change = RowChange::by_working_set(true);
        for (j, row) in problem.rows.iter().enumerate() {
            for k in row.from..=row.to {
                let h = problem.limits[j][k];
                let (tangent, mu) = (&mut self.rows[j][k], &mut point.multipliers.rows[j][k]);
                let margin = h - dot(&row.gradient, &point.states[k]);
                if h == f64::INFINITY || (margin >= 0.0 && !tangent.acts()) {
                    *mu = 0.0;
                    continue;
                }
                let curve = Curve::of_row(row.softness, h, self.row_stiffness);
                let (next, reached, distance) = curve.project(tangent, margin);
                (*tangent, *mu) = (next, reached);
                change.is_complete &= distance <= ON_CURVE;
                change.parts += usize::from(distance >= 1.0);
                change.last_stage = change.last_stage.max(k);
            }
        }
        change
    }
}
