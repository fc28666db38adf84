//! Construction of a [`Problem`]: everything that can be wrong with one is found here.

use std::fmt;

use crate::problem::{
    LightCost, LightStage, MAX_HORIZON, MAX_ROWS, Problem, Row, Softness, Terminal,
};

/// Why a problem could not be built or solved as it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemError {
    /// The horizon is zero or above [`MAX_HORIZON`].
    Horizon(usize),
    /// A number is NaN or infinite; the text says which.
    NotFinite(&'static str),
    /// `A` has an entry below its diagonal.
    NotUpperTriangular,
    /// `B` is zero: the input would have no effect.
    NoInput,
    /// `u_min` is not below `u_max`.
    EmptyInputRange,
    /// `r` is not positive.
    InputCost,
    /// A cost matrix is not symmetric; the text says which.
    NotSymmetric(&'static str),
    /// A cost matrix is not positive semidefinite; the text says which.
    NotConvex(&'static str),
    /// There are more than [`MAX_ROWS`] rows.
    TooManyRows(usize),
    /// A row names stages outside of `1..=N`; the number is the row's.
    RowStages(usize),
    /// A row's gradient is zero; the number is the row's.
    EmptyRow(usize),
    /// A soft limit's linear price is not positive, or its quadratic one is negative.
    Price,
    /// The light's weight or threshold is not positive.
    Light,
}

impl fmt::Display for ProblemError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Horizon(n) => {
                write!(f, "the horizon is {n} steps; it must be 1 to {MAX_HORIZON}")
            }
            Self::NotFinite(what) => write!(f, "a number is not finite: {what}"),
            Self::NotUpperTriangular => {
                write!(f, "the dynamics matrix has an entry below its diagonal")
            }
            Self::NoInput => write!(f, "the input has no effect on the state"),
            Self::EmptyInputRange => write!(f, "the lower input bound is not below the upper one"),
            Self::InputCost => write!(f, "the cost of the input must be positive"),
            Self::NotSymmetric(what) => write!(f, "the {what} is not symmetric"),
            Self::NotConvex(what) => write!(f, "the {what} is not positive semidefinite"),
            Self::TooManyRows(n) => {
                write!(f, "there are {n} rows; at most {MAX_ROWS} are possible")
            }
            Self::RowStages(j) => write!(f, "row {j} names stages outside of the horizon"),
            Self::EmptyRow(j) => write!(f, "row {j} has a zero gradient"),
            Self::Price => {
                write!(f, "a soft limit needs a positive linear and a non-negative quadratic price")
            }
            Self::Light => write!(f, "the light's weight and threshold must be positive"),
        }
    }
}

impl std::error::Error for ProblemError {}

/// Builder of a [`Problem`]; see there and at the head of the crate.
#[derive(Clone, Debug)]
pub struct ProblemBuilder {
    problem: Problem,
}

