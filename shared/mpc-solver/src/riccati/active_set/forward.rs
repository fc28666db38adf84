//! Forward sweep: every input is the minimiser of its stage's cost-to-go, clamped to its bounds.
//!
//! ```text
//! v_k = −(F x_k + f + β y + Σ_c μ_c f_c)/δ,     u_k = clamp(v_k, u_min, u_max)
//! ```
//!
//! The next guess holds each input at the side it was clamped to.

use multiversion::multiversion;

use super::response::RowResponse;
use super::rows::MAX_WORKING_ROWS;
use super::rows::WorkingRow;
use crate::problem::Problem;
use crate::riccati::lqr::{CHAIN, GENERAL, LinearQuadratic, Shape, Sweep};
use crate::riccati::working_set::Side;

/// Everything that determines the inputs.
pub(super) struct Policy<'a> {
    pub(super) lq: &'a LinearQuadratic,
    pub(super) sweep: &'a Sweep,
    /// `y`.
    pub(super) terminal: [f64; 3],
    pub(super) response: &'a RowResponse,
    pub(super) rows: &'a [WorkingRow],
}

/// Trajectory, and the sides it suggests.
pub(super) struct Trajectory<'a> {
    pub(super) inputs: &'a mut [f64],
    pub(super) states: &'a mut [[f64; 3]],
    pub(super) sides: &'a mut [Side],
}

impl Policy<'_> {
    pub(super) fn simulate(&self, problem: &Problem, trajectory: &mut Trajectory) {
        match (self.lq.shape, self.lq.has_disturbance) {
            (CHAIN, false) => sweep_forward::<CHAIN, false>(self, problem, trajectory),
            (CHAIN, true) => sweep_forward::<CHAIN, true>(self, problem, trajectory),
            _ => sweep_forward::<GENERAL, true>(self, problem, trajectory),
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn sweep_forward<const SHAPE: Shape, const DISTURBED: bool>(
    policy: &Policy,
    problem: &Problem,
    trajectory: &mut Trajectory,
) {
    let n = problem.horizon;
    let (lq, y) = (policy.lq, &policy.terminal);
    let (gains, d) = (&policy.sweep.gains[..n], &problem.d[..n]);
    let (inputs, states) = (&mut trajectory.inputs[..n], &mut trajectory.states[..=n]);
    let sides = &mut trajectory.sides[..n];
    let mut mu = [0.0; MAX_WORKING_ROWS];
    for (slot, row) in mu.iter_mut().zip(policy.rows) {
        *slot = row.multiplier;
    }
    let (lo, hi) = (problem.u_min, problem.u_max);
    let mut x = problem.x0;
    states[0] = x;
    for k in 0..n {
        let gain = &gains[k];
        let mut offset = gain.offset(y);
        if k < policy.response.reach {
            let f = &policy.response.offsets[k];
            let mut sums = [0.0; MAX_WORKING_ROWS / 2];
            for c in 0..MAX_WORKING_ROWS / 2 {
                let other = c + MAX_WORKING_ROWS / 2;
                sums[c] = f[c] * mu[c] + f[other] * mu[other];
            }
            offset += (sums[0] + sums[1]) + (sums[2] + sums[3]);
        }
        let v = -gain.input(offset, &x);
        // Branches are faster here than a minimum and a maximum. Sides come in long runs, and a
        // predicted branch does not wait for `v`.
        let (next, u, side) = if v > hi {
            (lq.step::<SHAPE>(&x, hi), hi, Side::Upper)
        } else if v < lo {
            (lq.step::<SHAPE>(&x, lo), lo, Side::Lower)
        } else {
            (lq.closed_step::<SHAPE>(&x, gain, offset, v), v, Side::Free)
        };
        sides[k] = side;
        inputs[k] = u;
        x = if DISTURBED { std::array::from_fn(|i| next[i] + d[k][i]) } else { next };
        states[k + 1] = x;
    }
}
