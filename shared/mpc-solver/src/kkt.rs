//! Optimality conditions, evaluated from the problem's definition alone.
//!
//! With multipliers `μ_{j,k}` of the rows, `α_k` of the light and `y` of the terminal equality, and
//! the costates
//!
//! ```text
//! λ_N = P x_N + p + y + Σ_j μ_{j,N} g_j − α_N c_N
//! λ_k = Q x_k + q_k + s u_k + A'λ_{k+1} + Σ_j μ_{j,k} g_j − α_k c_k
//! ```
//!
//! a point is optimal when the states follow from the inputs and
//!
//! ```text
//! v_k = r u_k + s'x_k + ρ_k + B'λ_{k+1}     is ≥ 0 at u_min, ≤ 0 at u_max, 0 between
//! μ_{j,k} ∈ ∂ψ_j(g_j'x_k − h_{j,k}),   −α_k ∈ ∂φ(D_k),   x_N = x_f
//! ```
//!
//! The last three are graphs of monotone functions. The residual of each is the smaller of its
//! primal and its dual distance from the graph:
//!
//! * Primal distances (m, m/s, m/s²) are relative to `max(1, |limit|)`.
//! * Dual distances are relative to the largest multiplier of a row, the light or the terminal
//!   equality, at least 1.
//! * The scale of `v_k` is at least the largest `B'λ` from stage `k` on, as that number has to cancel in it.

use multiversion::multiversion;

use crate::limits::MAX_ROWS;
use crate::problem::{Problem, Softness, Terminal, dot};

/// Multipliers of a solution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multipliers {
    /// `rows[j][k]` = `μ_{j,k}`, `k = 0..=N`; zero where the row is not in force.
    pub rows: [Vec<f64>; MAX_ROWS],
    /// `light[k]` = `α_k`, `k = 0..=N`; zero where the light is not in force.
    pub light: Vec<f64>,
    /// `y`.
    pub terminal: [f64; 3],
}

impl Multipliers {
    /// Zero multipliers for horizons up to `max_horizon`.
    pub fn new(max_horizon: usize) -> Self {
        let zeros = || vec![0.0; max_horizon + 1];
        Self { rows: std::array::from_fn(|_| zeros()), light: zeros(), terminal: [0.0; 3] }
    }

    /// Sets all multipliers to zero.
    pub fn clear(&mut self) {
        for row in &mut self.rows {
            row.fill(0.0);
        }
        self.light.fill(0.0);
        self.terminal = [0.0; 3];
    }
}

/// Scaled residuals of the optimality conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residuals {
    /// Inputs: projected gradient.
    pub stationarity: f64,
    /// Rows and light: distance from their graphs.
    pub complementarity: f64,
    /// Terminal equality and input bounds.
    pub feasibility: f64,
}

impl Residuals {
    /// Returns the largest of the three, or infinity if one of them is NaN.
    pub fn max(&self) -> f64 {
        let sum = self.stationarity + self.complementarity + self.feasibility;
        if sum.is_nan() {
            return f64::INFINITY;
        }
        self.stationarity.max(self.complementarity).max(self.feasibility)
    }
}

