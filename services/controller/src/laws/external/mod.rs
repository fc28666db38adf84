//! A law in any language (`external`): a program of the user's, which this process hosts.
//!
//! [`runtime::hosted`] hosts it. Questions and answers are [`messages::LawInput`] and [`messages::LawAnswer`];
//! `timegap print layouts --law` prints them for Python and C. Standard error is for what a person is to read.
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
//!
//! A unit of the Functional Mock-up Interface in a program's place is run by a process of timegap's own ([`fmi`]).

mod asked;
mod backup;
mod idle;
mod law;
mod record;

pub use asked::{Asked, Questions};
pub use law::External;

use super::cacc::config::Config;
use super::cacc::{self, Signals};
use crate::law::key;
use crate::law::settings::{self, Table};
use crate::law::{Descriptor, Figure, Formulation, GapPolicy, Law, Reader};
use backup::Backup;
use record::Bounds;
use runtime::hosted::Plan;
use runtime::{Program, ProgramError, executable};
use scenario::{Problem, Scenario};
use std::path::PathBuf;
use std::time::Duration;

const TABLE: Table = Table::of::<Settings>("external");

crate::law::settings! {
    /// Settings of the law `external`.
    pub struct Settings {
        /// Time that the program has for its first answer, and in simulated time for each, s.
        patience_s: f64 = 8.0, "s", 0.1..=600.0, "Chosen.";
        /// Time without an answer after which a program is replaced in real time, s.
        silence_s: f64 = 0.5, "s", 0.01..=600.0, "Chosen.";
    }
}

impl settings::Settings for Settings {}

/// The law as data.
pub static EXTERNAL: Descriptor = Descriptor {
    name: "external",
    description: "a program of your own, in any language (controller.command)",
    source: "docs/tutorial.md",
    table: Some(TABLE),
    formulations: &[&FORMULATION],
    formulation: |_| &FORMULATION,
    gap: GapPolicy::Internal,
    measured_target: false,
    trucks_alone: false,
    build,
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

/// The descriptor of the scenario's law, where that is one of the user's own.
pub(super) fn named(scenario: &Scenario) -> Option<&'static Descriptor> {
    scenario.laws.contains_key(scenario.controller.name.as_str()).then_some(&EXTERNAL)
}

/// The program of a scenario's law, with its digest.
///
/// # Errors
/// Names the key when the command names no program.
pub fn program(scenario: &Scenario) -> Result<Program, Problem> {
    let controller = &scenario.controller;
    let name = controller.name.as_str();
    let (path, words, directory) = match scenario.laws.get(name) {
        Some(law) if law.caller => {
            let message =
                format!("the law `{name}` is a function of the program that starts the run");
            return Err(Problem::new(format!("laws.{name}.caller"), message, "a command"));
        }
        Some(law) => (format!("laws.{name}.command"), law.words(), &law.directory),
        None => ("controller.command".into(), controller.command.clone(), &controller.directory),
    };
    let directory = directory.clone().unwrap_or_default();
    Program::of(&words, &directory).map_err(|error| refused(&path, &words, error))
}

fn refused(path: &str, command: &[String], error: ProgramError) -> Problem {
    match command.first().is_none_or(String::is_empty) {
        true => Problem::new(
            path,
            "the law `external` has no program",
            format!("{path}, such as [\"python3\", \"law.py\"]"),
        ),
        false => Problem::new(path, error.message, error.expected),
    }
}

/// The law of the user's that the scenario names, whatever it consists of.
fn build(reader: &Reader<'_>) -> Result<Box<dyn Law>, Problem> {
    let scenario = reader.scenario;
    let name = scenario.controller.name.as_str();
    let bounds = Bounds {
        least_mps2: key!(reader, min_request_mps2).value(),
        most_mps2: key!(reader, max_request_mps2).value(),
    };
    match scenario.laws.get(name) {
        None => {
            let words = key!(reader, command);
            let directory = key!(reader, directory);
            program_law(reader, "controller.command", words, Vec::new(), directory, bounds)
        }
        Some(law) if law.caller => Ok(Box::new(Asked::new(Questions::default(), None, scenario))),
        Some(law) => {
            let path = format!("laws.{name}.command");
            let directory = law.directory.clone();
            program_law(reader, &path, law.words(), law.variables(), directory, bounds)
        }
    }
}

/// A law that a program computes; `path` is the key of its command.
fn program_law(
    reader: &Reader<'_>,
    path: &str,
    command: Vec<String>,
    variables: Vec<(String, String)>,
    directory: Option<PathBuf>,
    bounds: Bounds,
) -> Result<Box<dyn Law>, Problem> {
    let settings: Settings = reader.table(TABLE.name)?;
    let directory = directory.unwrap_or_default();
    let file = executable(&command, &directory).map_err(|error| refused(path, &command, error))?;
    if fmi::is_unit(&command[0]) {
        fmi::check_law(&file, &command[1..]).map_err(|error| {
            Problem::new(path, format!("{}: {}", error.place, error.fault), error.expected)
        })?;
    }
    let plan = Plan {
        part: "law",
        command,
        variables,
        directory,
        patience: Duration::from_secs_f64(settings.patience_s),
        silence: Duration::from_secs_f64(settings.silence_s),
        supervision: reader.scenario.supervision.clone(),
    };
    Ok(Box::new(External::new(plan, bounds, backup(reader)?)))
}

/// The road controller that takes over.
fn backup(reader: &Reader<'_>) -> Result<Backup, Problem> {
    let of_backup = Reader::new(reader.scenario);
    let config = Config::of_road(&of_backup)?;
    reader.keep_backup(of_backup);
    let law = cacc::build(Signals::Used, &config)
        .map_err(|error| Problem::new("controller", error.to_string(), "settings of a backup"))?;
    Ok(Backup::new(law))
}
