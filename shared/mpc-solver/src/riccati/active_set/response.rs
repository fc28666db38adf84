//! Effect of a few rows' multipliers on the trajectory: one more column of the recursion for each
//! row.
//!
//! A row `g'x_k ≤ h` with multiplier `μ` adds `μ g` to the costate of stage `k`. Below that stage
//! its column `v` obeys the recursion of `Ψ` (see [`crate::riccati::lqr`]),
//!
//! ```text
//! v_k = g,   f = B'v_{j+1},   v_j = A'v_{j+1} − F'f/δ   (input free),   v_j = A'v_{j+1}   (input held),
//! ```
//!
//! and shifts the free inputs by `−μ f/δ`. The row's left-hand side changes accordingly. `G_{cd} =
//! Σ f_c f_d/δ` is its response to the rows, `T_c = Σ β f_c/δ` that to the terminal equality; both
//! sums run over the free inputs.

use multiversion::multiversion;

use super::rows::MAX_WORKING_ROWS;
use super::rows::WorkingRow;
use crate::problem::{Problem, dot};
use crate::riccati::lqr::{CHAIN, GENERAL, LinearQuadratic, Shape, Sweep};
use crate::riccati::working_set::Side;

/// The columns and their sums.
#[derive(Clone, Debug)]
pub(super) struct RowResponse {
    /// `f/δ` by stage.
    pub(super) offsets: Vec<[f64; MAX_WORKING_ROWS]>,
    /// First stage that no column reaches.
    pub(super) reach: usize,
    /// `G`.
    pub(super) gram: [[f64; MAX_WORKING_ROWS]; MAX_WORKING_ROWS],
    /// `T`.
    pub(super) terminal: [[f64; MAX_WORKING_ROWS]; 3],
    /// `z` for zero multipliers.
    pub(super) value: [f64; MAX_WORKING_ROWS],
}

impl RowResponse {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            offsets: vec![[0.0; MAX_WORKING_ROWS]; max_horizon],
            reach: 0,
            gram: [[0.0; MAX_WORKING_ROWS]; MAX_WORKING_ROWS],
            terminal: [[0.0; MAX_WORKING_ROWS]; 3],
            value: [0.0; MAX_WORKING_ROWS],
        }
    }

    /// Computes the columns of `rows` after a sweep with these sides.
    pub(super) fn compute(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        sweep: &Sweep,
        sides: &[Side],
        rows: &[WorkingRow],
    ) {
        match (lq.shape, rows.len()) {
            (_, 0) => self.reach = 0,
            (CHAIN, 0..=4) => columns::<4, CHAIN>(self, problem, lq, sweep, sides, rows),
            (CHAIN, _) => columns::<8, CHAIN>(self, problem, lq, sweep, sides, rows),
            _ => columns::<8, GENERAL>(self, problem, lq, sweep, sides, rows),
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn columns<const L: usize, const SHAPE: Shape>(
    response: &mut RowResponse,
    problem: &Problem,
    lq: &LinearQuadratic,
    sweep: &Sweep,
    sides: &[Side],
    rows: &[WorkingRow],
) {
    let top = rows.iter().fold(0, |top, row| row.stage.max(top));
    response.reach = top;
    let (offsets, gains) = (&mut response.offsets[..top], &sweep.gains[..top]);
    let (sides, d) = (&sides[..top], &problem.d[..top]);
    let mut v = [[0.0; L]; 3];
    let mut gram = [[0.0; L]; L];
    let mut terminal = [[0.0; L]; 3];
    let mut t = [0.0; L];
    for k in (0..top).rev() {
        for (c, row) in rows.iter().enumerate() {
            if row.stage == k + 1 {
                let g = &problem.rows[row.row].gradient;
                for i in 0..3 {
                    v[i][c] = g[i];
                }
            }
        }
        let gain = &gains[k];
        let mut f = [0.0; L];
        for c in 0..L {
            f[c] = lq.input_of::<SHAPE>(&[v[0][c], v[1][c], v[2][c]]);
            t[c] += v[0][c] * d[k][0] + v[1][c] * d[k][1] + v[2][c] * d[k][2];
        }
        let mut next = [[0.0; L]; 3];
        for c in 0..L {
            let w = lq.transposed::<SHAPE>(&[v[0][c], v[1][c], v[2][c]]);
            for i in 0..3 {
                next[i][c] = w[i];
            }
        }
        let offset = f.map(|f| f * gain.inverse);
        offsets[k][..L].copy_from_slice(&offset);
        match sides[k] {
            Side::Free => {
                for c in 0..L {
                    t[c] -= f[c] * gain.feedforward[3];
                    for i in 0..3 {
                        next[i][c] -= gain.feedback[i] * f[c];
                        terminal[i][c] += gain.feedforward[i] * f[c];
                    }
                }
                for e in 0..L {
                    for c in 0..L {
                        gram[e][c] += offset[e] * f[c];
                    }
                }
            }
            side => {
                let held = if side == Side::Upper { problem.u_max } else { problem.u_min };
                for c in 0..L {
                    t[c] += f[c] * held;
                }
            }
        }
        v = next;
    }
    for c in 0..L {
        for i in 0..3 {
            response.terminal[i][c] = terminal[i][c];
        }
        response.gram[c][..L].copy_from_slice(&gram[c]);
    }
    for (c, row) in rows.iter().enumerate() {
        let h = problem.limits[row.row][row.stage];
        response.value[c] = dot(&[v[0][c], v[1][c], v[2][c]], &problem.x0) + (t[c] - h);
    }
}
