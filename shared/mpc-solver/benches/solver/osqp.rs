//! OSQP on the drives without the light: operator splitting on the sparse quadratic program, polished at the end.
//!
//! Variables `u_0 … u_{N-1}`, `x_1 … x_N`. Rows of its constraint matrix: the dynamics, `x_N = x_f`, the
//! bounds of the inputs, the buffer. Between two instances only the first three right-hand sides change. So
//! the setup with its factorisation is done once and is not timed.

use std::time::Instant;

use mpc_solver::{Multipliers, Problem, Report, Status, residuals};
use osqp::{CscMatrix, Settings, Solution};

use crate::common::{BUFFER_M, HORIZON, INPUT_WEIGHT, Instance, STATE_WEIGHTS, cacc};
use crate::summary::{Sample, TOLERANCE};

/// Its own tolerance, before the polishing step.
const SPLITTING_TOLERANCE: f64 = 1e-7;
/// More iterations than any instance takes.
const MAX_ITERATIONS: u32 = 100_000;

/// First rows of the groups of constraints.
const END: usize = 3 * HORIZON;
const BOUNDS: usize = END + 3;
const BUFFER: usize = BOUNDS + HORIZON;
const ROWS: usize = BUFFER + HORIZON - 1;

pub(crate) fn solve(set: &[&Instance], repeats: usize) -> Vec<Sample> {
    let mut problem = cacc(HORIZON);
    let (mut lower, mut upper) = limits(&problem);
    let settings = Settings::default()
        .verbose(false)
        .eps_abs(SPLITTING_TOLERANCE)
        .eps_rel(SPLITTING_TOLERANCE)
        .max_iter(MAX_ITERATIONS)
        .warm_start(false)
        .polish(true)
        .polish_refine_iter(10);
    let gradient = vec![0.0; 4 * HORIZON];
    let matrix = constraints(&problem);
    let mut solver = osqp::Problem::new(hessian(), &gradient, matrix, &lower, &upper, &settings)
        .expect("the drives' program is convex");
    let mut samples = Vec::new();
    for instance in set {
        instance.apply(&mut problem);
        let first = problem.step(0, &problem.initial_state(), 0.0);
        lower[..3].copy_from_slice(&first);
        upper[..3].copy_from_slice(&first);
        let mut times = Vec::with_capacity(repeats);
        let mut report = None;
        for _ in 0..repeats {
            let begin = Instant::now();
            solver.update_bounds(&lower, &upper);
            let status = solver.solve();
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            let iterations = status.iter();
            report = Some(judge(&problem, status.solution().as_ref(), iterations));
        }
        let mut sample = Sample::new(&report.expect("there is at least one repeat"), "");
        sample.take_median(&mut times);
        samples.push(sample);
    }
    samples
}

/// Judged by the same residuals as all the others.
fn judge(problem: &Problem, solution: Option<&Solution<'_>>, iterations: u32) -> Report {
    let (lo, hi) = problem.input_bounds();
    let mut inputs = vec![0.0; HORIZON];
    let mut multipliers = Multipliers::new(HORIZON);
    if let Some(solution) = solution {
        for (u, found) in inputs.iter_mut().zip(solution.x()) {
            *u = found.clamp(lo, hi);
        }
        let y = solution.y();
        multipliers.rows[0][1..HORIZON].copy_from_slice(&y[BUFFER..ROWS]);
        multipliers.terminal.copy_from_slice(&y[END..BOUNDS]);
        for mu in &mut multipliers.rows[0] {
            *mu = mu.max(0.0);
        }
    }
    let mut states = vec![[0.0; 3]; HORIZON + 1];
    problem.roll_out(&inputs, &mut states);
    let residuals = residuals(problem, &inputs, &states, &multipliers);
    let is_solved = solution.is_some() && residuals.max() <= TOLERANCE;
    Report {
        status: if is_solved { Status::Solved } else { Status::IterationLimit },
        iterations,
        interior_iterations: 0,
        residuals,
    }
}

/// Column of state `i` at stage `k ≥ 1`.
fn state(k: usize, i: usize) -> usize {
    HORIZON + 3 * (k - 1) + i
}

/// Diagonal; the last state has no cost.
fn hessian() -> CscMatrix<'static> {
    let mut entries: Vec<(usize, usize, f64)> =
        (0..HORIZON).map(|k| (k, k, INPUT_WEIGHT)).collect();
    for k in 1..HORIZON {
        entries.extend((0..3).map(|i| (state(k, i), state(k, i), STATE_WEIGHTS[i])));
    }
    sparse(4 * HORIZON, entries)
}

fn constraints(problem: &Problem) -> CscMatrix<'static> {
    let rest = problem.step(0, &[0.0; 3], 0.0);
    let b = problem.step(0, &[0.0; 3], 1.0);
    let mut entries = Vec::new();
    for k in 0..HORIZON {
        for i in 0..3 {
            entries.push((3 * k + i, state(k + 1, i), 1.0));
            entries.push((3 * k + i, k, rest[i] - b[i]));
        }
        for j in (0..3).filter(|_| k > 0) {
            let mut unit = [0.0; 3];
            unit[j] = 1.0;
            let column = problem.step(0, &unit, 0.0);
            entries.extend((0..3).map(|i| (3 * k + i, state(k, j), rest[i] - column[i])));
        }
        entries.push((BOUNDS + k, k, 1.0));
    }
    entries.extend((0..3).map(|i| (END + i, state(HORIZON, i), 1.0)));
    entries.extend((1..HORIZON).map(|k| (BUFFER + k - 1, state(k, 0), 1.0)));
    sparse(ROWS, entries)
}

/// Limits of all rows; those of the first three depend on the instance.
fn limits(problem: &Problem) -> (Vec<f64>, Vec<f64>) {
    let (lo, hi) = problem.input_bounds();
    let (mut lower, mut upper) = (vec![0.0; ROWS], vec![0.0; ROWS]);
    lower[BOUNDS..BUFFER].fill(lo);
    upper[BOUNDS..BUFFER].fill(hi);
    lower[BUFFER..].fill(f64::NEG_INFINITY);
    upper[BUFFER..].fill(BUFFER_M);
    (lower, upper)
}

/// A matrix of `rows` rows and a column for each variable, without its zeros.
fn sparse(rows: usize, mut entries: Vec<(usize, usize, f64)>) -> CscMatrix<'static> {
    entries.retain(|entry| entry.2 != 0.0);
    entries.sort_unstable_by_key(|&(row, column, _)| (column, row));
    let columns = 4 * HORIZON;
    let ends = (0..=columns).map(|column| entries.partition_point(|entry| entry.1 < column));
    CscMatrix {
        nrows: rows,
        ncols: columns,
        indptr: ends.collect::<Vec<_>>().into(),
        indices: entries.iter().map(|entry| entry.0).collect::<Vec<_>>().into(),
        data: entries.iter().map(|entry| entry.2).collect::<Vec<_>>().into(),
    }
}
