//! `timegap service`: runs one of the group's processes.

use clap::Args;
use group::{Error, Failure};
use messages::Service;
use runtime::run_service;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Arguments of `service`.
#[derive(Debug, Args)]
pub struct ServiceArguments {
    /// Name of the service
    pub name: String,
    /// Arguments of the service
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<OsString>,
}

/// Missing arguments of a process that is not a service.
#[derive(Debug, thiserror::Error)]
pub enum MissingArguments {
    #[error("the janitor needs the root of a run")]
    Janitor,
    /// Arguments of a process of the benchmark.
    #[error("a process of `timegap bench` needs its root and job")]
    Bench,
    #[error("`{0}` is not UTF-8 text")]
    NotText(String),
    #[error("the hog needs the root of a run, a resource and an amount")]
    Hog,
}

impl Failure for MissingArguments {}

/// Runs one of the group's processes.
pub fn run(arguments: &ServiceArguments) -> Result<ExitCode, Error> {
    if arguments.name == "recorder" {
        return Ok(recorder::run(&arguments.arguments));
    }
    if arguments.name == "replayer" {
        return Ok(recorder::replay(&arguments.arguments));
    }
    let texts = arguments.arguments.iter().map(|argument| {
        let text = || argument.to_string_lossy().into_owned();
        argument.to_str().map(str::to_owned).ok_or_else(|| MissingArguments::NotText(text()))
    });
    let texts = texts.collect::<Result<Vec<_>, _>>()?;
    if arguments.name == "janitor" {
        return match texts.as_slice() {
            [root] => Ok(group::run_janitor(Path::new(root))),
            _ => Err(MissingArguments::Janitor.into()),
        };
    }
    if arguments.name == "bench" {
        return match texts.as_slice() {
            [root, job] => bench::run_peer(Path::new(root), job),
            _ => Err(MissingArguments::Bench.into()),
        };
    }
    if arguments.name == "hog" {
        return match texts.as_slice() {
            [_, what, number] if number.parse::<usize>().is_ok() => {
                Ok(group::run_hog(what, number.parse().expect("checked")))
            }
            _ => Err(MissingArguments::Hog.into()),
        };
    }
    let service: Service = arguments.name.parse()?;
    Ok(run_service(service, &texts, group::entry(service)))
}
