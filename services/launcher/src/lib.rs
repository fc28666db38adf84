//! The `timegap` command: an adaptive-cruise stack as real processes over shared memory.

mod batch;
mod bench;
mod campaign;
mod cli;
mod compare;
mod doctor;
mod error;
mod group;
mod inject;
mod list;
mod live;
mod output;
mod print;
mod recordings;
mod report;
mod reproduce;
mod run;
mod summary;
mod sweep;
mod synthesize;
mod trace;
mod trajectory;

use clap::Parser;
use cli::{Cli, Command, ServiceArguments};
use error::Error;
use shared::Service;
use shared::runtime::{log_warnings, run_service};
use std::path::Path;
use std::process::ExitCode;

/// The command, from its arguments to its exit status.
#[must_use]
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    if !matches!(command, Command::Service(_)) {
        log_warnings();
    }
    let result = match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Trace(arguments) => trace::run(&arguments),
        Command::Campaign(arguments) => campaign::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Info(arguments) => recordings::info::run(&arguments),
        Command::Recover(arguments) => recordings::recover::run(&arguments),
        Command::Export(arguments) => recordings::export::run(&arguments),
        Command::Replay(arguments) => recordings::replay::run(&arguments),
        Command::Diff(arguments) => recordings::diff::run(&arguments),
        Command::Layouts(arguments) => recordings::layouts::run(&arguments),
        Command::Synthesize(arguments) => synthesize::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Inject(arguments) => inject::run(&arguments),
        Command::List(arguments) => list::run(&arguments),
        Command::Service(arguments) => service(&arguments),
    };
    result.unwrap_or_else(|error| {
        let text = error.to_string();
        // A scenario's error brings its own heading, with the place.
        let heading = if text.starts_with("error") { "" } else { "error: " };
        eprintln!("{heading}{text}");
        error.exit_code()
    })
}

/// Becomes one of the group's processes.
fn service(arguments: &ServiceArguments) -> Result<ExitCode, Error> {
    if arguments.name == "janitor" {
        return match arguments.arguments.as_slice() {
            [root] => Ok(group::run_janitor(Path::new(root))),
            _ => Err(Error::Usage("the janitor needs the root of a run".into())),
        };
    }
    if arguments.name == "bench" {
        return match arguments.arguments.as_slice() {
            [root, job] => bench::run_peer(Path::new(root), job),
            _ => Err(Error::Usage("a process of `timegap bench` needs its root and job".into())),
        };
    }
    if arguments.name == "hog" {
        return match arguments.arguments.as_slice() {
            [_, what, number] if number.parse::<usize>().is_ok() => {
                Ok(group::run_hog(what, number.parse().expect("checked")))
            }
            _ => Err(Error::Usage("the hog needs the root of a run, what and how much".into())),
        };
    }
    if arguments.name == "recorder" {
        return Ok(recorder::run(&arguments.arguments));
    }
    if arguments.name == "replayer" {
        return Ok(recorder::replay(&arguments.arguments));
    }
    let service: Service = arguments.name.parse().map_err(Error::Usage)?;
    let run = match service {
        Service::Plant => plant::run,
        Service::PerceptionSim => perception_sim::run,
        Service::V2xSim => v2x_sim::run,
        Service::Controller => controller::run,
    };
    Ok(run_service(service, &arguments.arguments, run))
}
