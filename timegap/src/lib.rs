//! The `timegap` command: an adaptive-cruise stack as real processes over shared memory.
//!
//! # Where to start
//!
//! | to | read |
//! | --- | --- |
//! | use the command | `README.md`, `docs/tutorial.md`, `timegap --help` |
//! | write a law | [`controller::law::Law`], with an example; then [`controller::law::Descriptor`] and [`controller::laws`] |
//! | replace a service with your own program | [`runtime`], with an example; `examples/my_controller.rs` |
//! | know the messages | [`messages`], `docs/reference-messages.md` |
//! | know the scenario keys | [`scenario`], `docs/reference-scenario.md` |
//! | run a group from a program | [`supervise::in_process`], [`supervise`] |
//! | solve the problem of a predictive law | `mpc_solver`, with examples |
//! | change timegap | `ARCHITECTURE.md`, `CONTRIBUTING.md` |
//!
//! # Two programs
//!
//! `timegap` drives, injects faults, and reads recordings. The feature `studies` adds everything else. The program
//! `timegap-studies` has it, and `timegap` hands over to it. So the first build of a drive is short.

mod bridge;
mod cli;
mod inject;
mod lead;
mod live;
mod recordings;
mod rsu;
mod run;
mod service;
#[cfg_attr(feature = "studies", path = "studies/here.rs")]
#[cfg_attr(not(feature = "studies"), path = "studies/elsewhere.rs")]
mod studies;
mod trace;

use cli::{Cli, Command, RecordingCommand};
use report::print::note;
use runtime::log_warnings;
use rustix::process::{Resource, getrlimit};
use std::process::ExitCode;
use supervise::{Error, Status};

/// Least stack, bytes. The system's limit applies to the first thread only.
const STACK: u64 = 1 << 20;

/// Reads the command line and does what it says.
pub fn main() -> ExitCode {
    match getrlimit(Resource::Stack).current {
        Some(allowed) if allowed < STACK => {
            let (allowed, needed) = (allowed / 1024, STACK / 1024);
            note(&format!(
                "error: the stack may have {allowed} KiB and up to {needed} KiB are needed: raise the limit with \
                 `ulimit -s {needed}`"
            ));
            ExitCode::from(Status::Machine as u8)
        }
        _ => run_command(),
    }
}

/// Not inlined, so that `main` does not need its stack.
#[inline(never)]
fn run_command() -> ExitCode {
    file_size_limit_is_an_error();
    let result = Cli::read().and_then(|cli| run(cli.command));
    result.unwrap_or_else(|error| {
        match &error {
            // It has its own heading, with the place.
            Error::Scenario(error) => note(&error.to_string()),
            error => note(&format!("error: {error}")),
        }
        if std::env::var_os("TIMEGAP_LOG").is_some() {
            note(&format!("{error:?}"));
        }
        error.exit_code()
    })
}

fn run(command: Command) -> Result<ExitCode, Error> {
    if !matches!(command, Command::Service(_)) {
        log_warnings();
    }
    match command {
        Command::Run(arguments) => run::run(*arguments),
        Command::Inject(arguments) => inject::run(&arguments),
        Command::Bridge(arguments) => bridge::run(&arguments),
        Command::Rsu(arguments) => rsu::run(&arguments),
        Command::Recording(command) => recording(&command),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Service(arguments) => service::run(&arguments),
        study => studies::run(study),
    }
}

fn recording(command: &RecordingCommand) -> Result<ExitCode, Error> {
    match command {
        RecordingCommand::Info(arguments) => recordings::info::run(arguments),
        RecordingCommand::Recover(arguments) => recordings::recover::run(arguments),
        RecordingCommand::Export(arguments) => recordings::export::run(arguments),
        RecordingCommand::Replay(arguments) => recordings::replay::run(arguments),
        RecordingCommand::Diff(arguments) => recordings::diff::run(arguments),
        RecordingCommand::Trace(arguments) => trace::run(arguments),
        RecordingCommand::Lead(arguments) => lead::run(arguments),
    }
}

/// Turns a write beyond the limit on file sizes (`ulimit -f`) from the end of the process into an error.
fn file_size_limit_is_an_error() {
    let passed = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    // Fails only on a kernel without the signal, where the process ends as before.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, passed);
}
