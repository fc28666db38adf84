//! From parameters to a certified design, by semidefinite programming (feature `synthesize`).
//!
//! Unknown are X, Y (symmetric, 4 by 4), per rule Ah_i, Bh_i, Ch_i, Dh_i, and multipliers a, b >= 0;
//! alpha and beta are fixed in each solve. With Theta = [[X, I], [I, Y]] > 0 and everything scaled by
//! its bound,
//!
//! ```text
//! minimise  sum weight_j X_jj + 1e-3 tr Y  subject to, for each rule i,
//! 1. [[(1 - alpha) Theta, 0, M_i'], [0, diag(a), G_i'], [M_i, G_i, Theta]] >= 0,  sum a <= alpha,
//!    M_i = [[A_i X + B Ch_i, A_i + B Dh_i C], [Ah_i, Y A_i + Bh_i C]],
//!    G_i = [[E + B Dh_i D], [Y E + Bh_i D]]
//! 2. z X z' <= 1 for every state and for both rows of the gap error rate
//! 3. [[(1 - beta) Theta, 0, c_i'], [0, diag(b), (Dh_i D)'], [c_i, Dh_i D, 1]] >= 0,  sum b <= beta,
//!    c_i = [Ch_i, Dh_i C]
//! 4. [[1, x0'], [x0, X]] >= 0 for every start state.
//! ```
//!
//! The gains follow from a factorisation U N' = I - X Y. What comes out is not trusted: the design
//! passes the same verification as one that is read from a file.
//!
//! Alpha enters the problem nonlinearly, so it is found by a line search on the objective.

use super::design::{Content, Design, DesignError, RuleContent};
use super::model::{
    DISTURBANCES, DisturbanceMatrix, ParameterError, Parameters, RULES, STATES, State, StateMatrix,
};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, PSDTriangleConeT,
    SolverStatus, SupportedConeT,
};
use nalgebra::{DMatrix, SMatrix};
use openblas_src as _;
use serde::Deserialize;

/// Unknowns in a symmetric matrix over the states.
const SYMMETRIC: usize = STATES * (STATES + 1) / 2;
const SQUARE: usize = STATES * STATES;

/// How to search.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Least alpha tried.
    pub least_alpha: f64,
    /// Greatest alpha tried.
    pub greatest_alpha: f64,
    /// Number of alphas tried, equally spaced in the logarithm.
    pub alphas: usize,
    /// beta of the condition on the increment.
    pub beta: f64,
    /// Least eigenvalue asked of Theta and of condition 1, and what is kept free of every scaled
    /// bound, so that rounding cannot spoil the certificate.
    pub margin: f64,
    /// Weights of the four states' ellipsoid widths in the objective.
    pub weights: [f64; STATES],
    /// Whether Fx and Fy may differ between the rules.
    pub rule_outputs: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            least_alpha: 0.01,
            greatest_alpha: 0.03,
            alphas: 5,
            beta: 0.1,
            margin: 1e-6,
            weights: [1.0; STATES],
            rule_outputs: false,
        }
    }
}

impl Options {
    fn validate(&self) -> Result<(), ParameterError> {
        let ranges = [
            ("least_alpha", self.least_alpha, 1e-5, 0.9),
            ("greatest_alpha", self.greatest_alpha, self.least_alpha, 0.9),
            ("alphas", self.alphas as f64, 1.0, 100.0),
            ("beta", self.beta, 1e-3, 0.99),
            ("margin", self.margin, 1e-9, 1e-2),
        ];
        let weights = self.weights.map(|w| ("weights", w, 1e-6, 1e6));
        match ranges.into_iter().chain(weights).find(|(_, v, l, m)| !(*l..=*m).contains(v)) {
            Some((key, value, least, most)) => Err(ParameterError { key, value, least, most }),
            None => Ok(()),
        }
    }

