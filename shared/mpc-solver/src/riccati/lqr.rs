//! Stage-wise solution of an equality-constrained linear-quadratic problem, the basis of both
//! methods.
//!
//! Inputs held at a bound are removed, and quadratic models replace all other inequalities. The
//! rest of the problem is linear-quadratic. Its cost-to-go from stage `k`, with the multiplier `y`
//! of `x_N = x_f` as a parameter, is
//!
//! ```text
//! V_k(x, y) = ½ x'P_k x + p_k'x + y'(Ψ_k'x + t_k − x_f) − ½ y'W_k y + const,
//! P_N = P, p_N = p, Ψ_N = I, t_N = 0, W_N = 0.
//! ```
//!
//! Let `h = p_{k+1} + P_{k+1}d_k`. The stage's own Hessian and gradient are `Q̂`, `q̂`, `r̂`, `ρ̂`:
//! cost plus models of the inequalities. One step backwards is then
//!
//! ```text
//! F = B'P_{k+1}A + s'      δ = r̂ + B'P_{k+1}B      f = B'h + ρ̂      β = B'Ψ_{k+1}
//! u_k = −(F x_k + f + β y)/δ                                             (input free)
//! P_k = Q̂ + A'P_{k+1}A − F'F/δ          p_k = q̂ + A'h − F'f/δ
//! Ψ_k = A'Ψ_{k+1} − F'β/δ               W_k = W_{k+1} + β'β/δ
//! t_k = t_{k+1} + Ψ_{k+1}'d_k − β'f/δ
//! ```
//!
//! For an input held at `ū`, the fractions vanish and `ρ̂` drops out. `h` becomes `h + P_{k+1}B ū`,
//! `q̂` gains `s ū`, and `t_k` gains `β'ū`. `V_0` is stationary in `y` at
//! `W_0 y = Ψ_0'x_0 + t_0 − x_f`; one forward sweep then gives the trajectory.
//!
//! There is one division per stage. Only the gains are stored and, every [`STRIDE`] stages, the
//! cost-to-go. A sweep can be resumed at a stage above which nothing has changed.
//!
//! The sweep cannot fail: `r > 0` and the models are convex, so `δ ≥ r > 0` in exact arithmetic.
//! Numbers beyond the range of `f64` appear in the trajectory, which the callers check.

mod backward;
mod cost;
#[cfg(test)]
mod tests;

use super::lanes::{Lanes, WIDTH};
use super::matrix::{Factors, Symmetric};
use crate::problem::Problem;
pub(super) use backward::{BlockModels, Unconstrained};
pub(super) use cost::{BlockModel, Cost};

/// Structure of the dynamics known at compile time. Products with one and sums with zero cost nothing, and dependent
/// results come earlier.
pub(super) type Shape = u8;
/// No structure.
pub(super) const GENERAL: Shape = 0;
/// The first two states integrate (`a_00 = a_11 = 1`), and the input acts on the last state only.
pub(super) const CHAIN: Shape = 1;

/// Constant part of a problem, unpacked for the recursion.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinearQuadratic {
    a: Symmetric,
    b: [f64; 3],
    s: [f64; 3],
    r: f64,
    pub(super) shape: Shape,
    /// True if any `d_k` is nonzero.
    pub(super) has_disturbance: bool,
    /// True if any linear cost or `d_k` is nonzero.
    pub(super) has_linear_terms: bool,
}

/// Minimising input of a stage: `u = −(feedback·x + constant + terminal·y)`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gain {
    /// `F/δ`.
    pub(super) feedback: [f64; 3],
    /// `1/δ`.
    pub(super) inverse: f64,
    /// `β/δ`, and `f/δ` in the last lane.
    pub(super) feedforward: [f64; 4],
}

/// Linear and dual parts of the cost-to-go at a stage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CostToGo {
    /// `Ψ | p`, row by row.
    linear: [Lanes; 3],
    /// `W`.
    dual: Dual,
    /// `t` in the first three lanes.
    reached: Lanes,
}

/// Sum of `β'β/δ`: its diagonal, and the entries 01, 12, 02; the last lanes have no meaning.
#[derive(Clone, Copy, Debug, Default)]
struct Dual {
    diagonal: Lanes,
    beside: Lanes,
}

impl Dual {
    /// Adds `β'γ`, which is symmetric.
    #[inline(always)]
    fn add(&mut self, beta: Lanes, gamma: Lanes) {
        self.diagonal = self.diagonal + beta * gamma;
        self.beside = self.beside + beta.rotated() * gamma;
    }
}

/// `W y = miss`: the terminal equality after a sweep.
#[derive(Clone, Copy, Debug)]
pub(super) struct TerminalSystem {
    /// `W`.
    pub(super) factors: Factors,
    /// Error at the end for `y = 0`.
    pub(super) miss: [f64; 3],
}

