//! Other solvers on the same instances, each as its makers would use it.
//!
//! * clarabel, the general conic solver, on the sparse problem; only its own solve counts, not the assembly of its
//!   matrices.
//! * quadprog (Goldfarb and Idnani's dual active set, in plain Rust), on the condensed problem: inputs only, dense, the
//!   Hessian factored once and for all because it is the same in every instance. It is for quadratic programs, so that it has
//!   no part in the instances with a light.
//!
//! OSQP, PIQP and qpOASES are not here: they are C or C++ and need cmake, which this project does not ask for.

use std::time::Instant;

use mpc_solver::{Clarabel, Multipliers, Problem, Report, Residuals, Status, residuals};

use crate::common::{Instance, cacc};
use crate::summary::Sample;

/// Largest residual that counts as solved, and clarabel's own tolerance.
const TOLERANCE: f64 = 1e-8;
const HORIZON: usize = 100;

/// Samples of every solver that can solve the set.
pub(crate) fn solve(set: &[&Instance], repeats: usize) -> Vec<(&'static str, Vec<Sample>)> {
    let mut field = vec![("clarabel", clarabel(set, repeats))];
    if set.iter().all(|instance| instance.stages == 0) {
        field.push(("quadprog, condensed", condensed(set, repeats)));
    }
    field
}

fn clarabel(set: &[&Instance], repeats: usize) -> Vec<Sample> {
    let mut problem = cacc(HORIZON);
    let mut solver = Clarabel::with_tolerance(TOLERANCE);
    let mut samples = Vec::new();
    for instance in set {
        instance.apply(&mut problem);
        let mut times = Vec::with_capacity(repeats);
        for _ in 0..repeats {
            solver.prepare(&problem).expect("the table holds only finite numbers");
            let begin = Instant::now();
            solver.run();
            times.push(begin.elapsed().as_secs_f64() * 1e6);
        }
        let mut sample = Sample::new(&solver.finish(&problem), "");
        sample.take_median(&mut times);
        samples.push(sample);
    }
    samples
}

fn condensed(set: &[&Instance], repeats: usize) -> Vec<Sample> {
    let mut problem = cacc(HORIZON);
    let program = Condensed::new(&problem);
    let mut samples = Vec::new();
    for instance in set {
        instance.apply(&mut problem);
        let (gradient, limits) = program.at(&problem);
        let mut times = Vec::with_capacity(repeats);
        let mut found = None;
        for _ in 0..repeats {
            let mut factor = program.factor.clone();
            let begin = Instant::now();
            let solution = quadprog::solve_qp(
                &mut factor,
                &gradient,
                &program.constraints,
                &limits,
                EQUALITIES,
                true,
            );
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            found = solution.ok();
        }
        let mut sample = Sample::new(&program.judge(&problem, found), "");
        sample.take_median(&mut times);
        samples.push(sample);
    }
    samples
}

/// `x_N = 0`.
const EQUALITIES: usize = 3;

/// The paper's problem without its light in the inputs alone: states as affine functions of them.
struct Condensed {
    /// `L⁻¹` of the Hessian `L L'`, row by row.
    factor: Vec<f64>,
    /// Rows of the constraints: terminal state `=`, upper and lower bounds and the row's stages `≤`.
    constraints: Vec<f64>,
    /// `response[k][j]`: change of `x_k` by `u_j`.
    response: Vec<Vec<[f64; 3]>>,
}

impl Condensed {
    fn new(problem: &Problem) -> Self {
        let n = HORIZON;
        let mut unit = problem.clone();
        unit.set_initial_state([0.0; 3]);
        let mut states = vec![[0.0; 3]; n + 1];
        let mut response = vec![vec![[0.0; 3]; n]; n + 1];
        for j in 0..n {
            let mut inputs = vec![0.0; n];
            inputs[j] = 1.0;
            unit.roll_out(&inputs, &mut states);
            for k in 0..=n {
                response[k][j] = states[k];
            }
        }
        let mut program = Self { factor: Vec::new(), constraints: Vec::new(), response };
        program.factor = inverse_factor(&program.hessian(&unit), n);
        for i in 0..3 {
            program.constraints.extend((0..n).map(|j| program.response[n][j][i]));
        }
        for sign in [1.0, -1.0] {
            for k in 0..n {
                program.constraints.extend((0..n).map(|j| if j == k { sign } else { 0.0 }));
            }
        }
        let row = &problem.rows()[0];
        for k in row.from..=row.to {
            program.constraints.extend((0..n).map(|j| program.response[k][j][0]));
        }
        program
    }