    /// The alphas of the line search, ascending.
    fn grid(&self) -> impl Iterator<Item = f64> {
        let steps = self.alphas.max(2) - 1;
        let ratio = self.greatest_alpha / self.least_alpha;
        let (most, steps) = (self.greatest_alpha, steps as f64);
        (0..self.alphas).map(move |k| most * libm::pow(ratio, k as f64 / steps - 1.0)).map({
            // A single alpha is the greatest.
            let single = self.alphas == 1;
            move |a| if single { most } else { a }
        })
    }
}

/// A parameter file: `[parameters]` and, optionally, `[search]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignRequest {
    /// What the design is for.
    pub parameters: Parameters,
    /// How to search.
    #[serde(default)]
    pub search: Options,
}

impl DesignRequest {
    /// Reads a parameter file (TOML).
    ///
    /// # Errors
    /// The parser's message, with line and caret.
    pub fn from_toml(text: &str) -> Result<Self, SynthesisError> {
        toml::from_str(text).map_err(|e| SynthesisError::Syntax(e.to_string()))
    }
}

/// One solve of the line search.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// alpha of this solve.
    pub alpha: f64,
    /// Objective of the certified design, or why there is none.
    pub outcome: Result<f64, String>,
    /// Iterations of the solver.
    pub iterations: u32,
}

/// A certified design and how it was found.
#[derive(Clone, Debug)]
pub struct Synthesis {
    /// The design with the smallest objective.
    pub design: Design,
    /// All solves, in order of alpha.
    pub trials: Vec<Trial>,
}

/// Why there is no design.
#[derive(Clone, Debug, PartialEq)]
pub enum SynthesisError {
    /// The parameter file cannot be read.
    Syntax(String),
    /// A parameter or an option outside its range.
    Parameter(ParameterError),
    /// No alpha gave a design that passes its verification.
    Infeasible(Vec<Trial>),
}

