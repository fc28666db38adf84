//! Construction of a [`Problem`], with every check of its constant parts.

use crate::limits::{MAX_HORIZON, MAX_ROWS, ProblemError};
use crate::problem::{LightCost, LightStage, Problem, Row, Softness, Terminal};
use std::sync::atomic::{AtomicU64, Ordering};

/// Builds so far: solvers keep factors for the constants of one.
static BUILDS: AtomicU64 = AtomicU64::new(1);

/// Builder of a [`Problem`]: dynamics, input cost and bounds are required, the rest is zero or
/// absent.
///
/// ```
/// use mpc_solver::{Problem, ProblemError, Row, Softness};
///
/// let builder = Problem::builder(20)
///     .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
///     .input_bounds(-4.9, 4.9)
///     .input_cost(1.0);
/// assert_eq!(builder.clone().build()?.horizon(), 20);
///
/// // A row may bound stages 1 to 20 only.
/// let row = Row {
///     gradient: [1.0, 0.0, 0.0],
///     from: 1,
///     to: 21,
///     limit: 5.0,
///     softness: Softness::Hard,
/// };
/// assert_eq!(builder.row(row).build(), Err(ProblemError::RowStages(0)));
/// # Ok::<(), ProblemError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ProblemBuilder {
    problem: Problem,
}

impl Problem {
    /// Returns a builder for `horizon` steps, with the identity as dynamics and zero cost.
    pub fn builder(horizon: usize) -> ProblemBuilder {
        ProblemBuilder::new(horizon)
    }
}

impl ProblemBuilder {
    fn new(horizon: usize) -> Self {
        let problem = Problem {
            horizon,
            a: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            b: [0.0; 3],
            q: [[0.0; 3]; 3],
            s: [0.0; 3],
            r: 0.0,
            p: [[0.0; 3]; 3],
            p_lin: [0.0; 3],
            u_min: 0.0,
            u_max: 0.0,
            terminal: Terminal::Cost,
            rows: Vec::new(),
            light: None,
            x0: [0.0; 3],
            d: Vec::new(),
            q_lin: Vec::new(),
            r_lin: Vec::new(),
            limits: Vec::new(),
            light_stages: Vec::new(),
            light_len: 0,
            build: 0,
        };
        Self { problem }
    }

    /// Sets `A` (upper triangular, row by row) and `B`.
    pub fn dynamics(mut self, a: [[f64; 3]; 3], b: [f64; 3]) -> Self {
        self.problem.a = a;
        self.problem.b = b;
        self
    }

    /// Sets `u_min` and `u_max`.
    pub fn input_bounds(mut self, u_min: f64, u_max: f64) -> Self {
        self.problem.u_min = u_min;
        self.problem.u_max = u_max;
        self
    }

    /// Sets `r`.
    pub fn input_cost(mut self, r: f64) -> Self {
        self.problem.r = r;
        self
    }

    /// Sets `Q`, symmetric positive semidefinite.
    pub fn state_cost(mut self, q: [[f64; 3]; 3]) -> Self {
        self.problem.q = q;
        self
    }

    /// Sets `Q` to a diagonal matrix.
    pub fn state_weights(self, q: [f64; 3]) -> Self {
        self.state_cost([[q[0], 0.0, 0.0], [0.0, q[1], 0.0], [0.0, 0.0, q[2]]])
    }

    /// Sets `s`, the cost of state times input.
    pub fn cross_cost(mut self, s: [f64; 3]) -> Self {
        self.problem.s = s;
        self
    }

    /// Adds the jerk cost `½ weight ((u_k − a_k)/τ)²` to the present `Q`, `s` and `r`. `a` is the
    /// third state, `τ` \[s\] the lag of the vehicle.
    pub fn jerk_cost(mut self, weight: f64, tau_s: f64) -> Self {
        let c = weight / (tau_s * tau_s);
        self.problem.q[2][2] += c;
        self.problem.s[2] -= c;
        self.problem.r += c;
        self
    }

    /// Sets `P`, symmetric positive semidefinite.
    pub fn terminal_cost(mut self, p: [[f64; 3]; 3]) -> Self {
        self.problem.p = p;
        self
    }

    /// Sets `P` to a diagonal matrix.
    pub fn terminal_weights(self, p: [f64; 3]) -> Self {
        self.terminal_cost([[p[0], 0.0, 0.0], [0.0, p[1], 0.0], [0.0, 0.0, p[2]]])
    }

    /// Requires `x_N = x_f`.
    pub fn terminal_equality(mut self, x_f: [f64; 3]) -> Self {
        self.problem.terminal = Terminal::Equality(x_f);
        self
    }

    /// Adds a row; rows are numbered from 0 in the order of these calls.
    pub fn row(mut self, row: Row) -> Self {
        self.problem.rows.push(row);
        self
    }

    /// Adds a light, switched off until [`Problem::set_light`].
    pub fn light(mut self, light: LightCost) -> Self {
        self.problem.light = Some(light);
        self
    }

