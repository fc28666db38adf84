//! The solvers side by side: `cargo bench -p mpc-solver --bench solver`.
//!
//! Same process, same instances, N = 100, the same judge. The judge is the largest scaled residual of the optimality
//! conditions, by `mpc_solver::residuals`; 1e-8 counts as solved. Each instance is solved several times; its time is
//! the median of these. So the percentiles over the instances show the solver's tail and not the machine's.
//!
//! * *Drives*: the instances of the paper's closed loops (`tests/data/cacc-instances.csv`), and by what is active at the
//!   solution.
//! * *Random problems*, feasible by construction, in four classes: with or without a row that acts, with or without
//!   the light. Their number is `TIMEGAP_BENCH_SEEDS` (of which about four in ten have 100 steps), 10,000 unless given.
//! * *The field* ([`field`]): clarabel on all drives, OSQP on those without the light (with `--features osqp`).
//! * *Horizon*: time per stage up to N = 1000.

#[path = "../../tests/common/mod.rs"]
mod common;
mod field;
#[cfg(feature = "osqp")]
mod osqp;
#[path = "../../tests/common/random.rs"]
mod random;
mod summary;

use std::time::Instant;

use common::{Instance, cacc, instances};
use mpc_solver::{Problem, Riccati, Solver, Start, Status};
use random::Draw;
use summary::{Sample, Summary, header};

/// Solves of each instance, of each random problem, and by the other solvers.
const REPEATS: usize = 21;
const RANDOM_REPEATS: usize = 5;
const FIELD_REPEATS: usize = 5;
/// Seeds of random problems.
const SEEDS: u64 = 10_000;

fn main() {
    // `cargo test --benches` runs this too: one repeat shows that it works.
    let is_brief = !std::env::args().any(|argument| argument == "--bench");
    let repeats = |n: usize| if is_brief { 1 } else { n };
    let table = instances();
    println!(
        "elapsed time per solve, us; N = 100; \"rounds\" of the active set, \"ip\" iterations of the interior point\n"
    );
    for (name, is_lit) in [("ACC", false), ("CACC", true)] {
        drives(name, &select(&table, is_lit), repeats);
    }
    let seeds = std::env::var("TIMEGAP_BENCH_SEEDS").ok().and_then(|text| text.parse().ok());
    random_problems(if is_brief { 100 } else { seeds.unwrap_or(SEEDS) }, repeats(RANDOM_REPEATS));
    scaling(&table, repeats(REPEATS));
}

/// The feasible instances with or without the light.
fn select(table: &[Instance], is_lit: bool) -> Vec<&Instance> {
    table.iter().filter(|i| i.feasible && (i.stages > 0) == is_lit).collect()
}

fn drives(name: &str, set: &[&Instance], repeats: impl Fn(usize) -> usize) {
    header(&format!("{name}, drives"));
    let ours = ours(set, repeats(REPEATS));
    Summary::of(&ours).print("riccati");
    let our_us = Summary::of(&ours).median_us();
    let rivals: Vec<(&str, Summary)> = field::solve(set, repeats(FIELD_REPEATS))
        .into_iter()
        .map(|(name, samples)| (name, Summary::of(&samples)))
        .collect();
    for (rival, summary) in &rivals {
        summary.print(rival);
    }
    for (rival, summary) in &rivals {
        let (count, solved) = summary.counts();
        println!(
            "{rival} / riccati, medians: {:.0}; solves {solved} of {count} to the tolerance",
            summary.median_us() / our_us,
        );
    }
    by_pattern("by what is active", &ours);
    println!();
}

/// A line for each pattern of what is active at the solution.
fn by_pattern(title: &str, samples: &[Sample]) {
    println!("\n{title}");
    let mut patterns: Vec<&str> = samples.iter().map(|sample| sample.pattern).collect();
    patterns.sort_unstable();
    patterns.dedup();
    for pattern in patterns {
        let part: Vec<Sample> = samples.iter().filter(|s| s.pattern == pattern).cloned().collect();
        Summary::of(&part).print(pattern);
    }
}

