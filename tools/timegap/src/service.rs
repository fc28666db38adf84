//! `timegap service`: become one of the group's processes.

use clap::Args;
use group::{Error, Failure};
use messages::Service;
use runtime::run_service;
use std::path::Path;
use std::process::ExitCode;

/// Arguments of `service`.
#[derive(Debug, Args)]
pub struct ServiceArguments {
    /// Which one
    pub name: String,
    /// The service's own arguments
    pub arguments: Vec<String>,
}

/// A process that is no service, without its arguments.
#[derive(Debug, thiserror::Error)]
pub enum MissingArguments {
    /// Of the janitor.
    #[error("the janitor needs the root of a run")]
    Janitor,
    /// Of a process of the benchmark.
    #[error("a process of `timegap bench` needs its root and job")]
    Bench,
    /// Of the hog.
    #[error("the hog needs the root of a run, what and how much")]
    Hog,
}

impl Failure for MissingArguments {}

/// Becomes one of the group's processes.
pub fn run(arguments: &ServiceArguments) -> Result<ExitCode, Error> {
    if arguments.name == "janitor" {
        return match arguments.arguments.as_slice() {
            [root] => Ok(group::run_janitor(Path::new(root))),
            _ => Err(MissingArguments::Janitor.into()),
        };
    }
    if arguments.name == "bench" {
        return match arguments.arguments.as_slice() {
            [root, job] => bench::run_peer(Path::new(root), job),
            _ => Err(MissingArguments::Bench.into()),
        };
    }
    if arguments.name == "hog" {
        return match arguments.arguments.as_slice() {
            [_, what, number] if number.parse::<usize>().is_ok() => {
                Ok(group::run_hog(what, number.parse().expect("checked")))
            }
            _ => Err(MissingArguments::Hog.into()),
        };
    }
    if arguments.name == "recorder" {
        return Ok(recorder::run(&arguments.arguments));
    }
    if arguments.name == "replayer" {
        return Ok(recorder::replay(&arguments.arguments));
    }
    let service: Service = arguments.name.parse()?;
    Ok(run_service(service, &arguments.arguments, group::entry(service)))
}
