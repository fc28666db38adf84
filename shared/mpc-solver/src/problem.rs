//! The problem as data: constants from the builder, and values that a control cycle overwrites.

use crate::limits::ProblemError;

/// Treatment of a violated limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Softness {
    /// The limit holds, or the problem is infeasible.
    Hard,
    /// Exact penalty on the violation `σ ≥ 0`: `linear · σ + ½ quadratic · σ²`.
    Soft {
        /// Penalty weight `λ > 0` of the violation \[cost per unit\].
        linear: f64,
        /// Quadratic penalty weight `κ ≥ 0` \[cost per unit squared\]; the light ignores it.
        quadratic: f64,
    },
}

impl Softness {
    /// Returns `(λ, κ)`; a hard limit has an infinite `λ`.
    pub(crate) fn penalty(self) -> (f64, f64) {
        match self {
            Self::Hard => (f64::INFINITY, 0.0),
            Self::Soft { linear, quadratic } => (linear, quadratic),
        }
    }
}

/// A bound `g'x_k ≤ h_k` on the stages `from..=to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Bounded linear function `g` of the state.
    pub gradient: [f64; 3],
    /// First bounded stage, at least 1.
    pub from: usize,
    /// Last bounded stage, at most `N`; a value below `from` switches the row off.
    pub to: usize,
    /// Limit `h` of all stages; [`Problem::row_limits_mut`] changes it stage by stage.
    pub limit: f64,
    /// Hard or soft.
    pub softness: Softness,
}

/// Weights of the light's cost `w (1/min(D, d_th) − 1/d_th)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCost {
    /// Weight `w > 0` \[cost·m\].
    pub weight: f64,
    /// Threshold `d_th > 0` \[m\], beyond which the margin costs nothing; may be infinite.
    pub threshold: f64,
    /// Hard: `D > 0`, or the problem is infeasible. Soft: linear penalty weight of the margin's
    /// shortfall \[cost/m\].
    pub softness: Softness,
}

/// The margin `D_k = c_k'x_k + o_k` at one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightStage {
    /// `c_k`.
    pub gradient: [f64; 3],
    /// `o_k` \[m\].
    pub offset: f64,
}

/// Treatment of the last state, besides its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Terminal {
    /// `½ x_N'P x_N + p'x_N` only.
    Cost,
    /// The same cost, and `x_N = x_f`.
    Equality([f64; 3]),
}

/// Problem of the class described at the head of the crate.
///
/// ```
/// use mpc_solver::{Problem, Riccati, Row, Softness, Solver, Start, Status};
///
/// // States: spacing error (m), relative speed (m/s), acceleration (m/s²). Steps of 0.1 s, a lag of 0.5 s.
/// let mut problem = Problem::builder(50)
///     .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
///     .input_bounds(-4.9, 4.9)
///     .input_cost(1.0)
///     .state_weights([10.0, 50.0, 0.0])
///     .terminal_weights([100.0, 500.0, 1.0])
///     // At most 12 m too close.
///     .row(Row {
///         gradient: [1.0, 0.0, 0.0],
///         from: 3,
///         to: 50,
///         limit: 12.0,
///         softness: Softness::Soft { linear: 1e5, quadratic: 0.0 },
///     })
///     .build()?;
/// let mut solver = Riccati::new(50);
///
/// // 10 m too close and 4 m/s faster than the vehicle ahead: brake.
/// problem.set_initial_state([10.0, 4.0, 0.0]);
/// let report = solver.solve(&problem, Start::Cold);
/// assert_eq!(report.status, Status::Solved);
/// assert_eq!(solver.inputs()[0], -4.9);
///
/// // One cycle later: overwrite the state and solve again.
/// problem.set_initial_state(solver.states()[1]);
/// assert_eq!(solver.solve(&problem, Start::Shifted(1)).status, Status::Solved);
/// # Ok::<(), mpc_solver::ProblemError>(())
/// ```
///
/// The builder checks weights, dynamics and bounds, which are constant. Values that a control cycle
/// changes have setters here, which check nothing. [`crate::Solver::solve`] calls
/// [`Problem::check`] and reports bad numbers as [`crate::Status::InvalidInput`].
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    pub(crate) horizon: usize,
    pub(crate) a: [[f64; 3]; 3],
    pub(crate) b: [f64; 3],
    pub(crate) q: [[f64; 3]; 3],
    pub(crate) s: [f64; 3],
    pub(crate) r: f64,
    pub(crate) p: [[f64; 3]; 3],
    pub(crate) p_lin: [f64; 3],
    pub(crate) u_min: f64,
    pub(crate) u_max: f64,
    pub(crate) terminal: Terminal,
    pub(crate) rows: Vec<Row>,
    pub(crate) light: Option<LightCost>,
    pub(crate) x0: [f64; 3],
    pub(crate) d: Vec<[f64; 3]>,
    pub(crate) q_lin: Vec<[f64; 3]>,
    pub(crate) r_lin: Vec<f64>,
    /// `limits[j][k]` = `h_{j,k}` for `k = 0..=N` (entry 0 is not used).
    pub(crate) limits: Vec<Vec<f64>>,
    /// `light_stages[k - 1]` is stage `k`; the first `light_len` are in force.
    pub(crate) light_stages: Vec<LightStage>,
    pub(crate) light_len: usize,
    /// Number of the build: problems with one number have the same constants.
    pub(crate) build: u64,
}

