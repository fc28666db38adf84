//! Throws random and hostile problems at the solver for as long as it is told to.
//!
//! ```text
//! cargo run --release -p mpc-solver --example fuzz -- SECONDS [SEED]
//! ```
//!
//! What must hold for every problem, checked here and not by the solver: the inputs are finite and
//! within their bounds, the iterations bounded; `Solved` means that the optimality conditions,
//! evaluated anew, hold to 1e-8; what does not pass [`Problem::check`] is `InvalidInput` and nothing
//! else is; the same problem gives the same bits. A problem that can be satisfied by construction
//! and is called infeasible is counted as wrong. The first violation ends the program with status 1.

#[path = "../tests/common/random.rs"]
mod random;

use mpc_solver::{LightStage, Problem, Report, Riccati, Solver, Start, Status, residuals};
use random::Draw;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Iterations that no solve may exceed.
const MOST_ITERATIONS: u32 = 500;

const HOSTILE: [f64; 14] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    1e300,
    -1e150,
    1e18,
    -1e12,
    1e-30,
    1e7,
];

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(seconds) = arguments.next().and_then(|s| s.parse().ok()) else {
        eprintln!("expected the number of seconds to run for, and optionally a seed");
        return ExitCode::from(2);
    };
    let seed = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(1);
    let until = Instant::now() + Duration::from_secs(seconds);
    let mut draw = Draw::new(seed);
    let mut solver = Riccati::new(200);
    let mut count = Count::default();
    while Instant::now() < until {
        let mut problem = random::problem(&mut draw);
        let sane = draw.chance(0.6);
        if !sane {
            corrupt(&mut draw, &mut problem);
        }
        for start in [Start::Cold, Start::Shifted(draw.below(3))] {
            let report = solver.solve(&problem, start);
            if let Err(what) = check(&problem, &solver, &report, sane) {
                eprintln!("seed {seed}, problem {}: {what}\n{report:?}\n{problem:?}", count.problems);
                return ExitCode::FAILURE;
            }
            count.add(&report);
        }
        if count.problems % 64 == 0
            && let Err(what) = repeats(&problem)
        {
            eprintln!("seed {seed}, problem {}: {what}\n{problem:?}", count.problems);
            return ExitCode::FAILURE;
        }
        count.problems += 1;
    }
    println!("{count:?}, nothing violated");
    ExitCode::SUCCESS
}

#[derive(Debug, Default)]
struct Count {
    problems: u64,
    solved: u64,
    iteration_limit: u64,
    infeasible: u64,
    invalid_input: u64,
    most_iterations: u32,
}

impl Count {
    fn add(&mut self, report: &Report) {
        match report.status {
            Status::Solved => self.solved += 1,
            Status::IterationLimit => self.iteration_limit += 1,
            Status::Infeasible => self.infeasible += 1,
            Status::InvalidInput => self.invalid_input += 1,
        }
        self.most_iterations = self.most_iterations.max(report.iterations);
    }
}

/// Overwrites some numbers of a problem.
fn corrupt(draw: &mut Draw, problem: &mut Problem) {
    for _ in 0..1 + draw.below(3) {
        let value = HOSTILE[draw.below(HOSTILE.len())];
        let stage = draw.below(problem.horizon());
        let part = draw.below(3);
        match draw.below(6) {
            0 => {
                let mut x0 = problem.initial_state();
                x0[part] = value;
                problem.set_initial_state(x0);
            }
            1 => problem.disturbances_mut()[stage][part] = value,
            2 => problem.state_gradients_mut()[stage][part] = value,
            3 => problem.input_gradients_mut()[stage] = value,
            4 if !problem.rows().is_empty() => {
                let row = draw.below(problem.rows().len());
                problem.row_limits_mut(row)[stage] = value;
            }
            _ => {
                let mut stages: Vec<LightStage> = problem.light_stages().to_vec();
                if let Some(place) = stages.get_mut(stage) {
                    place.offset = value;
                    problem.set_light(stages);
                }
            }
        }
    }
}

fn check(problem: &Problem, solver: &Riccati, report: &Report, sane: bool) -> Result<(), String> {
    let (low, high) = problem.input_bounds();
    if solver.inputs().len() != problem.horizon() {
        return Err(format!("{} inputs", solver.inputs().len()));
    }
    if let Some(u) = solver.inputs().iter().find(|u| !(low..=high).contains(*u)) {
        return Err(format!("input {u} is outside of {low} to {high}"));
    }
    if report.iterations > MOST_ITERATIONS {
        return Err(format!("{} iterations", report.iterations));
    }
    if problem.check().is_err() && report.status != Status::InvalidInput {
        return Err("not a problem, and not refused".into());
    }
    if sane && matches!(report.status, Status::Infeasible | Status::InvalidInput) {
        return Err("this problem can be satisfied".into());
    }
    if report.status == Status::Solved {
        let mut states = vec![[0.0; 3]; problem.horizon() + 1];
        problem.roll_out(solver.inputs(), &mut states);
        let found = residuals(problem, solver.inputs(), &states, solver.multipliers()).max();
        // NaN is no solution either.
        if found.is_nan() || found > 1e-8 {
            return Err(format!("called solved with a residual of {found:e}"));
        }
    }
    Ok(())
}

/// Two solvers that never saw anything else agree to the bit.
fn repeats(problem: &Problem) -> Result<(), String> {
    let bits = || {
        let mut solver = Riccati::new(200);
        let report = solver.solve(problem, Start::Cold);
        let inputs: Vec<u64> = solver.inputs().iter().map(|u| u.to_bits()).collect();
        (report.iterations, report.objective.to_bits(), inputs)
    };
    if bits() == bits() { Ok(()) } else { Err("the same problem gave other bits".into()) }
}
