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

#[cfg(feature = "count-allocations")]
mod allocations;
mod bridge;
mod cli;
mod inject;
mod lead;
mod list;
mod live;
mod recordings;
mod reference;
mod rsu;
mod run;
mod service;
mod trace;

use clap::CommandFactory;
use cli::{Cli, Command, PrintCommand, RecordingCommand, TestCommand};
use report::print::note;
use runtime::log_warnings;
use rustix::process::{Resource, getrlimit};
use std::process::ExitCode;
use supervise::{Error, Status};

/// Least stack, bytes. The system's limit applies to the first thread only.
const STACK: u64 = 1 << 20;

fn main() -> ExitCode {
    #[cfg(feature = "count-allocations")]
    allocations::report();
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
    let command = Cli::read().command;
    if !matches!(command, Command::Service(_)) {
        log_warnings();
    }
    let result = match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Inject(arguments) => inject::run(&arguments),
        Command::Bridge(arguments) => bridge::run(&arguments),
        Command::Rsu(arguments) => rsu::run(&arguments),
        Command::Compare(arguments) => grid::compare::run(&arguments),
        Command::Sweep(arguments) => grid::sweep::run(&arguments),
        Command::String(arguments) => string::run(&arguments),
        Command::Search(arguments) => search::run(&arguments),
        Command::Campaign(arguments) => campaign::run(&arguments),
        Command::Test(TestCommand::R157(arguments)) => standards::r157::run(&arguments),
        Command::Test(TestCommand::Iso15622(arguments)) => standards::iso15622::run(&arguments),
        Command::Test(TestCommand::Population(command)) => populations::run(&command),
        Command::Papers(arguments) => papers::run(&arguments),
        Command::Merge(arguments) => frame::merge(&arguments, &studies()),
        Command::Resume(arguments) => frame::resume(&arguments, &studies()),
        Command::Recording(command) => recording(&command),
        Command::Bench(arguments) => match &arguments.graph {
            Some(file) => graph::run(file, &arguments),
            None => bench::run(&arguments),
        },
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::ExportFmu(arguments) => fmi_unit::run(&arguments),
        Command::List(arguments) => list::run(&arguments, &Cli::command()),
        Command::Print(PrintCommand::Schema(arguments)) => list::print_schema(&arguments),
        Command::Print(PrintCommand::Layouts(arguments)) => recordings::layouts::run(&arguments),
        Command::Print(PrintCommand::Generated(what)) => list::generate(&what, Cli::command()),
        Command::Service(arguments) => service::run(&arguments),
    };
    result.unwrap_or_else(|error| {
        match &error {
            // It has its own heading, with the place.
            Error::Scenario(error) => note(&error.to_string()),
            Error::OpenScenario(error) => note(&error.to_string()),
            error => note(&format!("error: {error}")),
        }
        if std::env::var_os("TIMEGAP_LOG").is_some() {
            note(&format!("{error:?}"));
        }
        error.exit_code()
    })
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

/// All studies, for `merge` and `resume`.
fn studies() -> Vec<frame::Entry> {
    let one = [
        papers::ENTRY,
        grid::compare::ENTRY,
        grid::sweep::ENTRY,
        standards::r157::ENTRY,
        standards::iso15622::ENTRY,
        string::ENTRY,
        campaign::ENTRY,
    ];
    [&one[..], &populations::STUDIES, &search::STUDIES].concat()
}

/// Turns a write beyond the limit on file sizes (`ulimit -f`) from the end of the process into an error.
fn file_size_limit_is_an_error() {
    let passed = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    // Fails only on a kernel without the signal, where the process ends as before.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, passed);
}
