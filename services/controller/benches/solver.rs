//! The solver made for the predictive laws against clarabel, on the same instances in one process.
//!
//! ```text
//! cargo bench -p controller --bench solver
//! ```
//!
//! The instances are those of `tests/data/cacc-instances.csv` that have a solution: closed loops of
//! the paper's scenarios, N = 100. Every time is the thread's CPU time of one solve. Accuracy is
//! that of the answer: the largest scaled residual of the optimality conditions, evaluated by the
//! same function for both.

#[path = "../../mpc-solver/tests/common/mod.rs"]
mod common;

use common::{Instance, cacc, instances};
use mpc_solver::{Clarabel, Problem, Riccati, Solver, Start, Status, residuals};
use rustix::time::{ClockId, clock_gettime};

/// Times that each instance is solved by ours; clarabel is solved once, it takes long enough.
const REPEATS: usize = 5;

fn main() {
    let solvable: Vec<Instance> = instances().into_iter().filter(|i| i.feasible).collect();
    println!("one solve, thread CPU time in µs, N = 100");
    println!(
        "{:<24} {:>8} {:>8} {:>8} {:>8} {:>12} {:>10} {:>8}",
        "", "p50", "p99", "max", "p99/p50", "iterations", "residual", "samples"
    );
    for (name, lit) in [("ACC (QP)", false), ("CACC (light)", true)] {
        let set: Vec<&Instance> = solvable.iter().filter(|i| (i.stages > 0) == lit).collect();
        let mut riccati = Riccati::new(100);
        let cold = measure(&set, &mut riccati, REPEATS, |_| Start::Cold);
        cold.print(&format!("{name}: ours, cold"));
        let mut riccati = Riccati::new(100);
        let warm = measure(&set, &mut riccati, 1, |follows| {
            if follows { Start::Shifted(1) } else { Start::Cold }
        });
        warm.print(&format!("{name}: ours, warm"));
        let mut clarabel = Clarabel::with_tolerance(1e-8);
        let oracle = measure(&set, &mut clarabel, 1, |_| Start::Cold);
        oracle.print(&format!("{name}: clarabel"));
        println!(
            "{name}: clarabel's median is {:.0} times ours cold, {:.0} times ours warm",
            oracle.quantile(0.5) / cold.quantile(0.5),
            oracle.quantile(0.5) / warm.quantile(0.5),
        );
    }
    scaling(&solvable);
}

/// How the time grows with the horizon, on scenario A's first instance with and without its light.
fn scaling(solvable: &[Instance]) {
    println!("\nhorizon, median of 101 cold solves in µs, and per stage");
    println!("{:>8} {:>10} {:>10} {:>10} {:>10}", "N", "ACC", "per stage", "CACC", "per stage");
    let first = |lit: bool| {
        let mut found = solvable.iter().filter(|i| (i.stages > 0) == lit);
        found.next().expect("scenario A is among the instances")
    };
    for n in [25, 50, 100, 200, 400, 800, 1000] {
        let median = |instance: &Instance| {
            let mut problem = cacc(n);
            instance.apply(&mut problem);
            let mut solver = Riccati::new(n);
            let mut times: Vec<f64> =
                (0..101).map(|_| timed(|| solver.solve(&problem, Start::Cold)).1).collect();
            times.sort_by(f64::total_cmp);
            times[50]
        };
        let [acc, cacc] = [median(first(false)), median(first(true))];
        let stages = n as f64;
        println!("{n:>8} {acc:>10.1} {:>10.3} {cacc:>10.1} {:>10.3}", acc / stages, cacc / stages);
    }
}

#[derive(Default)]
struct Sample {
    times_us: Vec<f64>,
    iterations: Vec<u32>,
    residual: f64,
    unsolved: usize,
}

impl Sample {
    fn quantile(&self, q: f64) -> f64 {
        let mut sorted = self.times_us.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[((sorted.len() - 1) as f64 * q).round() as usize]
    }

    fn print(&self, name: &str) {
        let mut iterations = self.iterations.clone();
        iterations.sort_unstable();
        let (p50, p99) = (self.quantile(0.5), self.quantile(0.99));
        let iterations =
            format!("{} to {}", iterations[iterations.len() / 2], iterations[iterations.len() - 1]);
        let unsolved = match self.unsolved {
            0 => String::new(),
            count => format!("  ({count} not solved)"),
        };
        println!(
            "{name:<24} {p50:>8.1} {p99:>8.1} {:>8.1} {:>8.2} {iterations:>12} {:>10.1e} {:>8}{unsolved}",
            self.quantile(1.0),
            p99 / p50,
            self.residual,
            self.times_us.len(),
        );
    }
}

/// Solves all instances in order; `start` is told whether an instance follows the one before it.
fn measure(
    set: &[&Instance],
    solver: &mut dyn Solver,
    repeats: usize,
    start: impl Fn(bool) -> Start,
) -> Sample {
    let mut problem = cacc(100);
    let mut sample = Sample::default();
    let mut before = None;
    for instance in set {
        instance.apply(&mut problem);
        let follows = before == Some(instance.id.wrapping_sub(1));
        before = Some(instance.id);
        for _ in 0..repeats {
            let (report, us) = timed(|| solver.solve(&problem, start(follows)));
            sample.times_us.push(us);
            sample.iterations.push(report.iterations);
            sample.unsolved += usize::from(report.status != Status::Solved);
        }
        sample.residual = sample.residual.max(residual(&problem, solver));
    }
    sample
}

fn residual(problem: &Problem, solver: &dyn Solver) -> f64 {
    let mut states = vec![[0.0; 3]; problem.horizon() + 1];
    problem.roll_out(solver.inputs(), &mut states);
    residuals(problem, solver.inputs(), &states, solver.multipliers()).max()
}

/// Runs `work` and tells the CPU time that this thread spent in it, µs.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let now = || {
        let time = clock_gettime(ClockId::ThreadCPUTime);
        time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 / 1e3
    };
    let begun = now();
    let result = work();
    (result, now() - begun)
}
