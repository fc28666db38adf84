//! Deterministic fuzzing of the solver with random problems, some of whose numbers are replaced by
//! hostile ones.
//!
//! ```text
//! cargo run --release -p mpc-solver --example fuzz -- [--seconds 60] [--seed 0]
//! ```
//!
//! `--seconds` counts CPU time where the system provides it. For every problem the solver must not panic and
//! must end within a bounded number of iterations. It must return finite inputs within their bounds. `Solved`
//! requires that the optimality conditions, evaluated here, hold. `Infeasible` must not occur for a problem
//! that is feasible by construction or that the oracle solves. The first violation ends the run with its
//! seed.

#[path = "../tests/common/random.rs"]
mod random;

use std::process::ExitCode;
use std::time::Instant;

use mpc_solver::{
    Clarabel, LightStage, Problem, Report, Riccati, Solver, Start, Status, residuals,
};
use random::Draw;

/// Largest number of iterations of a solve: two attempts at a short horizon, one of the active set, and three starts of
/// the interior point. Each start has 60 iterations and four attempts of five rounds to finish.
const MOST_ITERATIONS: u32 = 2 * 49 + 15 + 3 * (60 + 4 * 5);

#[derive(Default)]
struct Tally {
    problems: u64,
    hostile: u64,
    by_status: [u64; 4],
    most_iterations: u32,
    oracle: u64,
}

fn main() -> ExitCode {
    let (mut seconds, mut seed) = (60.0, 0);
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let value = arguments.next().unwrap_or_default();
        match (name.as_str(), value.parse::<f64>()) {
            ("--seconds", Ok(number)) => seconds = number,
            ("--seed", Ok(number)) => seed = number as u64,
            _ => {
                eprintln!("usage: fuzz [--seconds N] [--seed N]");
                return ExitCode::FAILURE;
            }
        }
    }
    let clock = Clock::start();
    let (mut solver, mut oracle) = (Riccati::new(150), Clarabel::new());
    let mut tally = Tally::default();
    let mut next_line = 0.0;
    while clock.seconds() < seconds {
        for _ in 0..1000 {
            if let Err(why) = one(seed, &mut solver, &mut oracle, &mut tally) {
                println!("VIOLATION at --seed {seed}: {why}");
                return ExitCode::FAILURE;
            }
            seed += 1;
        }
        if clock.seconds() >= next_line {
            line(&clock, seed, &tally);
            next_line = clock.seconds() + 60.0;
        }
    }
    line(&clock, seed, &tally);
    println!("done, no violation");
    ExitCode::SUCCESS
}

fn line(clock: &Clock, seed: u64, tally: &Tally) {
    let [solved, limit, infeasible, invalid] = tally.by_status;
    println!(
        "{:.0} s CPU, next seed {seed}: {} problems, {} of them hostile; solved {solved}, iteration limit \
         {limit}, infeasible {infeasible} ({} asked of the oracle), invalid {invalid}; at most {} iterations",
        clock.seconds(),
        tally.problems,
        tally.hostile,
        tally.oracle,
        tally.most_iterations,
    );
}

/// Solves one problem, cold or from the solver's present state.
fn one(
    seed: u64,
    solver: &mut Riccati,
    oracle: &mut Clarabel,
    tally: &mut Tally,
) -> Result<(), String> {
    let draw = &mut Draw::new(seed);
    let mut problem = random::problem(draw);
    let hostile = draw.chance(0.7);
    if hostile {
        for _ in 0..1 + draw.below(4) {
            spoil(draw, &mut problem);
        }
    }
    let start = if draw.chance(0.5) { Start::Cold } else { Start::Shifted(draw.below(4)) };
    let report = solver.solve(&problem, start);
    tally.problems += 1;
    tally.hostile += u64::from(hostile);
    tally.by_status[report.status as usize] += 1;
    tally.most_iterations = tally.most_iterations.max(report.iterations);
    check(&problem, solver, &report)?;
    if report.status == Status::Infeasible {
        if !hostile {
            return Err("a feasible problem was called infeasible".into());
        }
        if draw.chance(0.02) {
            tally.oracle += 1;
            let reference = oracle.solve(&problem, Start::Cold);
            if reference.status == Status::Solved && reference.residuals.max() < 1e-7 {
                return Err(format!("the oracle solves what was called infeasible: {reference:?}"));
            }
        }
    }
    Ok(())
}

