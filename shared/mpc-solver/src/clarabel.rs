//! Adapter to the general conic solver clarabel: oracle of the tests, and fallback.
//!
//! The variables are the inputs, the states `x_1 … x_N`, and one slack per stage of a soft row.
//! Each stage of the light has `p`, `t` and (soft) a slack `σ`, with
//!
//! ```text
//! p ≤ D (+ σ),   p ≤ d_th,   t p ≥ c²   as   (t + p, t − p, 2c) in the second-order cone
//! ```
//!
//! and the cost `w t/c²`. The constant `c` brings the cone's entries to the same magnitude.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::kkt::{Multipliers, Residuals, residuals};
use crate::limits::MAX_ROWS;
use crate::problem::{Problem, Softness, Terminal};
use crate::solver::{Report, Solver, Start, Status};

/// `c` \[m\], about the margin at which the cost matters.
const CONE_SCALE: f64 = 20.0;

/// Adapter to clarabel. It assembles each problem anew and allocates: it is not for a realtime
/// loop.
///
/// It solves every [`Problem`] that [`crate::Riccati`] solves, some hundred times slower, and
/// shares no code with it.
///
/// ```
/// use mpc_solver::{Clarabel, Problem, Riccati, Solver, Start};
///
/// let problem = Problem::builder(30)
///     .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
///     .input_bounds(-4.9, 4.9)
///     .input_cost(1.0)
///     .state_weights([1.0, 5.0, 0.0])
///     .initial_state([10.0, 4.0, 0.0])
///     .build()?;
/// let (mut ours, mut general) = (Riccati::new(30), Clarabel::new());
/// ours.solve(&problem, Start::Cold);
/// general.solve(&problem, Start::Cold);
/// let cost = problem.objective(ours.inputs(), ours.states());
/// let difference = problem.objective(general.inputs(), general.states()) - cost;
/// assert!(difference.abs() < 1e-6 * cost);
/// # Ok::<(), mpc_solver::ProblemError>(())
/// ```
pub struct Clarabel {
    tolerance: f64,
    inner: Option<DefaultSolver<f64>>,
    layout: Layout,
    inputs: Vec<f64>,
    states: Vec<[f64; 3]>,
    multipliers: Multipliers,
}

/// First indices of the constraints whose multipliers are read back.
#[derive(Default)]
struct Layout {
    terminal: Option<usize>,
    /// Constraints of each row, with their stages.
    rows: [Vec<(usize, usize)>; MAX_ROWS],
    light: usize,
}

/// A sparse matrix and right-hand side under construction.
#[derive(Default)]
struct Triplets {
    i: Vec<usize>,
    j: Vec<usize>,
    v: Vec<f64>,
    rhs: Vec<f64>,
}

impl Triplets {
    /// Adds a constraint of these columns and returns its index.
    fn constrain(&mut self, entries: &[(usize, f64)], rhs: f64) -> usize {
        for &(j, v) in entries.iter().filter(|(_, v)| *v != 0.0) {
            self.i.push(self.rhs.len());
            self.j.push(j);
            self.v.push(v);
        }
        self.rhs.push(rhs);
        self.rhs.len() - 1
    }
}

impl Default for Clarabel {
    fn default() -> Self {
        Self::new()
    }
}

impl Clarabel {
    /// Returns a solver with a tolerance of 1e-9.
    pub fn new() -> Self {
        Self::with_tolerance(1e-9)
    }

    /// Returns a solver with this tolerance for the duality gap and for feasibility.
    pub fn with_tolerance(tolerance: f64) -> Self {
        Self {
            tolerance,
            inner: None,
            layout: Layout::default(),
            inputs: Vec::new(),
            states: Vec::new(),
            multipliers: Multipliers::default(),
        }
    }

    /// Assembles the conic program and sets clarabel up; [`Clarabel::run`] and [`Clarabel::finish`]
    /// follow. The steps are apart so that a benchmark can time the solver alone.
    ///
    /// # Errors
    /// [`Status::InvalidInput`] for a number that is not finite, or a size that clarabel refuses.
    pub fn prepare(&mut self, problem: &Problem) -> Result<(), Status> {
        self.inner = None;
        problem.check().map_err(|_| Status::InvalidInput)?;
        let (cost, gradient) = assemble_cost(problem);
        let (constraints, cones, layout) = assemble_constraints(problem, gradient.len());
        let settings = DefaultSettings {
            verbose: false,
            max_iter: 200,
            tol_gap_abs: self.tolerance,
            tol_gap_rel: self.tolerance,
            tol_feas: self.tolerance,
            presolve_enable: false,
            ..DefaultSettings::default()
        };
        let n = gradient.len();
        let p = CscMatrix::new_from_triplets(n, n, cost.i, cost.j, cost.v);
        let m = constraints.rhs.len();
        let a = CscMatrix::new_from_triplets(m, n, constraints.i, constraints.j, constraints.v);
        let solver = DefaultSolver::new(&p, &gradient, &a, &constraints.rhs, &cones, settings);
        self.inner = Some(solver.map_err(|_| Status::InvalidInput)?);
        self.layout = layout;
        Ok(())
    }

