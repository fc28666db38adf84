//! `timegap inject`: inject a fault into a run in progress.

mod options;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use messages::{Service, Topic};
use options::FaultOptions;
use report::print;
use runtime::Group;
use scenario::Problem;
use scenario::faults::{self, Fault, Helper, Kind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::{Error, Status, UsageError, control};

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

pub fn run(arguments: &InjectArguments) -> Result<ExitCode, Error> {
    let fault = fault(arguments)?;
    let root = root(&arguments.run)?;
    let answer = control::inject(&root, &fault)
        .map_err(|why| UsageError::at(arguments.run.display(), why, "a run in progress"))?;
    if arguments.json {
        print::out(&(serde_json::to_string(&answer).expect("plain data") + "\n"))?;
    } else if answer.ok {
        print::out(&format!("{}\n", answer.message))?;
    } else {
        print::note(&format!("error: {}", answer.message));
    }
    Ok(if answer.ok { ExitCode::SUCCESS } else { ExitCode::from(Status::Usage as u8) })
}

/// The root of the run whose results are in `results`.
fn root(results: &Path) -> Result<PathBuf, UsageError> {
    let path = results.join("live.json");
    let text = std::fs::read_to_string(&path).map_err(|why| {
        let why = format!("holds no run in progress ({}: {why})", path.display());
        UsageError::at(results.display(), why, "the results of a run in progress")
    })?;
    let group: Result<Group, _> = serde_json::from_str(&text);
    Ok(group.map_err(|why| UsageError::at(path.display(), why, "a run's file"))?.root)
}

/// The fault that the options describe: keys of a fault in a file under other names.
fn fault(arguments: &InjectArguments) -> Result<Fault, UsageError> {
    if let Some(target) = &arguments.target
        && is_helper(target)
        && arguments.kind != Kind::KillHelper
    {
        let expected = format!("`kill-helper {target}`");
        return Err(UsageError::at(target, "neither a service nor a topic", expected));
    }
    let mut table = arguments.options.keys.clone();
    table.insert("kind".to_owned(), arguments.kind.name().into());
    if let Some(target) = &arguments.target {
        table.insert(key_of(target)?.to_owned(), target.as_str().into());
    }
    faults::read(table).map_err(in_options)
}

/// The error of a fault, in terms of the options.
fn in_options(problem: Problem) -> UsageError {
    let option = match problem.path.strip_prefix("fault.") {
        None => "the fault".to_owned(),
        Some("service" | "topic" | "helper") => "the target".to_owned(),
        Some(key) => format!("--{}", options::name(key)),
    };
    UsageError::at(option, problem.message, problem.expected)
}

fn key_of(target: &str) -> Result<&'static str, UsageError> {
    match (target.parse::<Service>(), Topic::by_name(target)) {
        (Ok(_), _) => Ok("service"),
        (Err(_), Some(_)) => Ok("topic"),
        _ if is_helper(target) => Ok("helper"),
        (Err(unknown), None) => {
            Err(UsageError::at("the target", unknown, "a service, or a topic such as radar/tracks"))
        }
    }
}

/// True for the name of a process that is not a service.
fn is_helper(target: &str) -> bool {
    Helper::ALL.into_iter().any(|helper| helper.name() == target)
}