/// Passes over the set, in its order.
fn ours(set: &[&Instance], repeats: usize) -> Vec<Sample> {
    let mut problem = cacc(100);
    let mut solver = Riccati::new(100);
    let mut times = vec![Vec::with_capacity(repeats); set.len()];
    let mut samples = Vec::new();
    for _ in 0..repeats {
        samples.clear();
        for (instance, times) in set.iter().zip(&mut times) {
            instance.apply(&mut problem);
            let begin = Instant::now();
            let report = solver.solve(&problem, Start::Cold);
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            samples.push(Sample::new(&report, pattern(&problem, &solver)));
        }
    }
    for (sample, times) in samples.iter_mut().zip(&mut times) {
        sample.take_median(times);
    }
    samples
}

/// Active constraints at the solution.
fn pattern(problem: &Problem, solver: &dyn Solver) -> &'static str {
    let (lo, hi) = problem.input_bounds();
    let bounded = solver.inputs().iter().any(|u| *u <= lo || *u >= hi);
    let multipliers = solver.multipliers();
    let lit = multipliers.light[..=problem.light_stages().len()].iter().any(|a| *a > 0.0);
    match (acting_rows(problem, solver), lit, bounded) {
        (0, false, false) => "nothing",
        (0, false, true) => "bounds",
        (0, true, false) => "light",
        (0, true, true) => "light, bounds",
        (1..=2, false, _) => "1 or 2 stages of a row",
        (1..=2, true, _) => "light, 1 or 2 stages of a row",
        (_, false, _) => "3 and more stages of a row",
        (_, true, _) => "light, 3 and more of a row",
    }
}

/// Stages at which a row acts.
fn acting_rows(problem: &Problem, solver: &dyn Solver) -> usize {
    let rows = problem.rows().iter().zip(&solver.multipliers().rows);
    rows.map(|(row, mu)| (row.from..=row.to).filter(|&k| mu[k] > 1e-7).count()).sum()
}

fn random_problems(seeds: u64, repeats: usize) {
    let mut solver = Riccati::new(150);
    let mut classes: [Vec<Sample>; 4] = Default::default();
    for seed in 0..seeds {
        let problem = random::problem(&mut Draw::new(seed));
        if problem.horizon() != 100 {
            continue;
        }
        let mut times = Vec::with_capacity(repeats);
        let mut sample = Sample::default();
        for _ in 0..repeats {
            let begin = Instant::now();
            let report = solver.solve(&problem, Start::Cold);
            times.push(begin.elapsed().as_secs_f64() * 1e6);
            sample = Sample::new(&report, pattern(&problem, &solver));
        }
        sample.take_median(&mut times);
        let is_lit = !problem.light_stages().is_empty();
        let acts = acting_rows(&problem, &solver) > 0;
        classes[usize::from(acts) * 2 + usize::from(is_lit)].push(sample);
    }
    header(&format!("random feasible problems, {seeds} seeds, cold"));
    let names = ["no row acts, no light", "light", "rows", "rows and light"];
    for (name, samples) in names.iter().zip(&classes) {
        Summary::of(samples).print(name);
    }
    by_pattern("by what is active", &classes.concat());
    println!();
}

/// Time against the horizon, on the instances that are solved at every horizon.
fn scaling(table: &[Instance], repeats: usize) {
    println!("horizon: median over the instances that are solved at every N, cold");
    println!("{:<10} {:>6} {:>5} {:>9} {:>9}", "", "N", "n", "us", "us/stage");
    let horizons = [25, 50, 100, 200, 400, 800, 1000];
    for (name, is_lit) in [("ACC", false), ("CACC", true)] {
        let mut set = select(table, is_lit);
        for n in horizons {
            let (mut problem, mut solver) = (cacc(n), Riccati::new(n));
            set.retain(|instance| {
                instance.apply(&mut problem);
                solver.solve(&problem, Start::Cold).status == Status::Solved
            });
        }
        for n in horizons {
            let (mut problem, mut solver) = (cacc(n), Riccati::new(n));
            let mut samples = Vec::new();
            for instance in &set {
                instance.apply(&mut problem);
                let mut times = Vec::with_capacity(repeats);
                let mut sample = Sample::default();
                for _ in 0..repeats {
                    let begin = Instant::now();
                    let report = solver.solve(&problem, Start::Cold);
                    times.push(begin.elapsed().as_secs_f64() * 1e6);
                    sample = Sample::new(&report, "");
                }
                sample.take_median(&mut times);
                samples.push(sample);
            }
            let median = Summary::of(&samples).median_us();
            let (count, per_stage) = (set.len(), median / n as f64);
            println!("{name:<10} {n:>6} {count:>5} {median:>9.2} {per_stage:>9.4}");
        }
    }
}