    /// Runs clarabel on the prepared program; [`Clarabel::finish`] reads the result.
    pub fn run(&mut self) {
        if let Some(inner) = &mut self.inner {
            inner.solve();
        }
    }

    /// Reads clarabel's solution; `problem` is the one that was prepared.
    pub fn finish(&mut self, problem: &Problem) -> Report {
        let Some(inner) = &self.inner else { return self.refuse(problem) };
        let (n, solution) = (problem.horizon, &inner.solution);
        self.inputs.clear();
        for k in 0..n {
            let u = solution.x[input(k)];
            let u = if u.is_finite() { u } else { 0.0 };
            self.inputs.push(u.clamp(problem.u_min, problem.u_max));
        }
        self.states.resize(n + 1, [0.0; 3]);
        problem.roll_out(&self.inputs, &mut self.states);
        self.multipliers = Multipliers::new(n);
        if let Some(first) = self.layout.terminal {
            self.multipliers.terminal = std::array::from_fn(|i| solution.z[first + i]);
        }
        for (out, row) in self.multipliers.rows.iter_mut().zip(&self.layout.rows) {
            for &(k, at) in row {
                out[k] = solution.z[at];
            }
        }
        for k in 1..=problem.light_len {
            self.multipliers.light[k] = solution.z[self.layout.light + k - 1];
        }
        Report {
            status: match solution.status {
                SolverStatus::Solved => Status::Solved,
                SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                    Status::Infeasible
                }
                _ => Status::IterationLimit,
            },
            iterations: solution.iterations,
            interior_iterations: solution.iterations,
            residuals: residuals(problem, &self.inputs, &self.states, &self.multipliers),
        }
    }

    fn refuse(&mut self, problem: &Problem) -> Report {
        let n = problem.horizon;
        self.inputs.clear();
        self.inputs.resize(n, 0.0_f64.clamp(problem.u_min, problem.u_max));
        self.states.clear();
        self.states.resize(n + 1, problem.x0);
        self.multipliers = Multipliers::new(n);
        let nan = Residuals { stationarity: f64::NAN, ..Residuals::default() };
        let status = Status::InvalidInput;
        Report { status, iterations: 0, interior_iterations: 0, residuals: nan }
    }
}

impl Solver for Clarabel {
    fn solve(&mut self, problem: &Problem, _start: Start) -> Report {
        match self.prepare(problem) {
            Ok(()) => {
                self.run();
                self.finish(problem)
            }
            Err(_) => self.refuse(problem),
        }
    }

    fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    fn states(&self) -> &[[f64; 3]] {
        &self.states
    }

    fn multipliers(&self) -> &Multipliers {
        &self.multipliers
    }
}

/// Index of `u_k`.
fn input(k: usize) -> usize {
    4 * k
}

/// Index of the first component of `x_k`, `k ≥ 1`.
fn state(k: usize) -> usize {
    4 * k - 3
}

/// Stages at which row `j` has a finite limit.
fn stages(problem: &Problem, j: usize) -> impl Iterator<Item = usize> + '_ {
    let row = problem.rows[j];
    (row.from..=row.to).filter(move |&k| problem.limits[j][k] < f64::INFINITY)
}

