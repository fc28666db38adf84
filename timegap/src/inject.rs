//! `timegap inject`: inject a fault into a run in progress.

mod options;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use group::{Error, Failure, control};
use messages::{Service, Topic, UnknownService};
use options::FaultOptions;
use report::print;
use runtime::Group;
use scenario::Problem;
use scenario::faults::{self, Fault, Helper, Kind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use toml::Value;

/// Arguments of `inject`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct InjectArguments {
    /// Results directory of the run
    pub run: PathBuf,
    /// Kind of the fault
    #[arg(value_parser = kind())]
    pub kind: Kind,
    /// Target: a service or a topic; for `kill-helper` recorder, janitor or launcher
    pub target: Option<String>,
    #[command(flatten)]
    options: FaultOptions,
    /// Print the answer as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Reads the name of a kind.
fn kind() -> impl TypedValueParser<Value = Kind> {
    let of = |name: String| Kind::ALL.into_iter().find(|kind| kind.name() == name);
    PossibleValuesParser::new(Kind::ALL.map(Kind::name))
        .map(move |name| of(name).expect("the parser takes no other"))
}

const EXAMPLES: &str = "Examples:
  timegap inject runs/20261121-120000-following kill controller
  timegap inject RUN stop perception-sim --for 0.2
  timegap inject RUN drop v2x/spat --for 5 --probability 0.5
  timegap inject RUN bias radar/tracks --field gap_m --amount 10 --for 3";

/// Reason why a fault was not injected.
#[derive(Debug, thiserror::Error)]
pub enum InjectError {
    /// The target is neither a service nor a topic.
    #[error("{0}, or a topic such as radar/tracks")]
    Target(#[source] UnknownService),
    /// The target is a helper of the group, and the kind of the fault acts on something else.
    #[error("{0} is neither a service nor a topic, expected `kill-helper {0}`")]
    Helper(String),
    /// The options describe no valid fault.
    #[error("{}", in_options(.0))]
    Fault(#[source] Problem),
    /// The directory has no run in progress.
    #[error("{} holds no run in progress ({}: {reason})", results.display(), path.display())]
    NoRun {
        results: PathBuf,
        /// The file that states how to join.
        path: PathBuf,
        /// Reason why it is not readable.
        #[source]
        reason: std::io::Error,
    },
    /// The file that states how to join is not valid.
    #[error("{}: {reason}", path.display())]
    LiveFile {
        path: PathBuf,
        #[source]
        reason: serde_json::Error,
    },
    /// The run does not answer.
    #[error("{} is not in progress: {reason}", run.display())]
    Over {
        run: PathBuf,
        /// The system's error.
        #[source]
        reason: std::io::Error,
    },
    /// The run refused the fault, with this message.
    #[error("{0}")]
    Refused(String),
}

impl Failure for InjectError {}

pub fn run(arguments: &InjectArguments) -> Result<ExitCode, Error> {
    let fault = fault(arguments)?;
    let root = root(&arguments.run)?;
    let answer = control::inject(&root, &fault)
        .map_err(|reason| InjectError::Over { run: arguments.run.clone(), reason })?;
    if arguments.json {
        print::out(&(serde_json::to_string(&answer).expect("plain data") + "\n"))?;
    } else if answer.ok {
        print::out(&format!("{}\n", answer.message))?;
    }
    if answer.ok {
        Ok(ExitCode::SUCCESS)
    } else if arguments.json {
        Ok(ExitCode::from(2))
    } else {
        Err(InjectError::Refused(answer.message).into())
    }
}

/// The root of the run whose results are in `results`.
fn root(results: &Path) -> Result<PathBuf, InjectError> {
    let path = results.join("live.json");
    match std::fs::read_to_string(&path) {
        Ok(text) => match serde_json::from_str::<Group>(&text) {
            Ok(group) => Ok(group.root),
            Err(reason) => Err(InjectError::LiveFile { path, reason }),
        },
        Err(reason) => Err(InjectError::NoRun { results: results.to_owned(), path, reason }),
    }
}

/// The fault that the options describe: keys of a fault in a file under other names.
fn fault(arguments: &InjectArguments) -> Result<Fault, InjectError> {
    if let Some(target) = &arguments.target
        && is_helper(target)
        && arguments.kind != Kind::KillHelper
    {
        return Err(InjectError::Helper(target.clone()));
    }
    let target = match &arguments.target {
        None => None,
        Some(target) => Some((key_of(target)?, Value::from(target.as_str()))),
    };
    let kind = ("kind".to_owned(), Value::from(arguments.kind.name()));
    let target = target.map(|(key, value)| (key.to_owned(), value));
    let mut table = arguments.options.keys.clone();
    table.extend(std::iter::once(kind).chain(target));
    faults::read(table).map_err(InjectError::Fault)
}

/// The error of a fault, in terms of the options.
fn in_options(problem: &Problem) -> String {
    let option = match problem.path.strip_prefix("fault.") {
        None => return problem.message.clone(),
        Some("service" | "topic" | "helper") => "the target".to_owned(),
        Some(key) => format!("--{}", options::name(key)),
    };
    format!("{option}: {}, expected {}", problem.message, problem.expected)
}

fn key_of(target: &str) -> Result<&'static str, InjectError> {
    match (target.parse::<Service>(), Topic::by_name(target)) {
        (Ok(_), _) => Ok("service"),
        (Err(_), Some(_)) => Ok("topic"),
        _ if is_helper(target) => Ok("helper"),
        (Err(unknown), None) => Err(InjectError::Target(unknown)),
    }
}

/// True for the name of a process that is not a service.
fn is_helper(target: &str) -> bool {
    Helper::ALL.into_iter().any(|helper| helper.name() == target)
}
