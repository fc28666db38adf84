//! Effect of each number in a law's table, or of numbers that all laws share (`following`, `v2x-sim`).
//!
//! ```sh
//! cargo run --release -p standards --example law_numbers -- six-mode six_mode
//! cargo run --release -p standards --example law_numbers -- predictive predictive --built-in truck-traffic,truck-brake
//! cargo run --release -p standards --example law_numbers -- acc-mpc following
//! ```
//!
//! Each number is halved and doubled while all others keep their values. If the law refuses a value, the nearest of 0.8
//! and 1.25 times the number that it accepts replaces it. Shared numbers stay within their ranges. The law drives
//! everyday scenes without the emergency brake, or the built-in scenarios that are named. A process can replace shared
//! numbers once, so each value of them is driven by a process of its own.

use clap::Parser;
use controller::following::parameters::FOLLOWING;
use controller::laws;
use group::report::Outcome;
use parameters::effect::{Figure, line, print_by_processes};
use report::summary::Summary;
use runtime::Mode;
use scenario::schema::{Key, Shape};
use scenario::{Overrides, Scenario, builtin};
use standards::everyday::Kind;
use v2x_sim::numbers::NUMBERS;

#[derive(Debug, Parser)]
struct Arguments {
    /// Name of the law
    law: String,
    /// Name of its table, `following` or `v2x-sim`
    table: String,
    /// Everyday scenes of each kind
    #[arg(long, default_value_t = 4)]
    count: u32,
    /// Built-in scenarios instead of everyday scenes
    #[arg(long, value_delimiter = ',')]
    built_in: Vec<String>,
    /// Other values of keys, in all scenarios
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Duration of a built-in scenario, s
    #[arg(long, default_value_t = 120.0)]
    duration: f64,
}

/// Kinds of scenes in which a law has to act.
const KINDS: [Kind; 4] = [Kind::CutIn, Kind::Stop, Kind::BrakingLead, Kind::CutOut];

/// Collisions and red lights are counted; all other figures are means.
static FIGURES: [Figure; 10] = [
    Figure::difference("collisions", "", 1.0),
    Figure::difference("red lights", "", 1.0),
    Figure::percent("least gap", "m", 2.0),
    Figure::percent("hardest braking", "m/s²", 2.0),
    Figure::percent("rms jerk", "m/s³", 2.0),
    Figure::percent("lateral acceleration", "m/s²", 2.0),
    Figure::difference("stops", "", 0.05),
    Figure::percent("fuel", "l/100 km", 0.1),
    Figure::percent("energy", "kWh/100 km", 0.5),
    Figure::percent("service brake", "s", 2.0),
];
/// Number of the figures that are counted.
const COUNTED: usize = 2;

fn main() {
    let arguments = Arguments::parse();
    let measure = || {
        figures(&arguments, &[]).unwrap_or_else(|| {
            eprintln!("error: {} does not drive these scenes", arguments.law);
            std::process::exit(2);
        })
    };
    let shared = || FIGURES.iter().cloned().zip(measure()).collect();
    match arguments.table.as_str() {
        "following" => print_by_processes(&FOLLOWING, shared),
        "v2x-sim" => print_by_processes(&NUMBERS, shared),
        table => print_own(&arguments, table, &measure()),
    }
}

/// Prints the effects of the numbers in a law's table.
fn print_own(arguments: &Arguments, table: &str, base: &[f64]) {
    for (figure, value) in FIGURES.iter().zip(base) {
        println!("{}", figure.text(*value));
    }
    for (path, value) in numbers(table) {
        let tries = [[0.5, 0.8], [2.0, 1.25]];
        let tried = tries.into_iter().filter_map(|factors| {
            let changed = |factor: f64| {
                let typed = (value * factor * 1e6).round() / 1e6;
                let found = figures(arguments, &[format!("controller.{path}={typed:?}")])?;
                Some((typed, found))
            };
            factors.into_iter().find_map(changed)
        });
        println!("{}", line(&path, &FIGURES, base, &tried.collect::<Vec<_>>()));
    }
}

/// The numbers of a law's table that have a default other than 0.
fn numbers(table: &str) -> Vec<(String, f64)> {
    let mut all = Vec::new();
    for found in laws::tables().into_iter().filter(|found| found.name == table) {
        collect(&format!("{table}."), (found.keys)(), &mut all);
    }
    all
}

fn collect(prefix: &str, keys: Vec<Key>, into: &mut Vec<(String, f64)>) {
    for key in keys {
        let path = format!("{prefix}{}", key.name);
        match key.shape {
            Shape::Table(below) => collect(&format!("{path}."), below, into),
            Shape::Number { is_whole: false, .. } => {
                let default = key.default.and_then(|value| value.as_float());
                into.extend(default.filter(|value| *value != 0.0).map(|value| (path, value)));
            }
            _ => {}
        }
    }
}

/// The figures of all scenes with other values of some keys; `None` if the law refuses one.
fn figures(arguments: &Arguments, set: &[String]) -> Option<Vec<f64>> {
    let mut overrides = Overrides::new();
    for argument in arguments.set.iter().chain(set) {
        overrides.set(argument).ok()?;
    }
    let mut sums = vec![0.0; FIGURES.len()];
    let mut scenes = 0.0;
    let mut drive = |scenario: &Scenario| -> Option<()> {
        let group = group::in_process::run_unsealed(scenario, &|| false).ok()?;
        let summary = Summary::new(scenario, Mode::Lockstep, &group, group.ran_for);
        let control = &summary.control.figures;
        let ended = |outcome| f64::from(u8::from(summary.outcome == outcome));
        let all = [
            Some(ended(Outcome::Collision)),
            Some(ended(Outcome::RedLight)),
            control.min_gap_m,
            control.min_accel_mps2,
            control.rms_jerk_mps3,
            control.max_abs_lateral_accel_mps2,
            control.stops.map(|stops| stops as f64),
            control.fuel_l_per_100km,
            control.wheel_energy_kwh_per_100km,
            control.service_brake_s,
        ];
        let all = all.map(|figure| figure.unwrap_or(0.0));
        sums.iter_mut().zip(all).for_each(|(sum, figure)| *sum += figure);
        scenes += 1.0;
        Some(())
    };
    if arguments.built_in.is_empty() {
        for kind in KINDS {
            for number in 0..arguments.count {
                let text = kind.scene(number).text(number, &arguments.law, false);
                drive(&Scenario::parse_with("scene", &text, &overrides, &laws::check).ok()?)?;
            }
        }
    } else {
        overrides.set(&format!("duration_s={:?}", arguments.duration)).ok()?;
        for name in &arguments.built_in {
            let text = builtin::find(name)?.text;
            drive(&Scenario::parse_with(name, text, &overrides, &laws::check).ok()?)?;
        }
    }
    sums[COUNTED..].iter_mut().for_each(|sum| *sum /= scenes);
    Some(sums)
}
