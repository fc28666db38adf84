//! A law in any language (`external`): a program of the user's, which this process hosts.
//!
//! The program reads questions from its standard input and writes answers to its standard output. Both
//! are records of fixed layout ([`messages::LawInput`], [`messages::LawAnswer`]; `timegap layouts --law`
//! prints them for Python and C). It answers each question once, in order, with the question's sequence
//! number, and ends when its input does. Standard error is for what a person is to read.
//!
//! ```text
//!   control loop ── question ──► pipe ──► program
//!        ▲                                   │
//!        └──── answer, or the backup ◄─ pipe ┘        host thread: start, prove, replace, end
//! ```
//!
//! | | in real time | in simulated time |
//! | --- | --- | --- |
//! | no answer yet | the backup drives when nine tenths of the time to the deadline are over | waited for, at most `external.patience_s` |
//! | a wrong answer, the program ends | the backup drives, a new program is started within the supervisor's budget | the run ends: status 1 |
//! | an answer that no vehicle can follow | the backup drives in this cycle | the same |
//!
//! A first answer that is wrong or does not come keeps the run from beginning, with status 2. The backup
//! is the road controller `cacc-mpc`, from its initial state each time that it takes over. The program
//! does not outlive this process, however that ends.

mod bounds;
mod channel;
mod host;
mod law;
mod process;
mod record;
mod settings;

pub use law::External;
pub use settings::Settings;

use super::cacc::config::Config;
use super::cacc::{self, Signals};
use crate::law::reader::key;
use crate::law::{Descriptor, Figure, Formulation, GapPolicy, Reader, TargetSource};
use crate::settings::Table;
use bounds::Bounds;
use process::Plan;
use runtime::{Program, ProgramError, executable};
use scenario::{Problem, Scenario};
use std::time::Duration;

const TABLE: Table = Table::of::<Settings>("external");

/// The law as data.
pub static EXTERNAL: Descriptor = Descriptor {
    name: "external",
    description: "a program of your own, in any language (controller.command)",
    source: "docs/tutorial.md",
    table: Some(TABLE),
    formulations: &[&FORMULATION],
    formulation: |_| &FORMULATION,
    gap: GapPolicy::Internal,
    target: TargetSource::Tracked,
    without_signals: None,
    build: |reader| Ok(Box::new(build(reader)?)),
};

static FORMULATION: Formulation = Formulation {
    name: "program",
    caution: None,
    modes: &[
        "mode-0", "mode-1", "mode-2", "mode-3", "mode-4", "mode-5", "mode-6", "mode-7", "backup",
    ],
    reasons: &["answered", "late", "no-program", "refused"],
    figures: &[
        Figure::new("figure_0", "1"),
        Figure::new("figure_1", "1"),
        Figure::new("figure_2", "1"),
        Figure::new("figure_3", "1"),
        Figure::new("figure_4", "1"),
        Figure::new("figure_5", "1"),
        Figure::new("figure_6", "1"),
        Figure::new("figure_7", "1"),
    ],
};

/// The program of a scenario's command, with its digest.
///
/// # Errors
/// Names the key when the command names no program.
pub fn program(scenario: &Scenario) -> Result<Program, Problem> {
    let controller = &scenario.controller;
    let directory = controller.directory.clone().unwrap_or_default();
    Program::of(&controller.command, &directory).map_err(|error| refused(&error))
}

fn refused(error: &ProgramError) -> Problem {
    match error {
        ProgramError::Empty => Problem::new(
            "controller.command",
            "the law `external` has no program",
            "controller.command, such as [\"python3\", \"law.py\"]",
        ),
        error => Problem::said("controller.command", &error.to_string()),
    }
}

fn build(reader: &Reader<'_>) -> Result<External, Problem> {
    let settings: Settings = reader.table(TABLE.name)?;
    let command = key!(reader, command);
    let directory = key!(reader, directory).unwrap_or_default();
    executable(&command, &directory).map_err(|error| refused(&error))?;
    let of_backup = reader.of_backup();
    let config = Config::of_road(&of_backup)?;
    reader.keep_backup(of_backup);
    let backup = cacc::build(Signals::Used, &config)
        .map_err(|error| Problem::new("controller", error.to_string(), "settings of a backup"))?;
    let bounds = Bounds {
        least_mps2: key!(reader, min_request_mps2).value(),
        most_mps2: key!(reader, max_request_mps2).value(),
    };
    let plan = Plan {
        command,
        directory,
        patience: Duration::from_secs_f64(settings.patience_s),
        supervision: reader.scenario().supervision,
    };
    let silence = Duration::from_secs_f64(settings.silence_s);
    Ok(External::new(plan, silence, bounds, backup))
}