impl std::fmt::Display for SynthesisError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Syntax(what) => write!(f, "not a parameter file: {what}"),
            Self::Parameter(e) => e.fmt(f),
            Self::Infeasible(trials) => {
                write!(f, "no design meets these bounds; tried")?;
                for t in trials {
                    let why = t.outcome.as_ref().err().map_or("", String::as_str);
                    write!(f, "\n  alpha {:.5}: {why}", t.alpha)?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for SynthesisError {}

/// Finds the design with the smallest objective over the line search on alpha.
///
/// # Errors
/// A bad parameter, or what each alpha failed with.
pub fn synthesize(request: &DesignRequest) -> Result<Synthesis, SynthesisError> {
    request.parameters.validate().map_err(SynthesisError::Parameter)?;
    request.search.validate().map_err(SynthesisError::Parameter)?;
    let mut trials = Vec::new();
    let mut best: Option<(f64, Design)> = None;
    for alpha in request.search.grid() {
        let problem = Problem::new(&request.parameters, &request.search, alpha);
        let (solution, iterations) = problem.solve();
        let outcome = solution.and_then(|(unknowns, objective)| {
            let design = problem.recover(&unknowns).map_err(|e| e.to_string())?;
            Ok((objective, design))
        });
        trials.push(Trial {
            alpha,
            outcome: outcome.as_ref().map(|o| o.0).map_err(Clone::clone),
            iterations,
        });
        if let Ok((objective, design)) = outcome
            && best.as_ref().is_none_or(|b| objective < b.0)
        {
            best = Some((objective, design));
        }
    }
    match best {
        Some((_, design)) => Ok(Synthesis { design, trials }),
        None => Err(SynthesisError::Infeasible(trials)),
    }
}

/// The unknowns as matrices, scaled.
struct Unknowns {
    x: StateMatrix,
    y: StateMatrix,
    ah: [StateMatrix; RULES],
    bh: [StateMatrix; RULES],
    ch: [State; RULES],
    dh: [State; RULES],
    a: [f64; DISTURBANCES],
    b: [f64; DISTURBANCES],
}

impl Unknowns {
    fn count(rule_outputs: bool) -> usize {
        let outputs = if rule_outputs { RULES } else { 1 };
        2 * SYMMETRIC + 2 * RULES * SQUARE + 2 * outputs * STATES + 2 * DISTURBANCES
    }

    fn from_slice(values: &[f64], rule_outputs: bool) -> Self {
        let mut rest = values;
        let mut take = |n: usize| {
            let (head, tail) = rest.split_at(n);
            rest = tail;
            head
        };
        let symmetric = |v: &[f64]| {
            StateMatrix::from_fn(|i, j| {
                let (low, high) = (i.min(j), i.max(j));
                v[high * (high + 1) / 2 + low]
            })
        };
        let x = symmetric(take(SYMMETRIC));
        let y = symmetric(take(SYMMETRIC));
        let ah = [0; RULES].map(|_| StateMatrix::from_column_slice(take(SQUARE)));
        let bh = [0; RULES].map(|_| StateMatrix::from_column_slice(take(SQUARE)));
        let mut rows = || {
            let first = State::from_column_slice(take(STATES));
            [first, if rule_outputs { State::from_column_slice(take(STATES)) } else { first }]
        };
        let (ch, dh) = (rows(), rows());
        let mut multipliers = || {
            let head = take(DISTURBANCES);
            std::array::from_fn(|i| head[i])
        };
        let (a, b) = (multipliers(), multipliers());
        Self { x, y, ah, bh, ch, dh, a, b }
    }
}

/// The semidefinite program of one alpha, scaled by the bounds.
struct Problem<'a> {
    parameters: &'a Parameters,
    options: &'a Options,
    alpha: f64,
    /// Diagonal of the scaling S of the states.
    scale: State,
    a: [StateMatrix; RULES],
    b: State,
    e: DisturbanceMatrix,
    d: DisturbanceMatrix,
}

impl<'a> Problem<'a> {
    fn new(parameters: &'a Parameters, options: &'a Options, alpha: f64) -> Self {
        let scale = State::from(parameters.state_bounds());
        let s = StateMatrix::from_diagonal(&scale);
        let s_inverse = StateMatrix::from_diagonal(&scale.map(|v| 1.0 / v));
        let w = SMatrix::<f64, DISTURBANCES, DISTURBANCES>::from_diagonal(
            &parameters.disturbance_bounds().into(),
        );
        Self {
            parameters,
            options,
            alpha,
            scale,
            a: parameters.rule_derivatives_s().map(|r| s_inverse * parameters.transition(r) * s),
            b: s_inverse * parameters.input() * parameters.increment_bound_mps2,
            e: s_inverse * parameters.disturbance() * w,
            d: s_inverse * parameters.measurement_noise() * w,
        }
    }

    /// The matrices that must be positive semidefinite, affine in the unknowns.
    fn matrices(&self, u: &Unknowns) -> Vec<DMatrix<f64>> {
        let identity = StateMatrix::identity();
        let theta = quadrants(&u.x, &identity, &identity, &u.y);
        let margin = |m: DMatrix<f64>| {
            let size = m.nrows();
            m - DMatrix::identity(size, size) * self.options.margin
        };
        let mut all = vec![margin(dense(&theta))];
        let n = 2 * STATES;
        for i in 0..RULES {
            let (ch, dh) = (u.ch[i].transpose(), u.dh[i].transpose());
            let m = quadrants(
                &(self.a[i] * u.x + self.b * ch),
                &(self.a[i] + self.b * dh),
                &u.ah[i],
                &(u.y * self.a[i] + u.bh[i]),
            );
            let upper = self.e + self.b * (dh * self.d);
            let lower = u.y * self.e + u.bh[i] * self.d;
            let mut l = DMatrix::zeros(2 * n + DISTURBANCES, 2 * n + DISTURBANCES);
            l.view_mut((0, 0), (n, n)).copy_from(&((1.0 - self.alpha) * theta));
            for (j, a) in u.a.iter().enumerate() {
                l[(n + j, n + j)] = *a;
            }
            let (row, middle) = (n + DISTURBANCES, n);
            l.view_mut((row, 0), (n, n)).copy_from(&m);
            l.view_mut((0, row), (n, n)).copy_from(&m.transpose());
            for (offset, g) in [(0, upper), (STATES, lower)] {
                l.view_mut((row + offset, middle), (STATES, DISTURBANCES)).copy_from(&g);
                l.view_mut((middle, row + offset), (DISTURBANCES, STATES))
                    .copy_from(&g.transpose());
            }
            l.view_mut((row, row), (n, n)).copy_from(&theta);
            all.push(margin(l));
        }
        for i in 0..if self.options.rule_outputs { RULES } else { 1 } {
            let size = n + DISTURBANCES + 1;
            let mut l = DMatrix::zeros(size, size);
            l.view_mut((0, 0), (n, n)).copy_from(&((1.0 - self.options.beta) * theta));
            for (j, b) in u.b.iter().enumerate() {
                l[(n + j, n + j)] = *b;
            }
            let noise = u.dh[i].transpose() * self.d;
            let last = u.ch[i].iter().chain(u.dh[i].iter()).chain(noise.iter());
            for (j, value) in last.enumerate() {
                l[(size - 1, j)] = *value;
                l[(j, size - 1)] = *value;
            }
            l[(size - 1, size - 1)] = 1.0 - self.options.margin;
            all.push(l);
        }
        for start in &self.parameters.start_set {
            let x0 = State::from(*start).component_div(&self.scale);
            let mut l = DMatrix::zeros(STATES + 1, STATES + 1);
            l[(0, 0)] = 1.0 - self.options.margin;
            l.view_mut((1, 0), (STATES, 1)).copy_from(&x0);
            l.view_mut((0, 1), (1, STATES)).copy_from(&x0.transpose());
            l.view_mut((1, 1), (STATES, STATES)).copy_from(&u.x);
            all.push(l);
        }
        all
    }

    /// The numbers that must not be negative, affine in the unknowns.
    fn scalars(&self, u: &Unknowns) -> Vec<f64> {
        let mut all: Vec<f64> = u.a.iter().chain(&u.b).copied().collect();
        all.push(self.alpha - u.a.iter().sum::<f64>());
        all.push(self.options.beta - u.b.iter().sum::<f64>());
        let one = 1.0 - self.options.margin;
        all.extend(u.x.diagonal().iter().map(|v| one - v));
        for rho in self.parameters.rule_derivatives_s() {
            let z = self.parameters.gap_error_rate_row(rho).component_mul(&self.scale)
                / self.parameters.gap_error_rate_bound_mps;
            all.push(one - (z.transpose() * u.x * z)[(0, 0)]);
        }
        all
    }

    /// All rows of A u + s = b: scalars first, then each matrix as its scaled upper triangle.
    fn rows(&self, u: &Unknowns) -> Vec<f64> {
        let mut rows = self.scalars(u);
        for m in self.matrices(u) {
            for j in 0..m.ncols() {
                rows.extend((0..j).map(|i| m[(i, j)] * std::f64::consts::SQRT_2));
                rows.push(m[(j, j)]);
            }
        }
        rows
    }

    /// Solves; returns unknowns and objective, and the iterations.
    fn solve(&self) -> (Result<(Unknowns, f64), String>, u32) {
        let rule_outputs = self.options.rule_outputs;
        let n = Unknowns::count(rule_outputs);
        let at = |index: Option<usize>| {
            let values: Vec<f64> = (0..n).map(|k| f64::from(u8::from(Some(k) == index))).collect();
            Unknowns::from_slice(&values, rule_outputs)
        };
        // The rows are affine, so their values at the unit vectors are their coefficients.
        let constant = self.rows(&at(None));
        let mut dense = DMatrix::zeros(constant.len(), n);
        let mut objective = vec![0.0; n];
        for k in 0..n {
            let unit = at(Some(k));
            for (i, (value, base)) in self.rows(&unit).iter().zip(&constant).enumerate() {
                dense[(i, k)] = base - value;
            }
            objective[k] = self.objective(&unit);
        }
        let columns: Vec<Vec<f64>> =
            dense.row_iter().map(|r| r.iter().copied().collect()).collect();
        let a = CscMatrix::from(&columns);
        let mut cones: Vec<SupportedConeT<f64>> =
            vec![NonnegativeConeT(self.scalars(&at(None)).len())];
        cones.extend(self.matrices(&at(None)).iter().map(|m| PSDTriangleConeT(m.nrows())));
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .build()
            .expect("the default settings are valid");
        let p = CscMatrix::zeros((n, n));
        let mut solver = match DefaultSolver::new(&p, &objective, &a, &constant, &cones, settings) {
            Ok(solver) => solver,
            Err(e) => return (Err(e.to_string()), 0),
        };
        solver.solve();
        let iterations = solver.info.iterations;
        let found = match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ok((
                Unknowns::from_slice(&solver.solution.x, rule_outputs),
                solver.solution.obj_val,
            )),
            status => Err(format!("{status:?}")),
        };
        (found, iterations)
    }

    fn objective(&self, u: &Unknowns) -> f64 {
        let widths: f64 = u.x.diagonal().iter().zip(self.options.weights).map(|(v, w)| v * w).sum();
        widths + 1e-3 * u.y.trace()
    }

    /// Gains and P from the unknowns, back in physical units, verified.
    fn recover(&self, u: &Unknowns) -> Result<Design, DesignError> {
        let identity = StateMatrix::identity();
        let svd = (identity - u.x * u.y).svd(true, true);
        let root = StateMatrix::from_diagonal(&svd.singular_values.map(f64::sqrt));
        let (left, right) = svd.u.zip(svd.v_t).expect("both were asked for");
        let big_u = left * root;
        let big_n = right.transpose() * root;
        let invert = |m: StateMatrix| m.try_inverse().ok_or(DesignError::Number(f64::NAN));
        let (n_inverse, ut_inverse) = (invert(big_n)?, invert(big_u.transpose())?);

        let s_inverse = StateMatrix::from_diagonal(&self.scale.map(|v| 1.0 / v));
        let increment = self.parameters.increment_bound_mps2;
        let rules = [0, 1].map(|i| {
            let (ch, dh) = (u.ch[i].transpose(), u.dh[i].transpose());
            let fx = (ch - dh * u.x) * ut_inverse;
            let l = n_inverse * (u.bh[i] - u.y * self.b * dh);
            let middle = u.ah[i]
                - u.y * self.a[i] * u.x
                - u.y * self.b * ch
                - (u.bh[i] - u.y * self.b * dh) * u.x;
            RuleContent {
                ac: rows_of(&(n_inverse * middle * ut_inverse)),
                l: rows_of(&(l * s_inverse)),
                fx: (fx * increment).into(),
                fy: (dh * s_inverse * increment).into(),
            }
        });
        let zero = StateMatrix::zeros();
        let pi1 = quadrants(&u.x, &identity, &big_u.transpose(), &zero);
        let pi2 = quadrants(&identity, &u.y, &zero, &big_n.transpose());
        let p = pi2 * pi1.try_inverse().ok_or(DesignError::Number(f64::NAN))?;
        let back = quadrants(&s_inverse, &zero, &zero, &identity);
        let p = back * (p + p.transpose()) * 0.5 * back;
        let sum: f64 = u.a.iter().sum();
        let shrink = (self.alpha / sum).min(1.0) * (1.0 - f64::EPSILON * 8.0);
        Design::verify(Content {
            parameters: self.parameters.clone(),
            alpha: self.alpha,
            multipliers: u.a.map(|a| a * shrink),
            // One triangle decides: the two may differ in the last bit.
            p: std::array::from_fn(|i| std::array::from_fn(|j| p[(i.max(j), i.min(j))])),
            rules,
        })
    }
}

type Closed = SMatrix<f64, { 2 * STATES }, { 2 * STATES }>;

/// [[a, b], [c, d]].
fn quadrants(a: &StateMatrix, b: &StateMatrix, c: &StateMatrix, d: &StateMatrix) -> Closed {
    let mut all = Closed::zeros();
    for (i, j, block) in [(0, 0, a), (0, STATES, b), (STATES, 0, c), (STATES, STATES, d)] {
        all.fixed_view_mut::<STATES, STATES>(i, j).copy_from(block);
    }
    all
}

fn dense(m: &Closed) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

fn rows_of(m: &StateMatrix) -> [[f64; STATES]; STATES] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}
