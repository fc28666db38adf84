//! The command line.

use crate::recordings::diff::DiffArguments;
use crate::recordings::export::ExportArguments;
use crate::recordings::info::InfoArguments;
use crate::recordings::layouts::LayoutsArguments;
use crate::recordings::recover::RecoverArguments;
use crate::recordings::replay::ReplayArguments;
use crate::trace::TraceArguments;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};

/// Runs an adaptive-cruise stack as processes over shared memory, measures it, and injects faults.
#[derive(Debug, Parser)]
#[command(name = "timegap", version, after_help = EXIT_STATUS, disable_help_subcommand = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_STATUS: &str = "Exit status: 0 all well; 1 the run broke a requirement (a collision, a \
red light, a failed check); 2 bad usage or a bad file; 3 the machine would not let it run; \
130 interrupted.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the process group through a scenario
    Run(crate::run::RunArguments),
    /// Run the roadside units of a scenario alone, for vehicles on other hosts
    Rsu(crate::rsu::RsuArguments),
    /// Run a paper's scenarios in lockstep and print its published figures beside ours
    Reproduce(campaign::reproduce::ReproduceArguments),
    /// Measure latency, jitter and deadline misses beside the machine's own floor
    Bench(bench::BenchArguments),
    /// Drive the same scenarios with several controllers and compare them
    Compare(campaign::compare::CompareArguments),
    /// Drive UN R157's cut-in, following and cut-out matrices with its models and our controllers
    R157(campaign::r157::R157Arguments),
    /// Run ISO 15622's tests of adaptive cruise control and print their limits as rows
    Iso15622(campaign::iso15622::Iso15622Arguments),
    /// Convert a recorded run to a trace for Perfetto
    Trace(TraceArguments),
    /// Drive many seeded runs with faults and give one verdict
    Campaign(campaign::campaign::CampaignArguments),
    /// Drive a string of cars, each behind the true motion of the one before, and print the gains
    String(campaign::string::StringArguments),
    /// Drive a scenario for all values of a key and print a figure of each
    Sweep(campaign::sweep::SweepArguments),
    /// Show what a recording holds
    Info(InfoArguments),
    /// Repair a truncated recording
    Recover(RecoverArguments),
    /// Write a recording as tables
    Export(ExportArguments),
    /// Feed a recorded run's inputs to the controller or the on-board unit again and compare its output
    Replay(ReplayArguments),
    /// Show the first difference between two recordings
    Diff(DiffArguments),
    /// Print the messages' layouts for Python or C
    Layouts(LayoutsArguments),
    /// Design a controller offline (cargo feature `synthesize`)
    Synthesize(crate::synthesize::SynthesizeArguments),
    /// Check whether this machine meets real time, and print how to mend what it lacks
    Doctor(doctor::DoctorArguments),
    /// Inject a fault into a run in progress
    Inject(crate::inject::InjectArguments),
    /// List the scenarios, controllers and campaigns
    List(crate::list::ListArguments),
    /// Write shell completions, the man page or a page of the documentation on standard output
    #[command(hide = true)]
    Generate(crate::generate::GenerateArguments),
    /// Run one service; started by the launcher
    #[command(hide = true)]
    Service(crate::service::ServiceArguments),
}

impl Cli {
    /// Reads the command line. Help and errors end the process, worded by clap.
    pub fn read() -> Self {
        Self::try_parse().unwrap_or_else(|error| suggest(error).exit())
    }
}

/// Adds the nearest commands to the error about an unknown one. clap's own measure of likeness knows no
/// transposed letters in words as short as ours.
fn suggest(mut error: clap::Error) -> clap::Error {
    let given = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(given)) if error.kind() == ErrorKind::InvalidSubcommand => given,
        _ => return error,
    };
    let near = nearest(given);
    if !near.is_empty() {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(near));
    }
    error
}

/// The commands that are likest to `given`, if they are like enough to be meant.
fn nearest(given: &str) -> Vec<String> {
    let command = Cli::command();
    let names = command.get_subcommands().filter(|command| !command.is_hide_set());
    let distance = |name: &str| strsim::osa_distance(given, name);
    let names: Vec<&str> = names.map(|command| command.get_name()).collect();
    let least = names.iter().map(|name| distance(name)).min();
    let least = least.filter(|least| *least <= 1 + given.chars().count() / 4);
    let near = names.into_iter().filter(|name| Some(distance(name)) == least);
    near.map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_understood() {
        for (given, meant) in
            [("rnu", "run"), ("lsit", "list"), ("benhc", "bench"), ("doctr", "doctor")]
        {
            let error = Cli::try_parse_from(["timegap", given]).expect_err("no such command");
            let text = suggest(error).to_string();
            assert!(text.contains(&format!("'{meant}'")), "{given}: {text}");
        }
        assert_eq!(nearest("xyzzy"), Vec::<String>::new());
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