impl Problem {
    /// Sets `x_0`.
    pub fn set_initial_state(&mut self, x0: [f64; 3]) {
        self.x0 = x0;
    }

    /// Sets `x_f`; has no effect on a problem with [`Terminal::Cost`].
    pub fn set_terminal_target(&mut self, target: [f64; 3]) {
        if let Terminal::Equality(x_f) = &mut self.terminal {
            *x_f = target;
        }
    }

    /// Sets `p`, the linear part of the terminal cost.
    pub fn set_terminal_gradient(&mut self, gradient: [f64; 3]) {
        self.p_lin = gradient;
    }

    /// Returns `d_k`, `k = 0..N`, initially zero.
    pub fn disturbances_mut(&mut self) -> &mut [[f64; 3]] {
        &mut self.d
    }

    /// Returns `q_k`, `k = 0..N`, initially zero.
    pub fn state_gradients_mut(&mut self) -> &mut [[f64; 3]] {
        &mut self.q_lin
    }

    /// Returns `ρ_k`, `k = 0..N`, initially zero.
    pub fn input_gradients_mut(&mut self) -> &mut [f64] {
        &mut self.r_lin
    }

    /// Returns `h_{row,k}`, `k = 0..=N`; rows are numbered in the order of
    /// [`crate::ProblemBuilder::row`]. Positive infinity means no limit. Entry 0 is not used.
    ///
    /// # Panics
    /// If the problem has no such row.
    pub fn row_limits_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.limits[row]
    }

    /// Moves a row to the stages `from..=to`, cut to `1..=N`; `to < from` switches it off.
    ///
    /// # Panics
    /// If the problem has no such row.
    pub fn set_row_stages(&mut self, row: usize, from: usize, to: usize) {
        self.rows[row].from = from.max(1);
        self.rows[row].to = to.min(self.horizon);
    }

    /// Sets the margins of stages `1..=K` from an iterator, first stage first. Stages beyond the
    /// horizon are dropped. An empty iterator switches the light off.
    ///
    /// Has no effect on a problem without [`crate::ProblemBuilder::light`].
    pub fn set_light(&mut self, stages: impl IntoIterator<Item = LightStage>) {
        self.light_len = 0;
        for (slot, stage) in self.light_stages.iter_mut().zip(stages) {
            *slot = stage;
            self.light_len += 1;
        }
    }

    /// Checks that all numbers that a control cycle may overwrite are finite; only limits may be
    /// `+∞`.
    ///
    /// # Errors
    /// The first [`ProblemError`] found.
    pub fn check(&self) -> Result<(), ProblemError> {
        // 0·x is zero for a finite x and NaN otherwise. One sum needs no branch per number.
        let mut sum = self.x0.iter().map(|x| 0.0 * x).sum::<f64>();
        if self.has_linear_terms() {
            sum += self.p_lin.iter().map(|x| 0.0 * x).sum::<f64>();
            for k in 0..self.horizon {
                let (d, q) = (&self.d[k], &self.q_lin[k]);
                sum += 0.0 * (d[0] + d[1] + d[2] + q[0] + q[1] + q[2] + self.r_lin[k]);
            }
        }
        for stage in &self.light_stages[..self.light_len] {
            let c = &stage.gradient;
            sum += 0.0 * (c[0] + c[1] + c[2] + stage.offset);
        }
        if let Terminal::Equality(x_f) = &self.terminal {
            sum += 0.0 * (x_f[0] + x_f[1] + x_f[2]);
        }
        if sum != 0.0 {
            return Err(ProblemError::NotFinite("state, disturbance, gradient, light or target"));
        }
        for (row, limits) in self.rows.iter().zip(&self.limits) {
            let limits = limits.get(row.from..=row.to).unwrap_or_default();
            // NaN is above nothing.
            if !limits.iter().fold(true, |all, h| all & (*h > f64::NEG_INFINITY)) {
                return Err(ProblemError::NotFinite("row limit"));
            }
        }
        Ok(())
    }

    /// True if any linear cost or `d_k` is not zero.
    pub(crate) fn has_linear_terms(&self) -> bool {
        let n = self.horizon;
        let any = |values: &[f64]| values.iter().fold(false, |any, x| any | (*x != 0.0));
        any(self.d[..n].as_flattened())
            || any(self.q_lin[..n].as_flattened())
            || any(&self.r_lin[..n])
            || any(&self.p_lin)
    }

    /// Number of steps `N`.
    pub fn horizon(&self) -> usize {
        self.horizon
    }

    /// Returns `x_0`.
    pub fn initial_state(&self) -> [f64; 3] {
        self.x0
    }

    /// Returns `(u_min, u_max)`.
    pub fn input_bounds(&self) -> (f64, f64) {
        (self.u_min, self.u_max)
    }

    /// Returns the rows in the order in which they were added.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Returns the margins in force, stages `1..=K`.
    pub fn light_stages(&self) -> &[LightStage] {
        &self.light_stages[..self.light_len]
    }

    /// Returns the next state `A x + B u + d_k`.
    #[inline]
    pub fn step(&self, k: usize, x: &[f64; 3], u: f64) -> [f64; 3] {
        let (a, b, d) = (&self.a, &self.b, &self.d[k]);
        [
            a[0][0] * x[0] + a[0][1] * x[1] + a[0][2] * x[2] + b[0] * u + d[0],
            a[1][1] * x[1] + a[1][2] * x[2] + b[1] * u + d[1],
            a[2][2] * x[2] + b[2] * u + d[2],
        ]
    }

    /// Writes the states that follow from `inputs` to `states[0..=N]`.
    ///
    /// ```
    /// use mpc_solver::Problem;
    ///
    /// let problem = Problem::builder(2)
    ///     .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
    ///     .input_bounds(-4.9, 4.9)
    ///     .input_cost(1.0)
    ///     .initial_state([0.0, 10.0, 0.0])
    ///     .build()?;
    /// let mut states = [[0.0; 3]; 3];
    /// problem.roll_out(&[1.0, 0.0], &mut states);
    /// assert_eq!(states[1], [1.0, 10.0, 0.2]);
    /// # Ok::<(), mpc_solver::ProblemError>(())
    /// ```
    ///
    /// # Panics
    /// If `inputs` is shorter than `N` or `states` shorter than `N + 1`.
    pub fn roll_out(&self, inputs: &[f64], states: &mut [[f64; 3]]) {
        let mut x = self.x0;
        states[0] = x;
        for k in 0..self.horizon {
            x = self.step(k, &x, inputs[k]);
            states[k + 1] = x;
        }
    }

    /// Returns the objective of a pair of trajectories, penalties included. It is infinite outside
    /// of a hard light's domain. Violations of hard rows, bounds and the terminal equality cost
    /// nothing here.
    ///
    /// # Panics
    /// If `inputs` is shorter than `N` or `states` shorter than `N + 1`.
    pub fn objective(&self, inputs: &[f64], states: &[[f64; 3]]) -> f64 {
        let mut cost = 0.0;
        for k in 0..self.horizon {
            let (x, u, q) = (&states[k], inputs[k], &self.q_lin[k]);
            cost += 0.5 * quadratic(&self.q, x) + dot(q, x);
            cost += u * (dot(&self.s, x) + 0.5 * self.r * u + self.r_lin[k]);
        }
        let x_n = &states[self.horizon];
        cost += 0.5 * quadratic(&self.p, x_n) + dot(&self.p_lin, x_n);
        for (row, limits) in self.rows.iter().zip(&self.limits) {
            if let Softness::Soft { linear, quadratic } = row.softness {
                for k in row.from..=row.to {
                    let z = (dot(&row.gradient, &states[k]) - limits[k]).max(0.0);
                    cost += z * (linear + 0.5 * quadratic * z);
                }
            }
        }
        if let Some(light) = &self.light {
            for (stage, x) in self.light_stages().iter().zip(&states[1..]) {
                cost += light.value(dot(&stage.gradient, x) + stage.offset);
            }
        }
        cost
    }
}

impl LightCost {
    /// Returns `φ(D)`.
    pub fn value(&self, margin: f64) -> f64 {
        let level = |p: f64| self.weight * (1.0 / p.min(self.threshold) - 1.0 / self.threshold);
        match self.softness {
            Softness::Hard if margin <= 0.0 => f64::INFINITY,
            Softness::Hard => level(margin),
            Softness::Soft { linear, .. } => {
                let knee = (self.weight / linear).sqrt().min(self.threshold);
                if margin < knee { level(knee) + linear * (knee - margin) } else { level(margin) }
            }
        }
    }
}

#[inline]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn quadratic(m: &[[f64; 3]; 3], x: &[f64; 3]) -> f64 {
    dot(&[dot(&m[0], x), dot(&m[1], x), dot(&m[2], x)], x)
}
