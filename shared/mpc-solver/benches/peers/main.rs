//! This solver beside those that one would take instead: `cargo bench -p mpc-solver --bench peers`.
//!
//! Same problems, same machine, one run. Ours and clarabel run here. DAQP, PIQP and OSQP run in `peers.py` if a Python
//! interpreter has them (`pip install numpy scipy daqp piqp osqp`). `TIMEGAP_PYTHON` names the interpreter. A time is
//! the one of the solve alone, without the setup and the interpreter. Ours is measured around the call; those of the
//! wheels are the solvers' own. DAQP's gets the time of its vectors, measured here: ours begins at the state as well. It
//! is the median of some repeats over all starts in their order; percentiles go over the problems.
//!
//! Ours and DAQP have three rows: cold, closed loop (the guess comes from the start before) and again (from the same
//! start). The first start of a closed loop is cold.
//!
//! All are judged alike. The inputs of a strictly convex problem are unique. So a solver's error is the largest
//! distance of its inputs from the optimum, as a share of their range. The optimum is ours where the conditions of
//! optimality hold to 1e-8, evaluated from the problem alone. Solved means an error of at most 1e-5.
//!
//! HPIPM and qpOASES are not among them: no package of either installs without a compiler and their sources.

#[path = "../../tests/common/mod.rs"]
mod common;
mod problems;
mod python;

use common::{BUFFER_M, STATE_WEIGHTS, instances};
use mpc_solver::{Clarabel, Riccati, Solver, Start};
use problems::Set;
use std::time::Instant;

/// Solves of each problem.
const REPEATS: usize = 11;
/// Error at which a problem counts as solved, as a share of the inputs' range.
const SOLVED: f64 = 1e-5;
/// Largest residual of a reference.
const REFERENCE: f64 = 1e-8;

/// Time and inputs of a solver for each problem of a set; no inputs where it failed.
#[derive(Clone)]
pub(crate) struct Answers {
    pub(crate) solver: String,
    pub(crate) times_us: Vec<f64>,
    pub(crate) inputs: Vec<Vec<f64>>,
}

fn main() {
    // `cargo test --benches` runs this too: one repeat shows that it works.
    let is_brief = !std::env::args().any(|argument| argument == "--bench");
    let repeats = if is_brief { 1 } else { REPEATS };
    let acc = instances().into_iter().filter(|instance| instance.feasible && instance.stages == 0);
    let acc = problems::drives(acc.map(|i| i.x0).collect(), STATE_WEIGHTS, BUFFER_M);
    let sets: Vec<Set> = [vec![acc], problems::public()].concat();
    let (mut foreign, notes) =
        if is_brief { Default::default() } else { python::solve(&sets, repeats) };
    println!(
        "solve time, us; error: largest distance of an input from the optimum, share of its range"
    );
    for (index, set) in sets.iter().enumerate() {
        println!("\n{}: N = {}, {} problems", set.name, set.horizon, set.starts.len());
        println!(
            "{:<26} {:>9} {:>9} {:>9} {:>8} {:>10}",
            "", "p50", "p99", "max", "solved", "error"
        );
        let (cold, residual) = ours(set, repeats, Start::Cold);
        let reference = cold.inputs.clone();
        let warm = [Start::Shifted(1), Start::Shifted(0)].map(|start| ours(set, repeats, start).0);
        let mut all = [vec![cold], warm.into(), vec![clarabel(set, repeats)]].concat();
        let mut others = foreign.get_mut(index).map(std::mem::take).unwrap_or_default();
        let vectors_us = vectors_us(set);
        for answers in others.iter_mut().filter(|answers| answers.solver.starts_with("DAQP")) {
            answers.times_us.iter_mut().for_each(|time| *time += vectors_us);
        }
        all.append(&mut others);
        let best = all.iter().map(|answers| quantile(&answers.times_us, 0.5));
        let best = best.fold(f64::INFINITY, f64::min);
        let width = set.problem().input_bounds();
        let width = width.1 - width.0;
        for answers in &all {
            line(answers, &reference, width, best);
        }
        if residual > REFERENCE {
            println!(
                "the reference has a residual of {residual:.0e}: the errors are relative to it"
            );
        }
    }
    notes.iter().for_each(|note| println!("\n{note}"));
}

