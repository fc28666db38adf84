//! Effect of each number in a law's table, or of the numbers that all laws share (`following`).
//!
//! ```sh
//! cargo run --release -p regulation --example law_numbers -- six-mode six_mode
//! cargo run --release -p regulation --example law_numbers -- predictive predictive --built-in truck-traffic,truck-brake
//! cargo run --release -p regulation --example law_numbers -- acc-mpc following
//! ```
//!
//! Each number is halved and doubled while all others keep their values. A value that the law refuses is replaced by
//! the nearest of 0.8 and 1.25 times the number that it accepts. The law drives everyday scenes without the emergency
//! brake, or the built-in scenarios that are named. A process can replace shared numbers once, so each value of them is
//! driven by a process of its own.

use std::process::{Command, ExitCode};

use clap::Parser;
use controller::following::parameters::{FOLLOWING, Following};
use controller::laws;
use group::report::Outcome;
use parameters::{Row, Table};
use regulation::everyday::Kind;
use report::summary::Summary;
use runtime::Mode;
use scenario::schema::{Key, Shape};
use scenario::{Overrides, Scenario, builtin};

#[derive(Debug, Parser)]
struct Arguments {
    /// Name of the law
    law: String,
    /// Name of its table, or `following`
    table: String,
    /// Everyday scenes of each kind
    #[arg(long, default_value_t = 4)]
    count: u32,
    /// Built-in scenarios instead of everyday scenes
    #[arg(long, value_delimiter = ',')]
    built_in: Vec<String>,
    /// Duration of a built-in scenario, s
    #[arg(long, default_value_t = 120.0)]
    duration: f64,
    /// Replace this row of `following` and print the figures alone: the example calls itself so
    #[arg(long, hide = true)]
    replace: Option<String>,
}

/// Name of the table of shared numbers.
const SHARED: &str = "following";

/// Kinds of scenes in which a law has to act.
const KINDS: [Kind; 4] = [Kind::CutIn, Kind::Stop, Kind::BrakingLead, Kind::CutOut];

/// Figures with their names, the smallest change that counts, and whether the change is relative.
const FIGURES: [(&str, f64, bool); 6] = [
    ("collisions", 0.5, false),
    ("least gap, %", 2.0, true),
    ("hardest braking, %", 2.0, true),
    ("rms jerk, %", 2.0, true),
    ("fuel, %", 0.1, true),
    ("service brake, %", 2.0, true),
];

type Figures = [f64; FIGURES.len()];

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some((row, value)) = arguments.replace.as_deref().and_then(|text| text.split_once('=')) {
        let found = row.parse().ok().zip(value.parse().ok()).and_then(|(row, value)| {
            FOLLOWING.replace(Following::DEFAULT.with(row, value)).ok()?;
            figures(&arguments, &[])
        });
        println!("{}", serde_json::to_string(&found).expect("plain numbers"));
        return ExitCode::SUCCESS;
    }
    let Some(base) = figures(&arguments, &[]) else {
        eprintln!("error: {} does not drive these scenes", arguments.law);
        return ExitCode::from(2);
    };
    println!("{}: {}", arguments.law, cells(&base));
    for (path, value) in numbers(&arguments.table) {
        let tries = [[0.5, 0.8], [2.0, 1.25]];
        let words = tries.into_iter().filter_map(|factors| {
            let changed = |factor: f64| {
                let typed = (value * factor * 1e6).round() / 1e6;
                let found = if arguments.table == SHARED {
                    figures_with_shared(&path, typed)?
                } else {
                    figures(&arguments, &[format!("controller.{path}={typed:?}")])?
                };
                Some(format!("at {typed} {}", effect(&base, &found)))
            };
            factors.into_iter().find_map(changed)
        });
        println!("{path}: {}.", words.collect::<Vec<_>>().join("; "));
    }
    ExitCode::SUCCESS
}

/// The numbers of a law's table that have a default other than 0.
fn numbers(table: &str) -> Vec<(String, f64)> {
    if table == SHARED {
        let rows = Following::ROWS.iter().enumerate();
        return rows
            .map(|(row, Row { name, .. })| ((*name).into(), Following::DEFAULT.value(row)))
            .collect();
    }
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

/// The figures with another value of a shared number, from a process of its own; `None` outside of its range.
fn figures_with_shared(name: &str, value: f64) -> Option<Figures> {
    let row = Following::ROWS.iter().position(|row| row.name == name)?;
    let (least, most) = Following::ROWS[row].range;
    if !(least..=most).contains(&value) {
        return None;
    }
    let program = std::env::current_exe().ok()?;
    let own = std::env::args().skip(1);
    let answer =
        Command::new(program).args(own).arg(format!("--replace={row}={value:?}")).output().ok()?;
    serde_json::from_slice(&answer.stdout).ok()?
}

/// The figures of all scenes with other values of some keys; `None` if the law refuses one.
fn figures(arguments: &Arguments, set: &[String]) -> Option<Figures> {
    let mut overrides = Overrides::new();
    for argument in set {
        overrides.set(argument).ok()?;
    }
    let mut sums = Figures::default();
    let mut scenes = 0.0;
    let mut drive = |scenario: &Scenario| -> Option<()> {
        let group = group::in_process::run_unsealed(scenario, &|| false).ok()?;
        let summary = Summary::new(scenario, Mode::Lockstep, &group, group.ran_for);
        let control = &summary.control.figures;
        let all = [
            f64::from(u8::from(summary.outcome == Outcome::Collision)),
            control.min_gap_m.unwrap_or(0.0),
            control.min_accel_mps2.unwrap_or(0.0),
            control.rms_jerk_mps3.unwrap_or(0.0),
            control.fuel_l_per_100km.unwrap_or(0.0),
            control.service_brake_s.unwrap_or(0.0),
        ];
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
    // Collisions are counted; all others are means.
    sums[1..].iter_mut().for_each(|sum| *sum /= scenes);
    Some(sums)
}

fn cells(figures: &Figures) -> String {
    let cells = FIGURES.iter().zip(figures).map(|((name, ..), value)| {
        let name = name.trim_end_matches(", %");
        format!("{name} {value:.3}")
    });
    cells.collect::<Vec<_>>().join(", ")
}

/// The figures that change, in words.
fn effect(base: &Figures, changed: &Figures) -> String {
    let all = FIGURES.iter().zip(base.iter().zip(changed));
    let words = all.filter_map(|((name, counts, relative), (was, is))| {
        let change = if *relative { 100.0 * (is / was - 1.0) } else { is - was };
        let (name, unit) = name.split_once(", ").unwrap_or((name, ""));
        let digits = usize::from(*counts < 0.5);
        (change.abs() >= *counts)
            .then(|| format!("{name} {change:+.digits$} {unit}").trim_end().to_owned())
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() { "no change".to_owned() } else { words.join(", ") }
}