/// Evaluates the optimality conditions at `inputs`, at the states that follow from them, and at
/// `multipliers`.
///
/// ```
/// use mpc_solver::{Problem, Riccati, Solver, Start, residuals};
///
/// let problem = Problem::builder(30)
///     .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
///     .input_bounds(-4.9, 4.9)
///     .input_cost(1.0)
///     .state_weights([1.0, 5.0, 0.0])
///     .initial_state([10.0, 4.0, 0.0])
///     .build()?;
/// let mut solver = Riccati::new(30);
/// solver.solve(&problem, Start::Cold);
/// let optimal = residuals(&problem, solver.inputs(), solver.states(), solver.multipliers());
/// assert!(optimal.max() < 1e-8);
///
/// // Other inputs with the same multipliers are not optimal.
/// let (inputs, mut states) = ([0.0; 30], [[0.0; 3]; 31]);
/// problem.roll_out(&inputs, &mut states);
/// assert!(residuals(&problem, &inputs, &states, solver.multipliers()).max() > 1e-3);
/// # Ok::<(), mpc_solver::ProblemError>(())
/// ```
///
/// # Panics
/// If a slice is shorter than the problem's horizon requires.
#[multiversion(targets("x86_64+avx2"))]
pub fn residuals(
    problem: &Problem,
    inputs: &[f64],
    states: &[[f64; 3]],
    multipliers: &Multipliers,
) -> Residuals {
    let n = problem.horizon;
    let scale = dual_scale(problem, multipliers);
    let mut out = Residuals::default();
    let mut cancelled: f64 = 0.0;
    // NaN must survive the maximum.
    let worst = |slot: &mut f64, value: f64| {
        if value > *slot || value.is_nan() {
            *slot = value;
        }
    };
    // Rows behind the last one with a multiplier do not act on the costate.
    let mut rows = multipliers.rows[..problem.rows.len()].iter();
    let forced = rows.rposition(|mus| has_any(&mus[..=n])).map_or(0, |last| last + 1);
    for (j, row) in problem.rows.iter().enumerate() {
        for k in row.from..=row.to {
            let (h, mu) = (problem.limits[j][k], multipliers.rows[j][k]);
            let z = dot(&row.gradient, &states[k]) - h;
            // A limit that holds without a multiplier lies on its graph: its residual is zero.
            if (mu == 0.0 && z <= 0.0) || h == f64::INFINITY {
                continue;
            }
            worst(&mut out.complementarity, 0.0 * (z + mu));
            let distance = row_distance(&row.softness, z, mu, h.abs().max(1.0), scale);
            worst(&mut out.complementarity, distance);
        }
    }
    let at_end = |i: usize| multipliers.terminal[i] + dot(&problem.p[i], &states[n]);
    let mut costate = [0, 1, 2].map(|i| at_end(i) + problem.p_lin[i]);
    for k in (0..=n).rev() {
        let x = &states[k];
        if k < n {
            let u = inputs[k];
            let v =
                problem.r * u + dot(&problem.s, x) + problem.r_lin[k] + dot(&problem.b, &costate);
            let room = if v > 0.0 { u - problem.u_min } else { problem.u_max - u };
            // A minimum would drop a number that is not finite.
            worst(&mut out.stationarity, 0.0 * v);
            cancelled = cancelled.max(dot(&problem.b, &costate).abs());
            worst(&mut out.stationarity, (v.abs() / scale.max(cancelled)).min(room.max(0.0)));
            worst(&mut out.feasibility, (problem.u_min - u).max(u - problem.u_max).max(0.0));
            let (a, q, s) = (&problem.a, &problem.q, &problem.s);
            let ahead = [
                a[0][0] * costate[0],
                a[0][1] * costate[0] + a[1][1] * costate[1],
                a[0][2] * costate[0] + a[1][2] * costate[1] + a[2][2] * costate[2],
            ];
            let q_lin = &problem.q_lin[k];
            costate = [0, 1, 2].map(|i| (ahead[i] + dot(&q[i], x)) + (q_lin[i] + s[i] * u));
        }
        for (j, row) in problem.rows.iter().enumerate().take(forced) {
            let mu = multipliers.rows[j][k];
            if mu != 0.0 && is_bounded(problem, j, k) {
                for i in 0..3 {
                    costate[i] += mu * row.gradient[i];
                }
            }
        }
        if k >= 1 && k <= problem.light_len {
            let stage = &problem.light_stages[k - 1];
            let alpha = multipliers.light[k];
            let margin = dot(&stage.gradient, x) + stage.offset;
            worst(&mut out.complementarity, 0.0 * (margin + alpha));
            worst(&mut out.complementarity, light_distance(problem, margin, alpha, scale));
            for i in 0..3 {
                costate[i] -= alpha * stage.gradient[i];
            }
        }
    }
    if let Terminal::Equality(x_f) = &problem.terminal {
        for i in 0..3 {
            worst(&mut out.feasibility, (states[n][i] - x_f[i]).abs() / x_f[i].abs().max(1.0));
        }
    }
    out
}

/// Returns the largest multiplier of a row, the light or the terminal equality, at least 1.
fn dual_scale(problem: &Problem, multipliers: &Multipliers) -> f64 {
    let n = problem.horizon;
    let rows = multipliers.rows[..problem.rows.len()].iter().map(|row| &row[..=n]);
    let light = &multipliers.light[..=problem.light_len];
    let mut top: f64 = 1.0;
    for values in rows.chain([light, &multipliers.terminal]) {
        if has_any(values) {
            top = values.iter().fold(top, |top, m| top.max(m.abs()));
        }
    }
    top
}

/// Returns whether any value is not zero. Mostly none is, which this loop finds faster than one with a maximum.
#[inline(always)]
fn has_any(values: &[f64]) -> bool {
    values.iter().fold(false, |any, value| any | (*value != 0.0))
}

/// Returns whether row `j` bounds stage `k`.
fn is_bounded(problem: &Problem, j: usize, k: usize) -> bool {
    let row = &problem.rows[j];
    (row.from..=row.to).contains(&k) && problem.limits[j][k] < f64::INFINITY
}

/// Distance of `(z, μ)` from the graph of `∂ψ`.
fn row_distance(softness: &Softness, z: f64, mu: f64, primal: f64, dual: f64) -> f64 {
    match *softness {
        // μ ≥ 0, z ≤ 0, one of them zero.
        Softness::Hard => (-mu / dual).max(z / primal).max((mu / dual).min(-z / primal)),
        Softness::Soft { linear, quadratic } => {
            // The graph: 0 for z < 0, [0, λ] at z = 0, λ + κ z for z > 0.
            let slope = if z > 0.0 { linear + quadratic * z } else { 0.0 };
            let vertical = (mu - mu.clamp(0.0, linear)).abs() / dual;
            ((mu - slope).abs() / dual).min(vertical.max(z.abs() / primal))
        }
    }
}

/// Distance of `(D, α)` from the graph of `−∂φ`.
fn light_distance(problem: &Problem, margin: f64, alpha: f64, dual: f64) -> f64 {
    let Some(light) = &problem.light else { return 0.0 };
    let (top, _) = light.softness.penalty();
    let d_th = light.threshold;
    if margin <= 0.0 && top == f64::INFINITY {
        return f64::INFINITY;
    }
    // The graph is min(w/D², λ) below d_th, falls to zero at d_th, and is zero beyond.
    let slope = if margin >= d_th {
        0.0
    } else if margin <= 0.0 {
        top
    } else {
        (light.weight / (margin * margin)).min(top)
    };
    let by_dual = (alpha - slope).abs() / dual;
    // Horizontal distance: the margin at which the graph has this multiplier.
    let by_primal = if alpha > 0.0 && alpha <= top {
        (margin - (light.weight / alpha).sqrt().min(d_th)).abs() / margin.abs().max(1.0)
    } else {
        f64::INFINITY
    };
    by_dual.min(by_primal)
}
