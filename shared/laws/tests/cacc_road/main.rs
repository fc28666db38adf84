//! The road formulation in a closed loop: single scenes, and thousands of random ones.

mod cases;
mod comfort;
mod efficiency;
mod later_signals;
mod scenes;
mod solvers;
mod world;

use std::ops::Range;

use cases::Case;
use comfort::Record;
use law::{Law, Output};
use laws::cacc::config::Config;
use laws::cacc::road::RoadLaw;
use mpc_solver::Solver;
use solvers::{Fake, Temper};
use world::{Breach, Signal};

/// The comfort bound of the default configuration, with what a request may overshoot it by.
const COMFORT_MPS2: f64 = -3.05;

fn law_with(solver: Box<dyn Solver + Send>) -> RoadLaw {
    RoadLaw::new(&Config::default(), true, solver).expect("the default configuration is convex")
}

fn law() -> RoadLaw {
    law_with(Config::default().create_solver())
}

/// Result of a random case.
struct Outcome {
    hardest_mps2: f64,
    /// A comfortable solution existed at every event.
    comfortable: bool,
    /// Lines crossed.
    crossed: usize,
    /// Stops made before the end.
    stops: usize,
}

fn drive(seed: u64, law: &mut RoadLaw) -> Result<Outcome, Breach> {
    let mut case = Case::new(seed);
    law.reset();
    let mut output = Output::default();
    let (mut hardest_mps2, mut stops) = (0.0_f64, 0);
    let mut record = Record::default();
    while case.world.time_s < case.seconds {
        let events = case.events();
        for &event in &events {
            case.world.apply(event);
        }
        record.note(&case.world, &events);
        let moved = case.world.ego.speed_mps > 0.0;
        case.world.step(law, &mut output)?;
        hardest_mps2 = hardest_mps2.min(case.world.ego.acceleration_mps2);
        stops += usize::from(moved && case.world.ego.speed_mps == 0.0);
    }
    let passed = |s: &&Signal| s.line_m <= case.world.ego.position_m;
    let crossed = case.world.signals.iter().filter(passed).count();
    Ok(Outcome { hardest_mps2, comfortable: record.comfortable(), crossed, stops })
}

/// Drives all `seeds`: no breach, and comfort wherever it was possible. Returns how often it was.
fn all_are_safe(seeds: Range<u64>, make: impl Fn(u64) -> RoadLaw, comfort: bool) -> usize {
    let (mut comfortable, mut crossed, mut stops) = (0, 0, 0);
    let mut failures = Vec::new();
    let count = (seeds.end - seeds.start) as usize;
    for seed in seeds {
        let outcome = match drive(seed, &mut make(seed)) {
            Ok(outcome) => outcome,
            Err(breach) => {
                failures.push(format!("seed {seed}: {breach:?}"));
                continue;
            }
        };
        crossed += outcome.crossed;
        stops += outcome.stops;
        if outcome.comfortable {
            comfortable += 1;
            let hardest = outcome.hardest_mps2;
            if comfort && hardest < COMFORT_MPS2 {
                failures.push(format!("seed {seed}: {hardest:.2} m/s² was not necessary"));
            }
        }
    }
    println!("{count} cases: {crossed} lines crossed, {stops} stops, {comfortable} comfortable");
    assert!(failures.is_empty(), "{failures:#?}");
    // A vehicle that never goes is safe and useless.
    assert!(!comfort || crossed > count, "{crossed} lines crossed in {count} cases");
    comfortable
}

/// Random cases with the real solver, in two tests: each takes a core of its own.
fn real_cases_are_safe_and_comfortable(seeds: Range<u64>) {
    let comfortable = all_are_safe(seeds, |_| law(), true);
    assert!(comfortable > 0);
}

#[test]
fn random_cases_are_safe_and_comfortable() {
    real_cases_are_safe_and_comfortable(0..30);
}

#[test]
fn more_random_cases_are_safe_and_comfortable() {
    real_cases_are_safe_and_comfortable(30..60);
}

#[test]
fn random_cases_are_safe_and_comfortable_when_the_solver_always_fails() {
    let make = |seed| law_with(Box::new(Fake::new(Temper::Fails, seed)));
    let comfortable = all_are_safe(0..300, make, true);
    assert!(comfortable > 40, "{comfortable}");
}

#[test]
fn random_cases_are_safe_when_the_solver_returns_anything() {
    all_are_safe(0..150, |seed| law_with(Box::new(Fake::new(Temper::FalselySolved, seed))), false);
}

/// The long run of the three properties above; about a quarter of an hour.
#[test]
#[ignore = "long"]
fn many_random_cases_are_safe() {
    let fails = |seed| law_with(Box::new(Fake::new(Temper::Fails, seed)));
    let falsely_solved = |seed| law_with(Box::new(Fake::new(Temper::FalselySolved, seed)));
    println!("solver fails: {} comfortable of 10000", all_are_safe(10_000..20_000, fails, true));
    all_are_safe(20_000..30_000, falsely_solved, false);
    println!("solved: {} comfortable of 2000", all_are_safe(30_000..32_000, |_| law(), true));
}