fn line(answers: &Answers, reference: &[Vec<f64>], width: f64, best_us: f64) {
    let error = |(found, optimum): (&Vec<f64>, &Vec<f64>)| {
        let distance = |(a, b): (&f64, &f64)| (a - b).abs() / width;
        let is_whole = found.len() == optimum.len() && found.iter().all(|u| u.is_finite());
        let most = found.iter().zip(optimum).map(distance).fold(0.0, f64::max);
        if is_whole { most } else { f64::INFINITY }
    };
    let errors: Vec<f64> = answers.inputs.iter().zip(reference).map(error).collect();
    let solved = errors.iter().filter(|error| **error <= SOLVED).count();
    let worst = errors.iter().filter(|error| error.is_finite()).fold(0.0, |a: f64, b| a.max(*b));
    let [p50, p99, max] = [0.5, 0.99, 1.0].map(|share| quantile(&answers.times_us, share));
    let mark = if p50 <= best_us { "  fastest p50" } else { "" };
    println!(
        "{:<26} {p50:>9.2} {p99:>9.2} {max:>9.2} {:>8} {worst:>10.0e}{mark}",
        answers.solver,
        format!("{solved}/{}", errors.len()),
    );
}

/// The value at a share of the sorted values, of which the upper of two counts.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(index.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(f64::NAN)
}

fn ours(set: &Set, repeats: usize, start: Start) -> (Answers, f64) {
    let (mut problem, mut solver) = (set.problem(), Riccati::new(set.horizon));
    let mut times = vec![Vec::with_capacity(repeats); set.starts.len()];
    let (mut inputs, mut worst) = (Vec::new(), 0.0_f64);
    for _ in 0..repeats {
        inputs.clear();
        for (index, (x0, times)) in set.starts.iter().zip(&mut times).enumerate() {
            problem.set_initial_state(*x0);
            if start == Start::Shifted(0) {
                solver.solve(&problem, Start::Cold);
            }
            let is_first = index == 0 && start == Start::Shifted(1);
            let begin = Instant::now();
            let report = solver.solve(&problem, if is_first { Start::Cold } else { start });
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            worst = worst.max(report.residuals.max());
            inputs.push(solver.inputs().to_vec());
        }
    }
    let name = match start {
        Start::Cold => "ours, cold",
        Start::Shifted(1) => "ours, closed loop",
        Start::Shifted(_) => "ours, again",
    };
    (Answers::new(name, times, inputs), worst)
}

/// Time of the vectors that a condensed problem needs for a start: gradient, and bounds of inputs and rows, us.
fn vectors_us(set: &Set) -> f64 {
    let problem = set.problem();
    let rows: usize = problem.rows().iter().map(|row| row.to + 1 - row.from).sum();
    let matrix = vec![[0.5, 0.25, 0.125]; set.horizon + rows];
    let (constant, mut vectors) = (vec![1.0; matrix.len()], vec![0.0; matrix.len()]);
    let mut times = Vec::new();
    for x in &set.starts {
        let begin = Instant::now();
        for ((slot, row), constant) in vectors.iter_mut().zip(&matrix).zip(&constant) {
            *slot = constant - (row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
        }
        std::hint::black_box(&mut vectors);
        times.push(begin.elapsed().as_secs_f64() * 1e6);
    }
    quantile(&times, 0.5)
}

fn clarabel(set: &Set, repeats: usize) -> Answers {
    let (mut problem, mut solver) = (set.problem(), Clarabel::new());
    let (mut times, mut inputs) = (Vec::new(), Vec::new());
    for x0 in &set.starts {
        problem.set_initial_state(*x0);
        let mut of_one = Vec::new();
        for _ in 0..repeats {
            solver.prepare(&problem).expect("the sets hold only finite numbers");
            let begin = Instant::now();
            solver.run();
            of_one.push(begin.elapsed().as_secs_f64() * 1e6);
        }
        times.push(of_one);
        solver.finish(&problem);
        inputs.push(solver.inputs().to_vec());
    }
    Answers::new("clarabel (Rust)", times, inputs)
}

impl Answers {
    /// The median of each problem's times counts.
    fn new(solver: &str, times: Vec<Vec<f64>>, inputs: Vec<Vec<f64>>) -> Self {
        let times_us = times.iter().map(|times| quantile(times, 0.5)).collect();
        Self { solver: solver.into(), times_us, inputs }
    }
}
