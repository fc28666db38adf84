//! The semidefinite program of one alpha: its rows, its solution, the gains.

use super::{Options, TrialFailure};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, PSDTriangleConeT,
    SolverStatus, SupportedConeT,
};
use controller::laws::quadratic_bounded::{
    Content, DISTURBANCES, Design, DesignError, DisturbanceMatrix, Parameters, RULES, RuleContent,
    STATES, State, StateMatrix,
};
use nalgebra::{DMatrix, SMatrix};
// Linked for clarabel's cone, not called.
use openblas_src as _;

/// Unknowns in a symmetric matrix over the states.
const SYMMETRIC: usize = STATES * (STATES + 1) / 2;
const SQUARE: usize = STATES * STATES;

/// The unknowns as matrices, scaled.
pub(super) struct Unknowns {
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
pub(super) struct Problem<'a> {
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
    pub(super) fn new(parameters: &'a Parameters, options: &'a Options, alpha: f64) -> Self {
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
    pub(super) fn solve(&self) -> (Result<(Unknowns, f64), TrialFailure>, u32) {
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
            Err(e) => return (Err(TrialFailure::Unsolved(e.to_string())), 0),
        };
        solver.solve();
        let iterations = solver.info.iterations;
        let found = match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ok((
                Unknowns::from_slice(&solver.solution.x, rule_outputs),
                solver.solution.obj_val,
            )),
            status => Err(TrialFailure::Unsolved(format!("{status:?}"))),
        };
        (found, iterations)
    }

    fn objective(&self, u: &Unknowns) -> f64 {
        let widths: f64 = u.x.diagonal().iter().zip(self.options.weights).map(|(v, w)| v * w).sum();
        widths + 1e-3 * u.y.trace()
    }

    /// Gains and P from the unknowns, back in physical units, verified.
    pub(super) fn recover(&self, u: &Unknowns) -> Result<Design, DesignError> {
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
