//! Effect of each limit of the controller's checks of the radar.
//!
//! ```sh
//! cargo run --release -p campaign --example plausibility_numbers -- [--hours 0.5] [--drives 5]
//! ```
//!
//! Each limit is halved and doubled, within its range, while all others keep their values. A process can replace the
//! limits once, so each value is driven by a process of its own.

use clap::Parser;
use controller::plausibility::radar::LIMITS;
use parameters::effect::{Change, Figure, print_by_processes};

#[derive(Debug, Parser)]
struct Arguments {
    /// Hours without faults
    #[arg(long, default_value_t = 0.5)]
    hours: f64,
    /// Drives with each false radar, 2 to 20
    #[arg(long, default_value_t = 5)]
    drives: u32,
}

fn main() {
    let Arguments { hours, drives } = Arguments::parse();
    print_by_processes(&LIMITS, || {
        let found = campaign::radar_figures(hours, drives);
        let found = found.unwrap_or_else(|error| panic!("{error}"));
        let figure = |(name, value): (String, f64)| {
            let unit = if name.ends_with("after") { "s" } else { "" };
            (Figure { name: name.into(), unit, change: Change::Value(5e-3) }, value)
        };
        found.into_iter().map(figure).collect()
    });
}
