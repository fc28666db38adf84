//! Random drives by the hundred, judged by ground truth that no law, radar or emergency brake has.
//!
//! ```text
//! number ─ generator ─► scenario ─► drive ─ judge ─► facts ─┬─► figures of drives with something in common
//!                                                            └─► figures of all, beside their limits ─► verdict
//! ```
//!
//! | population | scenes | judge |
//! | --- | --- | --- |
//! | `signals` | corridors of signals | the fastest legal trip, and the greens that could be reached |
//! | `curves` | random curved roads, queues at entries and exits of curves | whom the target belongs to |
//! | `everyday` | 22 kinds of everyday scenes | contacts that brakes avoid, interventions that nothing needed |
//! | `plausibility` | 26 kinds of drives without faults, and false senders | alarms of the controller's checks |
//!
//! A new population implements `population::Population`: a generator, a judge and figures. Its limits are rows of
//! `limits`. The engine plans, drives and shows it. A scene is a function of its number alone, and each has a command
//! that repeats it.
//!
//! ```
//! use clap::Subcommand;
//!
//! let command = populations::PopulationCommand::augment_subcommands(clap::Command::new("test"));
//! let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
//! assert_eq!(names, ["signals", "curves", "everyday", "plausibility"]);
//! ```

mod curves;
mod effects;
mod everyday;
mod figures;
mod limits;
mod plausibility;
mod population;
mod results;
mod scene;
mod signals;
mod study;

use std::process::ExitCode;

use clap::Subcommand;
use frame::{Command, Entry};
use report::results::Schema;
use supervise::Error;

use curves::Curves;
use everyday::Everyday;
use plausibility::Plausibility;
use signals::Signals;
pub use study::PopulationArguments;

/// The studies, for `merge` and `resume`.
pub const STUDIES: [Entry; 4] = [
    Entry::of::<study::Test<Signals>>(),
    Entry::of::<study::Test<Curves>>(),
    Entry::of::<study::Test<Everyday>>(),
    Entry::of::<study::Test<Plausibility>>(),
];

/// The populations by name.
#[derive(Debug, Subcommand)]
pub enum PopulationCommand {
    /// Corridors of signals: cacc-mpc against an ACC that stops for them
    Signals(Command<PopulationArguments>),
    /// Random curved roads, and curve entries and exits with queues beside and in the lane
    Curves(Command<PopulationArguments>),
    /// Everyday scenes: contacts that brakes avoid, and interventions of the emergency brake that nothing needed
    Everyday(Command<PopulationArguments>),
    /// How often and how fast the checks of the inputs find a false sender
    Plausibility(Command<PopulationArguments>),
}

pub fn run(command: &PopulationCommand) -> Result<ExitCode, Error> {
    match command {
        PopulationCommand::Signals(command) => drive_all::<Signals>(command),
        PopulationCommand::Curves(command) => drive_all::<Curves>(command),
        PopulationCommand::Everyday(command) => drive_all::<Everyday>(command),
        PopulationCommand::Plausibility(command) => drive_all::<Plausibility>(command),
    }
}

fn drive_all<P: population::Population>(
    command: &Command<PopulationArguments>,
) -> Result<ExitCode, Error> {
    let Some(table) = &command.study.effects else { return frame::run::<study::Test<P>>(command) };
    effects::print::<P>(&mut study::Test::of(&command.study)?, table, &command.options.group)?;
    Ok(ExitCode::SUCCESS)
}

/// Contents of the JSON of all populations.
pub fn schemas() -> [Schema; 4] {
    [
        results::schema::<Signals>(),
        results::schema::<Curves>(),
        results::schema::<Everyday>(),
        results::schema::<Plausibility>(),
    ]
}