    /// Sets `x_0`; the default is zero.
    pub fn initial_state(mut self, x0: [f64; 3]) -> Self {
        self.problem.x0 = x0;
        self
    }

    /// Checks the problem and allocates its stages.
    ///
    /// # Errors
    /// [`ProblemError`] names the first fault found.
    pub fn build(self) -> Result<Problem, ProblemError> {
        let mut problem = self.problem;
        let n = problem.horizon;
        if n == 0 || n > MAX_HORIZON {
            return Err(ProblemError::Horizon(n));
        }
        check_dynamics(&problem)?;
        check_cost(&problem)?;
        check_rows(&problem)?;
        if let Some(light) = &problem.light {
            check_penalty(&light.softness)?;
            // The comparison is written so that NaN fails as well.
            if !(light.weight > 0.0 && light.weight.is_finite() && light.threshold > 0.0) {
                return Err(ProblemError::Light);
            }
            problem.light_stages = vec![LightStage::default(); n];
        }
        problem.d = vec![[0.0; 3]; n];
        problem.q_lin = vec![[0.0; 3]; n];
        problem.r_lin = vec![0.0; n];
        problem.limits = problem.rows.iter().map(|row| vec![row.limit; n + 1]).collect();
        problem.check()?;
        problem.build = BUILDS.fetch_add(1, Ordering::Relaxed);
        Ok(problem)
    }
}

fn check_dynamics(problem: &Problem) -> Result<(), ProblemError> {
    let (a, b) = (&problem.a, &problem.b);
    if a.iter().flatten().chain(b).any(|x| !x.is_finite()) {
        return Err(ProblemError::NotFinite("dynamics"));
    }
    if a[1][0] != 0.0 || a[2][0] != 0.0 || a[2][1] != 0.0 {
        return Err(ProblemError::NotUpperTriangular);
    }
    if *b == [0.0; 3] {
        return Err(ProblemError::NoInput);
    }
    if !(problem.u_min.is_finite() && problem.u_max.is_finite()) {
        return Err(ProblemError::NotFinite("input bound"));
    }
    if problem.u_min >= problem.u_max {
        return Err(ProblemError::EmptyInputRange);
    }
    Ok(())
}

fn check_cost(problem: &Problem) -> Result<(), ProblemError> {
    let entries = problem.q.iter().chain(&problem.p).flatten().chain(&problem.s);
    if entries.chain([&problem.r]).any(|x| !x.is_finite()) {
        return Err(ProblemError::NotFinite("cost"));
    }
    if problem.r <= 0.0 {
        return Err(ProblemError::InputCost);
    }
    let mut reduced = problem.q;
    for i in 0..3 {
        for j in 0..3 {
            if problem.q[i][j] != problem.q[j][i] {
                return Err(ProblemError::NotSymmetric("state cost"));
            }
            if problem.p[i][j] != problem.p[j][i] {
                return Err(ProblemError::NotSymmetric("terminal cost"));
            }
            reduced[i][j] -= problem.s[i] * problem.s[j] / problem.r;
        }
    }
    if !is_semidefinite(reduced, &problem.q) {
        return Err(ProblemError::NotConvex("stage cost"));
    }
    if !is_semidefinite(problem.p, &problem.p) {
        return Err(ProblemError::NotConvex("terminal cost"));
    }
    Ok(())
}

fn check_rows(problem: &Problem) -> Result<(), ProblemError> {
    if problem.rows.len() > MAX_ROWS {
        return Err(ProblemError::TooManyRows(problem.rows.len()));
    }
    for (j, row) in problem.rows.iter().enumerate() {
        if row.gradient.iter().any(|x| !x.is_finite()) {
            return Err(ProblemError::NotFinite("row gradient"));
        }
        if row.gradient == [0.0; 3] {
            return Err(ProblemError::EmptyRow(j));
        }
        if row.from == 0 || row.to > problem.horizon {
            return Err(ProblemError::RowStages(j));
        }
        check_penalty(&row.softness)?;
    }
    Ok(())
}

fn check_penalty(softness: &Softness) -> Result<(), ProblemError> {
    match *softness {
        Softness::Soft { linear, quadratic }
            if !(linear > 0.0
                && linear.is_finite()
                && quadratic >= 0.0
                && quadratic.is_finite()) =>
        {
            Err(ProblemError::PenaltyWeight)
        }
        _ => Ok(()),
    }
}

/// Gaussian elimination of the matrix with 1e-12 of the largest entry of `scale` added to the diagonal: its pivots are
/// positive.
fn is_semidefinite(mut m: [[f64; 3]; 3], scale: &[[f64; 3]; 3]) -> bool {
    let largest = scale.iter().flatten().fold(0.0_f64, |top, x| top.max(x.abs()));
    (0..3).all(|k| {
        m[k][k] += 1e-12 * largest + f64::MIN_POSITIVE;
        for i in k + 1..3 {
            for j in k + 1..3 {
                m[i][j] -= m[i][k] * m[k][j] / m[k][k];
            }
        }
        m[k][k] > 0.0
    })
}
