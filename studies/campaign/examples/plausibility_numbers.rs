//! Effect of each limit of the controller's checks of the radar.
//!
//! ```sh
//! cargo run --release -p campaign --example plausibility_numbers -- [--hours 0.5] [--drives 5]
//! ```
//!
//! Each limit is halved and doubled, within its range, while all others keep their values. A process can replace the
//! limits once, so each value is driven by a process of its own.

use std::process::{Command, ExitCode};

use clap::Parser;
use controller::plausibility::radar::{LIMITS, Limits};
use parameters::{Row, Table};

#[derive(Debug, Parser)]
struct Arguments {
    /// Hours without faults
    #[arg(long, default_value_t = 0.5)]
    hours: f64,
    /// Drives with each false radar, 2 to 20
    #[arg(long, default_value_t = 5)]
    drives: u32,
    /// Replace this row and print the figures alone: the example calls itself so
    #[arg(long, hide = true)]
    replace: Option<String>,
}

type Figures = Vec<(String, f64)>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some((row, value)) = arguments.replace.as_deref().and_then(|text| text.split_once('=')) {
        let (row, value) = (row.parse().expect("a row"), value.parse().expect("a number"));
        LIMITS.replace(Limits::DEFAULT.with(row, value)).expect("it is the first replacement");
    }
    let found = campaign::radar_figures(arguments.hours, arguments.drives);
    let base = match found {
        Ok(found) => found,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    if arguments.replace.is_some() {
        println!("{}", serde_json::to_string(&base).expect("plain numbers"));
        return ExitCode::SUCCESS;
    }
    for (name, value) in &base {
        println!("{name}: {value:.3}");
    }
    for (row, Row { name, .. }) in Limits::ROWS.iter().enumerate() {
        let effects = [0.5, 2.0].map(|factor| {
            let value = Limits::DEFAULT.scaled(row, factor).value(row);
            format!("at {value} {}", effect(&base, &figures_with(row, value)))
        });
        println!("{name}: {}.", effects.join("; "));
    }
    ExitCode::SUCCESS
}

/// The figures with another limit, from a process of its own.
fn figures_with(row: usize, value: f64) -> Figures {
    let program = std::env::current_exe().expect("the kernel knows this program");
    let own = std::env::args().skip(1);
    let answer = Command::new(program).args(own).arg(format!("--replace={row}={value:?}")).output();
    serde_json::from_slice(&answer.expect("this program starts").stdout).expect("its figures")
}

/// The figures that change, in words.
fn effect(base: &Figures, changed: &Figures) -> String {
    let value =
        |of: &Figures, name: &str| of.iter().find(|figure| figure.0 == name).map(|figure| figure.1);
    let words = base.iter().filter_map(|(name, was)| {
        let is = value(changed, name)?;
        let (name, unit) = name.rsplit_once(", ").unwrap_or((name, ""));
        let words = || format!("{name} {is:.2} instead of {was:.2} {unit}").trim_end().to_owned();
        ((is - was).abs() > 5e-3).then(words)
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() { "no change".to_owned() } else { words.join(", ") }
}