    /// By polarisation of the objective, which is quadratic: the problem's own function is used, not a copy of its weights.
    fn hessian(&self, unit: &Problem) -> Vec<f64> {
        let n = HORIZON;
        let mut states = vec![[0.0; 3]; n + 1];
        let mut cost = |i: usize, j: usize| {
            let mut inputs = vec![0.0; n];
            inputs[i] += 1.0;
            inputs[j] += 1.0;
            unit.roll_out(&inputs, &mut states);
            unit.objective(&inputs, &states)
        };
        let diagonal: Vec<f64> = (0..n).map(|i| 0.25 * cost(i, i)).collect();
        let mut hessian = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let entry =
                    if i == j { 2.0 * diagonal[i] } else { cost(i, j) - diagonal[i] - diagonal[j] };
                hessian[i * n + j] = entry;
                hessian[j * n + i] = entry;
            }
        }
        hessian
    }

    /// Linear term and right-hand sides of an instance.
    fn at(&self, problem: &Problem) -> (Vec<f64>, Vec<f64>) {
        let n = HORIZON;
        let mut states = vec![[0.0; 3]; n + 1];
        let mut inputs = vec![0.0; n];
        let mut cost = |j: usize, u: f64| {
            inputs[j] = u;
            problem.roll_out(&inputs, &mut states);
            let cost = problem.objective(&inputs, &states);
            inputs[j] = 0.0;
            cost
        };
        // The slope of a quadratic function from two of its points.
        let gradient = (0..n).map(|j| 0.5 * (cost(j, 1.0) - cost(j, -1.0))).collect();
        problem.roll_out(&inputs, &mut states);
        let (lo, hi) = problem.input_bounds();
        let mut limits: Vec<f64> = states[n].iter().map(|x| -x).collect();
        limits.extend(std::iter::repeat_n(hi, n));
        limits.extend(std::iter::repeat_n(-lo, n));
        let row = &problem.rows()[0];
        limits.extend((row.from..=row.to).map(|k| row.limit - states[k][0]));
        (gradient, limits)
    }

    /// The solution as a report, by the judge of all solvers.
    fn judge(&self, problem: &Problem, found: Option<quadprog::Solution>) -> Report {
        let n = HORIZON;
        let mut report = Report {
            status: Status::IterationLimit,
            iterations: 0,
            interior_iterations: 0,
            residuals: Residuals { stationarity: f64::INFINITY, ..Residuals::default() },
            objective: f64::NAN,
        };
        let Some(found) = found else { return report };
        let mut states = vec![[0.0; 3]; n + 1];
        problem.roll_out(&found.sol, &mut states);
        let mut multipliers = Multipliers::new(n);
        let row = &problem.rows()[0];
        multipliers.rows[0][row.from..=row.to].copy_from_slice(&found.lagr[EQUALITIES + 2 * n..]);
        report.iterations = u32::try_from(found.iter).unwrap_or(u32::MAX);
        // quadprog gives the size of an equality's multiplier, not its sign: the best of the eight choices counts.
        for choice in 0..1 << EQUALITIES {
            for i in 0..EQUALITIES {
                let size = found.lagr[i].abs();
                multipliers.terminal[i] = if choice >> i & 1 == 0 { size } else { -size };
            }
            let residuals = residuals(problem, &found.sol, &states, &multipliers);
            if residuals.max() < report.residuals.max() {
                report.residuals = residuals;
            }
        }
        if report.residuals.max() <= TOLERANCE {
            report.status = Status::Solved;
        }
        report
    }
}

/// `L⁻¹` with `L L' = H`, row by row.
fn inverse_factor(h: &[f64], n: usize) -> Vec<f64> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|m| l[i * n + m] * l[j * n + m]).sum();
            let rest = h[i * n + j] - sum;
            l[i * n + j] = if i == j { rest.sqrt() } else { rest / l[j * n + j] };
        }
    }
    let mut inverse = vec![0.0; n * n];
    for j in 0..n {
        for i in j..n {
            let unit = if i == j { 1.0 } else { 0.0 };
            let sum: f64 = (j..i).map(|m| l[i * n + m] * inverse[m * n + j]).sum();
            inverse[i * n + j] = (unit - sum) / l[i * n + i];
        }
    }
    inverse
}