impl ProblemBuilder {
    pub(crate) fn new(horizon: usize) -> Self {
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
        };
        Self { problem }
    }

    /// `A` (upper triangular, row by row) and `B`.
    pub fn dynamics(mut self, a: [[f64; 3]; 3], b: [f64; 3]) -> Self {
        self.problem.a = a;
        self.problem.b = b;
        self
    }

    /// `u_min` and `u_max`.
    pub fn input_bounds(mut self, u_min: f64, u_max: f64) -> Self {
        self.problem.u_min = u_min;
        self.problem.u_max = u_max;
        self
    }

    /// `r`.
    pub fn input_cost(mut self, r: f64) -> Self {
        self.problem.r = r;
        self
    }

    /// `Q`, symmetric positive semidefinite.
    pub fn state_cost(mut self, q: [[f64; 3]; 3]) -> Self {
        self.problem.q = q;
        self
    }

    /// `Q` as a diagonal matrix.
    pub fn state_weights(self, q: [f64; 3]) -> Self {
        self.state_cost([[q[0], 0.0, 0.0], [0.0, q[1], 0.0], [0.0, 0.0, q[2]]])
    }

    /// `s`, the cost of state times input.
    pub fn cross_cost(mut self, s: [f64; 3]) -> Self {
        self.problem.s = s;
        self
    }

    /// Adds the jerk cost `½ weight ((u_k − a_k)/τ)²`, with `a` the third state and `τ` (s) the lag of
    /// the vehicle, to what `Q`, `s` and `r` are so far.
    pub fn jerk_cost(mut self, weight: f64, tau_s: f64) -> Self {
        let c = weight / (tau_s * tau_s);
        self.problem.q[2][2] += c;
        self.problem.s[2] -= c;
        self.problem.r += c;
        self
    }

    /// `P`, symmetric positive semidefinite.
    pub fn terminal_cost(mut self, p: [[f64; 3]; 3]) -> Self {
        self.problem.p = p;
        self
    }

    /// `P` as a diagonal matrix.
    pub fn terminal_weights(self, p: [f64; 3]) -> Self {
        self.terminal_cost([[p[0], 0.0, 0.0], [0.0, p[1], 0.0], [0.0, 0.0, p[2]]])
    }

    /// Demands `x_N = x_f`.
    pub fn terminal_equality(mut self, x_f: [f64; 3]) -> Self {
        self.problem.terminal = Terminal::Equality(x_f);
        self
    }

    /// Adds a row; rows are numbered from 0 in the order of these calls.
    pub fn row(mut self, row: Row) -> Self {
        self.problem.rows.push(row);
        self
    }

    /// Gives the problem a light, switched off until [`Problem::set_light`].
    pub fn light(mut self, light: LightCost) -> Self {
        self.problem.light = Some(light);
        self
    }

    /// `x_0`; zero unless given.
    pub fn initial_state(mut self, x0: [f64; 3]) -> Self {
        self.problem.x0 = x0;
        self
    }

    /// Checks the problem and makes room for its stages.
    ///
    /// # Errors
    /// [`ProblemError`] names the first thing that is wrong.
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
            check_price(&light.softness)?;
            // Written so that NaN fails as well.
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
    if !is_semidefinite(reduced, largest(&problem.q)) {
        return Err(ProblemError::NotConvex("stage cost"));
    }
    if !is_semidefinite(problem.p, largest(&problem.p)) {
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
        check_price(&row.softness)?;
    }
    Ok(())
}

fn check_price(softness: &Softness) -> Result<(), ProblemError> {
    match *softness {
        Softness::Soft { linear, quadratic }
            if !(linear > 0.0
                && linear.is_finite()
                && quadratic >= 0.0
                && quadratic.is_finite()) =>
        {
            Err(ProblemError::Price)
        }
        _ => Ok(()),
    }
}

fn largest(m: &[[f64; 3]; 3]) -> f64 {
    m.iter().flatten().fold(0.0, |top, x| top.max(x.abs()))
}

/// Gaussian elimination with the largest pivot first; `scale` times 1e-12 counts as zero.
fn is_semidefinite(mut m: [[f64; 3]; 3], scale: f64) -> bool {
    let zero = 1e-12 * scale;
    let mut open = [true; 3];
    for _ in 0..3 {
        let candidates = (0..3).filter(|&i| open[i]);
        let Some(pivot) = candidates.max_by(|&i, &j| m[i][i].total_cmp(&m[j][j])) else { break };
        if m[pivot][pivot] <= zero {
            let rest = || (0..3).filter(|&i| open[i]);
            return rest().all(|i| {
                rest()
                    .all(|j| m[i][j].abs() <= zero.max(1e-9 * scale * f64::from(u8::from(i != j))))
            });
        }
        open[pivot] = false;
        for i in 0..3 {
            for j in 0..3 {
                if open[i] && open[j] {
                    m[i][j] -= m[i][pivot] * m[pivot][j] / m[pivot][pivot];
                }
            }
        }
    }
    true
}
