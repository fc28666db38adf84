//! `timegap service`: runs one of the group's processes.

use crate::studies;
use clap::Args;
use messages::Service;
use runtime::run_service;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;
use supervise::{Error, UsageError};

#[derive(Debug, Args)]
pub struct ServiceArguments {
    /// Name of the service
    pub name: String,
    /// Arguments of the service
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<OsString>,
}

/// Runs one of the group's processes.
pub fn run(arguments: &ServiceArguments) -> Result<ExitCode, Error> {
    if arguments.name == "recorder" {
        return Ok(recorder::run(&arguments.arguments));
    }
    #[cfg(feature = "foxglove")]
    if arguments.name == "bridge" {
        return Ok(foxglove_bridge::run(&arguments.arguments));
    }
    #[cfg(feature = "ros2")]
    if arguments.name == "ros2-law" {
        return Ok(ros2_law::run(&arguments.arguments));
    }
    if arguments.name == "replayer" {
        return Ok(recorder::replay(&arguments.arguments));
    }
    let text = |argument: &OsString| {
        let not_text = || UsageError::at(argument.display(), "not UTF-8", "text");
        argument.to_str().map(str::to_owned).ok_or_else(not_text)
    };
    let texts = arguments.arguments.iter().map(text).collect::<Result<Vec<_>, _>>()?;
    let words: Vec<&str> = texts.iter().map(String::as_str).collect();
    if let Some(done) = studies::serve(&arguments.name, &words) {
        return done;
    }
    let expected = match (arguments.name.as_str(), texts.as_slice()) {
        ("fmu", texts) => return Ok(fmi::run(texts)),
        ("janitor", [root]) => return Ok(supervise::run_janitor(Path::new(root))),
        ("hog", [_, what, number]) if number.parse::<usize>().is_ok() => {
            return Ok(supervise::run_hog(what, number.parse().expect("checked")));
        }
        ("janitor", _) => "the root of a run",
        ("bench", _) => "its root and job",
        ("node", _) => "a node, the root of a run and a process of the node",
        ("hog", _) => "the root of a run, a resource and an amount",
        ("bridge" | "ros2-law", _) => "a program that was built with `--features bridge`",
        (name, _) => {
            let service: Service = name.parse()?;
            return Ok(run_service(service, &texts, supervise::entry(service)));
        }
    };
    Err(UsageError::at(&arguments.name, "other arguments", expected).into())
}