/// Number of stages between two stored costs-to-go.
const STRIDE: usize = 8;

/// Gains of all stages, and costs-to-go from which a sweep can be resumed.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    /// Gains with room for whole blocks of stages.
    pub(super) gains: Vec<Gain>,
    /// Entry `i` belongs to stage `STRIDE · i`.
    hessians: Vec<Symmetric>,
    costs: Vec<CostToGo>,
}

impl Sweep {
    pub(super) fn new(max_horizon: usize) -> Self {
        let stored = max_horizon / STRIDE + 1;
        Self {
            gains: vec![Gain::default(); WIDTH * (max_horizon / WIDTH + 1)],
            hessians: vec![[0.0; 6]; stored],
            costs: vec![CostToGo::default(); stored],
        }
    }

    /// Copies another sweep's gains and costs-to-go for `horizon` stages.
    pub(super) fn copy_from(&mut self, other: &Self, horizon: usize) {
        let stored = horizon / STRIDE + 1;
        self.gains[..horizon].copy_from_slice(&other.gains[..horizon]);
        self.hessians[..stored].copy_from_slice(&other.hessians[..stored]);
        self.costs[..stored].copy_from_slice(&other.costs[..stored]);
    }
}

impl LinearQuadratic {
    pub(super) fn new(problem: &Problem) -> Self {
        let n = problem.horizon;
        let has_disturbance = problem.d[..n].iter().any(|d| *d != [0.0; 3]);
        let is_chain =
            [problem.a[0][0], problem.a[1][1], problem.b[0], problem.b[1]] == [1.0, 1.0, 0.0, 0.0];
        let upper = |m: &[[f64; 3]; 3]| [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]];
        Self {
            a: upper(&problem.a),
            b: problem.b,
            s: problem.s,
            r: problem.r,
            shape: if is_chain { CHAIN } else { GENERAL },
            has_disturbance,
            has_linear_terms: problem.has_linear_terms(),
        }
    }

    /// Returns `a_00 x` and `a_11 x`.
    #[inline(always)]
    fn kept<const SHAPE: Shape>(&self, x: [f64; 2]) -> [f64; 2] {
        if SHAPE != GENERAL { x } else { [self.a[0] * x[0], self.a[3] * x[1]] }
    }

    /// Returns `A'v`.
    #[inline(always)]
    pub(super) fn transposed<const SHAPE: Shape>(&self, v: &[f64; 3]) -> [f64; 3] {
        let [_, a01, a02, _, a12, a22] = self.a;
        let [v0, v1] = self.kept::<SHAPE>([v[0], v[1]]);
        [v0, a01 * v[0] + v1, a02 * v[0] + a12 * v[1] + a22 * v[2]]
    }

    /// Returns `A x + B u`.
    #[inline(always)]
    pub(super) fn step<const SHAPE: Shape>(&self, x: &[f64; 3], u: f64) -> [f64; 3] {
        let [_, a01, a02, _, a12, a22] = self.a;
        let b = &self.b;
        let [x0, x1] = self.kept::<SHAPE>([x[0], x[1]]);
        let first = x0 + a01 * x[1] + a02 * x[2];
        let second = x1 + a12 * x[2];
        let third = a22 * x[2] + b[2] * u;
        if SHAPE >= CHAIN {
            [first, second, third]
        } else {
            [first + b[0] * u, second + b[1] * u, third]
        }
    }

    /// Returns `A x + B u` with `u = −(F x + offset)`. The next input waits for the last state. So that state comes
    /// from the last column of `A − B F` and does not wait for `u`.
    #[inline(always)]
    pub(super) fn closed_step<const SHAPE: Shape>(
        &self,
        x: &[f64; 3],
        gain: &Gain,
        offset: f64,
        u: f64,
    ) -> [f64; 3] {
        let [first, second, _] = self.step::<SHAPE>(x, u);
        let rest = offset + (gain.feedback[0] * x[0] + gain.feedback[1] * x[1]);
        let closed = self.a[5] - self.b[2] * gain.feedback[2];
        [first, second, closed * x[2] - self.b[2] * rest]
    }

    /// Returns `A'v + added − F'(B'v + slope)/δ`, the costate one stage earlier. As in
    /// [`Self::closed_step`], the last component comes from the closed loop.
    #[inline(always)]
    pub(super) fn closed_costate<const SHAPE: Shape>(
        &self,
        v: &[f64; 3],
        gain: &Gain,
        slope: f64,
        added: &[f64; 3],
    ) -> [f64; 3] {
        let [_, a01, a02, _, a12, a22] = self.a;
        let [v0, v1] = self.kept::<SHAPE>([v[0], v[1]]);
        let (f, last) = (&gain.feedback, self.b[2]);
        let rest =
            if SHAPE >= CHAIN { slope } else { slope + (self.b[0] * v[0] + self.b[1] * v[1]) };
        // The last component of `v` comes last, because it has just been computed.
        let first = (v0 + added[0]) - f[0] * rest;
        let second = (a01 * v[0] + v1 + added[1]) - f[1] * rest;
        let third = (a02 * v[0] + a12 * v[1] + added[2]) - f[2] * rest;
        [
            first - (f[0] * last) * v[2],
            second - (f[1] * last) * v[2],
            third + (a22 - f[2] * last) * v[2],
        ]
    }

    /// Returns `B'v`.
    #[inline(always)]
    pub(super) fn input_of<const SHAPE: Shape>(&self, v: &[f64; 3]) -> f64 {
        let last = self.b[2] * v[2];
        if SHAPE >= CHAIN { last } else { self.b[0] * v[0] + self.b[1] * v[1] + last }
    }

    /// Returns `A'P A`.
    #[inline(always)]
    fn congruence<const SHAPE: Shape>(&self, p: &Symmetric) -> Symmetric {
        let [_, a01, a02, _, a12, a22] = self.a;
        let ahead = |x: f64, rest: f64| a02 * x + rest;
        let [p00, p01, p02, p11, p12, p22] = *p;
        let [m00, k11] = self.kept::<SHAPE>([p00, p11]);
        let [k00, k01] = self.kept::<SHAPE>([m00, p01]);
        let m01 = a01 * p00 + k01;
        let m02 = ahead(p00, a12 * p01) + a22 * p02;
        let m12 = ahead(p01, a12 * p11) + a22 * p12;
        let m22 = ahead(p02, a12 * p12) + a22 * p22;
        let [n01, n11] = self.kept::<SHAPE>([m01, a01 * p01 + k11]);
        let [n02, n12] = self.kept::<SHAPE>([m02, m12]);
        [k00, n01, n02, a01 * m01 + n11, a01 * m02 + n12, ahead(m02, a12 * m12) + a22 * m22]
    }
}

