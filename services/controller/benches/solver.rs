//! The solvers side by side: `cargo bench -p controller --bench solver`.
//!
//! Same process, same instances (`tests/data/cacc-instances.csv`, N = 100), same tolerance (1e-8), the same
//! judge: the largest scaled residual of the optimality conditions, evaluated by `mpc_solver::residuals`.
//! Each instance is solved `REPEATS` times; its time is the median of these, so that the percentiles
//! over the instances show the solver's tail and not the machine's. For clarabel only its own solve
//! counts, not the assembly of its matrices.

use std::time::Instant;

use mpc_solver::{Clarabel, Problem, Report, Riccati, Solver, Start, Status};

#[path = "../../../shared/mpc-solver/tests/common/mod.rs"]
mod common;

use common::{Instance, cacc, instances};

/// Solves of each instance.
const REPEATS: usize = 21;
/// The same for clarabel.
const ORACLE_REPEATS: usize = 5;
const TOLERANCE: f64 = 1e-8;

fn main() {
    // `cargo test --benches` runs this too: one repeat shows that it works.
    let brief = !std::env::args().any(|argument| argument == "--bench");
    let repeats = |n: usize| if brief { 1 } else { n };
    let table = instances();
    println!(
        "thread's elapsed time per solve, us; instances of N = 100 steps; tolerance {TOLERANCE:e}\n"
    );
    println!(
        "{:<26} {:>5} {:>9} {:>9} {:>9} {:>7} {:>7} {:>9} {:>7} {:>9}",
        "", "n", "p50", "p99", "max", "p99/p50", "iter50", "iter max", "solved", "residual"
    );
    for (name, lit) in [("ACC (QP)", false), ("CACC (light)", true)] {
        let set: Vec<&Instance> =
            table.iter().filter(|i| i.feasible && (i.stages > 0) == lit).collect();
        let cold = ours(&set, repeats(REPEATS), Start::Cold);
        let warm = ours(&set, repeats(REPEATS), Start::Shifted(1));
        let oracle = clarabel(&set, repeats(ORACLE_REPEATS));
        cold.print(&format!("{name}: riccati, cold"));
        warm.print(&format!("{name}: riccati, warm"));
        oracle.print(&format!("{name}: clarabel"));
        println!(
            "{:<26} cold {:.0}, warm {:.0}\n",
            format!("{name}: ratio of medians"),
            oracle.percentile(50) / cold.percentile(50),
            oracle.percentile(50) / warm.percentile(50),
        );
    }
    scaling(&table, repeats(REPEATS));
}

/// Times, iterations and worst residual over a set of instances.
#[derive(Default)]
struct Summary {
    times_us: Vec<f64>,
    iterations: Vec<u32>,
    solved: usize,
    residual: f64,
}

impl Summary {
    fn add(&mut self, times: &mut [f64], report: &Report) {
        times.sort_by(f64::total_cmp);
        self.times_us.push(times[times.len() / 2]);
        self.times_us.sort_by(f64::total_cmp);
        self.iterations.push(report.iterations);
        self.iterations.sort_unstable();
        self.solved += usize::from(report.status == Status::Solved);
        self.residual = self.residual.max(report.residuals.max());
    }

    /// Nearest rank.
    fn percentile(&self, percent: usize) -> f64 {
        let rank = (self.times_us.len() * percent).div_ceil(100).max(1);
        self.times_us[rank - 1]
    }

    fn print(&self, name: &str) {
        let n = self.times_us.len();
        let (p50, p99) = (self.percentile(50), self.percentile(99));
        println!(
            "{name:<26} {n:>5} {p50:>9.2} {p99:>9.2} {:>9.2} {:>7.2} {:>7} {:>9} {:>7} {:>9.1e}",
            self.times_us[n - 1],
            p99 / p50,
            self.iterations[n / 2],
            self.iterations[n - 1],
            self.solved,
            self.residual,
        );
    }
}

/// Passes over the set, in its order: the warm start is the previous instance's solution.
fn ours(set: &[&Instance], repeats: usize, start: Start) -> Summary {
    let mut problem = cacc(100);
    let mut solver = Riccati::new(100);
    let mut times = vec![Vec::with_capacity(repeats); set.len()];
    let mut reports = Vec::new();
    for _ in 0..repeats {
        reports.clear();
        let mut last = None;
        for (instance, times) in set.iter().zip(&mut times) {
            instance.apply(&mut problem);
            // Only the next instance of the same run continues the one before.
            let follows = last == Some(instance.id.wrapping_sub(1)) && instance.step > 0;
            let start = if follows { start } else { Start::Cold };
            let begin = Instant::now();
            let report = solver.solve(&problem, start);
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            reports.push(report);
            last = Some(instance.id);
        }
    }
    let mut summary = Summary::default();
    for (times, report) in times.iter_mut().zip(&reports) {
        summary.add(times, report);
    }
    summary
}

fn clarabel(set: &[&Instance], repeats: usize) -> Summary {
    let mut problem = cacc(100);
    let mut solver = Clarabel::with_tolerance(TOLERANCE);
    let mut summary = Summary::default();
    for instance in set {
        instance.apply(&mut problem);
        let mut times = Vec::with_capacity(repeats);
        for _ in 0..repeats {
            solver.prepare(&problem).expect("the table holds only finite numbers");
            let begin = Instant::now();
            solver.run();
            times.push(begin.elapsed().as_secs_f64() * 1e6);
        }
        summary.add(&mut times, &solver.finish(&problem));
    }
    summary
}

/// Time against the horizon, on the instances that are feasible at the shortest one.
fn scaling(table: &[Instance], repeats: usize) {
    println!("horizon: median over the instances that are solved at every N, cold");
    println!("{:<10} {:>6} {:>5} {:>9} {:>9} {:>8}", "", "N", "n", "us", "us/stage", "iter50");
    let horizons = [25, 50, 100, 200, 400, 800, 1000];
    for (name, lit) in [("ACC", false), ("CACC", true)] {
        let mut set: Vec<&Instance> =
            table.iter().filter(|i| i.feasible && (i.stages > 0) == lit).collect();
        for n in horizons {
            let mut problem = cacc(n);
            let mut solver = Riccati::new(n);
            set.retain(|instance| {
                instance.apply(&mut problem);
                solver.solve(&problem, Start::Cold).status == Status::Solved
            });
        }
        for n in horizons {
            let mut problem = cacc(n);
            let summary = at_horizon(&set, &mut problem, repeats);
            let p50 = summary.percentile(50);
            let iterations = summary.iterations[set.len() / 2];
            let per_stage = p50 / n as f64;
            println!(
                "{name:<10} {n:>6} {:>5} {p50:>9.2} {per_stage:>9.4} {iterations:>8}",
                set.len()
            );
        }
    }
}

fn at_horizon(set: &[&Instance], problem: &mut Problem, repeats: usize) -> Summary {
    let mut solver = Riccati::new(problem.horizon());
    let mut summary = Summary::default();
    for instance in set {
        instance.apply(problem);
        let mut times = Vec::with_capacity(repeats);
        let mut report = solver.solve(problem, Start::Cold);
        for _ in 0..repeats {
            let begin = Instant::now();
            report = solver.solve(problem, Start::Cold);
            times.push(begin.elapsed().as_secs_f64() * 1e6);
        }
        summary.add(&mut times, &report);
    }
    summary
}