fn check(problem: &Problem, solver: &Riccati, report: &Report) -> Result<(), String> {
    let (lo, hi) = problem.input_bounds();
    let (inputs, n) = (solver.inputs(), problem.horizon());
    if inputs.len() != n || solver.states().len() != n + 1 {
        return Err("a trajectory of the wrong length".into());
    }
    if !inputs.iter().all(|u| (lo..=hi).contains(u)) {
        return Err(format!("an input out of bounds, {report:?}"));
    }
    if report.iterations > MOST_ITERATIONS {
        return Err(format!("{} iterations", report.iterations));
    }
    let valid = problem.check().is_ok();
    if !valid && report.status != Status::InvalidInput {
        return Err(format!("false numbers were accepted, {report:?}"));
    }
    if report.status == Status::Solved {
        let mut states = vec![[0.0; 3]; n + 1];
        problem.roll_out(inputs, &mut states);
        let found = residuals(problem, inputs, &states, solver.multipliers());
        if found.max() > 1e-8 {
            return Err(format!("called solved with {found:?}, {report:?}"));
        }
    }
    Ok(())
}

/// Replaces one number, or one row of numbers.
fn spoil(draw: &mut Draw, problem: &mut Problem) {
    let n = problem.horizon();
    let k = draw.below(n);
    match draw.below(9) {
        0 => {
            let mut x0 = problem.initial_state();
            x0[draw.below(3)] = hostile(draw);
            problem.set_initial_state(x0);
        }
        1 => problem.disturbances_mut()[k][draw.below(3)] = hostile(draw),
        2 => problem.state_gradients_mut()[k][draw.below(3)] = hostile(draw),
        3 => problem.input_gradients_mut()[k] = hostile(draw),
        4 => problem.set_terminal_gradient([hostile(draw), 0.0, hostile(draw)]),
        5 => problem.set_terminal_target([hostile(draw), hostile(draw), 0.0]),
        6 if !problem.rows().is_empty() => {
            let row = draw.below(problem.rows().len());
            problem.row_limits_mut(row)[k + 1] = hostile(draw);
        }
        7 if !problem.rows().is_empty() => {
            let row = draw.below(problem.rows().len());
            problem.set_row_stages(row, draw.below(n + 2), draw.below(n + 2));
        }
        8 if !problem.light_stages().is_empty() => {
            let mut stages: Vec<LightStage> = problem.light_stages().to_vec();
            let stage = draw.below(stages.len());
            match draw.below(3) {
                0 => stages[stage].offset = hostile(draw),
                1 => stages[stage].gradient[draw.below(3)] = hostile(draw),
                _ => stages.truncate(stage),
            }
            problem.set_light(stages);
        }
        _ => {}
    }
}

/// Returns a number that a sensor, a unit error or a bug may deliver.
fn hostile(draw: &mut Draw) -> f64 {
    let sign = if draw.chance(0.5) { 1.0 } else { -1.0 };
    sign * match draw.below(12) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => f64::MAX,
        3 => 1e300,
        4 => 1e150,
        5 => draw.decades(6.0, 30.0),
        6 => f64::MIN_POSITIVE,
        7 => 5e-324,
        8 => draw.decades(-30.0, -6.0),
        9 => 0.0,
        _ => draw.decades(-3.0, 6.0),
    }
}

/// CPU time of this process on Linux, elapsed time elsewhere.
struct Clock(Instant);

impl Clock {
    fn start() -> Self {
        Self(Instant::now())
    }

    fn seconds(&self) -> f64 {
        let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
        let on_cpu = text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok());
        on_cpu.map_or_else(|| self.0.elapsed().as_secs_f64(), |ns| ns * 1e-9)
    }
}