/// Returns the first stage of a sweep that reuses everything above stage `last`, and its stored
/// entry.
fn resume(horizon: usize, last: usize) -> (usize, usize) {
    let entry = last / STRIDE + 1;
    if entry * STRIDE < horizon { (entry * STRIDE, entry) } else { (horizon, 0) }
}

impl CostToGo {
    /// Returns the system `W_0 y = Ψ_0'x_0 + t_0 − x_f`.
    pub(super) fn terminal_system(&self, problem: &Problem, x_f: &[f64; 3]) -> TerminalSystem {
        let (x, psi) = (&problem.x0, &self.linear);
        let miss = std::array::from_fn(|j| {
            let free = psi[0].0[j] * x[0] + psi[1].0[j] * x[1] + psi[2].0[j] * x[2];
            free + self.reached.0[j] - x_f[j]
        });
        TerminalSystem { factors: self.factors(), miss }
    }

    /// Returns the same system for changes of a trajectory that ends at `x_N`; `y` is the new
    /// multiplier.
    pub(super) fn terminal_system_of_change(
        &self,
        x_n: &[f64; 3],
        x_f: &[f64; 3],
    ) -> TerminalSystem {
        let miss = std::array::from_fn(|j| x_n[j] + self.reached.0[j] - x_f[j]);
        TerminalSystem { factors: self.factors(), miss }
    }

    pub(super) fn factors(&self) -> Factors {
        let [w00, w11, w22, _] = self.dual.diagonal.0;
        let [w01, w12, w02, _] = self.dual.beside.0;
        Factors::new(&[w00, w01, w02, w11, w12, w22])
    }
}

impl TerminalSystem {
    /// Returns `y`.
    pub(super) fn multiplier(&self) -> [f64; 3] {
        self.factors.solve(&self.miss)
    }
}

impl Gain {
    /// Returns `constant + terminal·y`, the part of the input that does not depend on the state.
    #[inline(always)]
    pub(super) fn offset(&self, y: &[f64; 3]) -> f64 {
        self.feedforward[3]
            + (self.feedforward[0] * y[0] + self.feedforward[1] * y[1] + self.feedforward[2] * y[2])
    }

    /// Returns `−u` for an offset. The last state comes last, because the previous input has just changed it.
    #[inline(always)]
    pub(super) fn input(&self, offset: f64, x: &[f64; 3]) -> f64 {
        (offset + (self.feedback[0] * x[0] + self.feedback[1] * x[1])) + self.feedback[2] * x[2]
    }
}