/// Upper triangle of the quadratic cost, and the linear cost of all variables.
fn assemble_cost(problem: &Problem) -> (Triplets, Vec<f64>) {
    let n = problem.horizon;
    let mut cost = Triplets::default();
    let mut gradient = vec![0.0; 4 * n];
    let mut entry = |i: usize, j: usize, v: f64| {
        if v != 0.0 {
            cost.i.push(i.min(j));
            cost.j.push(i.max(j));
            cost.v.push(v);
        }
    };
    for k in 0..n {
        entry(input(k), input(k), problem.r);
        gradient[input(k)] = problem.r_lin[k];
        if k == 0 {
            gradient[input(0)] += crate::problem::dot(&problem.s, &problem.x0);
        }
    }
    for k in 1..=n {
        let weight = if k < n { &problem.q } else { &problem.p };
        let linear = if k < n { &problem.q_lin[k] } else { &problem.p_lin };
        for i in 0..3 {
            for j in i..3 {
                entry(state(k) + i, state(k) + j, weight[i][j]);
            }
            if k < n {
                entry(state(k) + i, input(k), problem.s[i]);
            }
            gradient[state(k) + i] = linear[i];
        }
    }
    for (j, row) in problem.rows.iter().enumerate() {
        if let Softness::Soft { linear, quadratic } = row.softness {
            for _ in stages(problem, j) {
                entry(gradient.len(), gradient.len(), quadratic);
                gradient.push(linear);
            }
        }
    }
    if let Some(light) = &problem.light {
        for _ in 0..problem.light_len {
            gradient.extend([0.0, light.weight / (CONE_SCALE * CONE_SCALE)]);
            if let Softness::Soft { linear, .. } = light.softness {
                gradient.push(linear);
            }
        }
    }
    (cost, gradient)
}

fn assemble_constraints(
    problem: &Problem,
    variables: usize,
) -> (Triplets, Vec<SupportedConeT<f64>>, Layout) {
    let n = problem.horizon;
    let mut a = Triplets::default();
    let mut layout = Layout::default();
    let mut cones = Vec::new();
    for k in 0..n {
        let constant = if k == 0 { problem.step(0, &problem.x0, 0.0) } else { problem.d[k] };
        for (i, value) in constant.into_iter().enumerate() {
            let mut entries = vec![(state(k + 1) + i, 1.0), (input(k), -problem.b[i])];
            if k > 0 {
                entries.extend((i..3).map(|j| (state(k) + j, -problem.a[i][j])));
            }
            a.constrain(&entries, value);
        }
    }
    if let Terminal::Equality(x_f) = &problem.terminal {
        layout.terminal = Some(a.rhs.len());
        for (i, value) in x_f.iter().enumerate() {
            a.constrain(&[(state(n) + i, 1.0)], *value);
        }
    }
    cones.push(SupportedConeT::ZeroConeT(a.rhs.len()));
    let first = a.rhs.len();
    for k in 0..n {
        a.constrain(&[(input(k), 1.0)], problem.u_max);
        a.constrain(&[(input(k), -1.0)], -problem.u_min);
    }
    let mut slack = 4 * n;
    for (j, row) in problem.rows.iter().enumerate() {
        for k in stages(problem, j) {
            let mut entries = Vec::from([0, 1, 2].map(|i| (state(k) + i, row.gradient[i])));
            if row.softness != Softness::Hard {
                entries.push((slack, -1.0));
            }
            layout.rows[j].push((k, a.constrain(&entries, problem.limits[j][k])));
            if row.softness != Softness::Hard {
                a.constrain(&[(slack, -1.0)], 0.0);
                slack += 1;
            }
        }
    }
    layout.light = a.rhs.len();
    let soft = problem.light.is_some_and(|light| light.softness != Softness::Hard);
    // `p`, `t` and, if the light is soft, `σ` of each stage.
    let width = if soft { 3 } else { 2 };
    let stage_slacks = (slack..).step_by(width).take(problem.light_len);
    for ((k, stage), p) in (1..).zip(problem.light_stages()).zip(stage_slacks.clone()) {
        let mut entries = Vec::from([0, 1, 2].map(|i| (state(k) + i, -stage.gradient[i])));
        entries.extend([(p, 1.0), (p + 2, if soft { -1.0 } else { 0.0 })]);
        a.constrain(&entries, stage.offset);
    }
    for p in stage_slacks.clone() {
        if let Some(light) = problem.light.filter(|light| light.threshold < f64::INFINITY) {
            a.constrain(&[(p, 1.0)], light.threshold);
        }
        if soft {
            a.constrain(&[(p + 2, -1.0)], 0.0);
        }
    }
    cones.push(SupportedConeT::NonnegativeConeT(a.rhs.len() - first));
    for p in stage_slacks {
        a.constrain(&[(p + 1, -1.0), (p, -1.0)], 0.0);
        a.constrain(&[(p + 1, -1.0), (p, 1.0)], 0.0);
        a.constrain(&[], 2.0 * CONE_SCALE);
        cones.push(SupportedConeT::SecondOrderConeT(3));
    }
    slack += width * problem.light_len;
    debug_assert_eq!(slack, variables, "cost and constraints number the slacks alike");
    (a, cones, layout)
}
