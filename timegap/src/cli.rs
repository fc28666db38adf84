//! The command line.

use crate::recordings::diff::DiffArguments;
use crate::recordings::export::ExportArguments;
use crate::recordings::info::InfoArguments;
use crate::recordings::layouts::LayoutsArguments;
use crate::recordings::recover::RecoverArguments;
use crate::recordings::replay::ReplayArguments;
use crate::trace::TraceArguments;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::error::Error;
use std::ffi::OsString;
use std::num::{IntErrorKind, ParseIntError};

/// Runs an adaptive-cruise stack as real processes over shared memory, measures it, and injects faults.
#[derive(Debug, Parser)]
#[command(name = "timegap", version, after_help = EXIT_STATUS, disable_help_subcommand = true)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_STATUS: &str = "Exit status: 0 all well; 1 the run broke a requirement (a collision, a \
red light, a failed check); 2 bad usage or a bad file; 3 the machine would not let it run; \
130 interrupted.";

/// Names of `test` that `campaign` had in version 0.2.
const MOVED: [&str; 3] = ["signals", "curves", "plausibility"];

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the process group through a scenario
    Run(crate::run::RunArguments),
    /// Run a scenario's roadside units for vehicles on other hosts
    Rsu(crate::rsu::RsuArguments),
    /// Run a paper's scenarios and compare the results with its published figures
    Reproduce(frame::Command<papers::ReproduceArguments>),
    /// Measure latency, jitter and deadline misses against the machine's own floor
    Bench(bench::BenchArguments),
    /// Drive scenarios with several controllers and compare them
    Compare(frame::Command<grid::compare::CompareArguments>),
    /// Drive UN R157's cut-in, following and cut-out scenarios with our controllers and its models
    R157(frame::Command<standards::r157::R157Arguments>),
    /// Run ISO 15622's tests of adaptive cruise control
    Iso15622(frame::Command<standards::iso15622::Iso15622Arguments>),
    /// Convert a recorded run to a trace for Perfetto
    Trace(TraceArguments),
    /// Drive many seeded runs with faults and give one verdict
    Campaign(frame::Command<campaign::CampaignArguments>),
    /// Drive a population of random scenes and judge it by ground truth
    #[command(subcommand)]
    Test(populations::PopulationCommand),
    /// Drive a string of cars and print how it amplifies speed changes
    String(frame::Command<string::StringArguments>),
    /// Drive a scenario for several values of a key and print a figure of each
    Sweep(frame::Command<grid::sweep::SweepArguments>),
    /// Search the scenes and faults that break a requirement
    Search(Box<frame::Command<search::SearchArguments>>),
    /// Join the parts of a study
    Merge(frame::MergeArguments),
    /// Go on with a study that was interrupted
    Resume(frame::ResumeArguments),
    /// Show the contents of a recording
    Info(InfoArguments),
    /// Repair a truncated recording
    Recover(RecoverArguments),
    /// Write a recording as tables
    Export(ExportArguments),
    /// Replay a recorded run's inputs to a service and compare its output
    Replay(ReplayArguments),
    /// Show the first difference between two recordings
    Diff(DiffArguments),
    /// Print the messages' layouts for Python or C
    Layouts(LayoutsArguments),
    /// Check this machine for real time, and print commands that improve it
    Doctor(doctor::DoctorArguments),
    /// Inject a fault into a run in progress
    Inject(crate::inject::InjectArguments),
    /// Show a recorded motion of a vehicle as a scenario reads it
    Lead(crate::lead::LeadArguments),
    /// List scenarios, controllers and campaigns
    List(crate::list::ListArguments),
    /// Write shell completions, the man page or a reference page
    Generate(crate::generate::GenerateArguments),
    /// Run one service; used by the launcher
    #[command(hide = true)]
    Service(crate::service::ServiceArguments),
}

impl Cli {
    /// Reads the command line. Help and errors end the process, in clap's words.
    pub fn read() -> Self {
        let mut words: Vec<OsString> = std::env::args_os().collect();
        if let [_, campaign, name, ..] = words.as_mut_slice()
            && campaign == "campaign"
            && MOVED.iter().any(|moved| name == moved)
        {
            eprintln!("note: it is `timegap test {}` now", name.to_string_lossy());
            *campaign = "test".into();
        }
        Self::of(words).unwrap_or_else(|error| explain(error).exit())
    }

    /// A word such as `-1` is a value. It is refused as the value of its option, not as an option.
    fn of<T: Into<OsString> + Clone>(
        words: impl IntoIterator<Item = T>,
    ) -> Result<Self, clap::Error> {
        let command =
            Self::command().mut_subcommands(|command| command.allow_negative_numbers(true));
        Self::from_arg_matches(&command.try_get_matches_from(words)?)
    }
}

/// Adds the expected value where clap leaves it out.
fn explain(error: clap::Error) -> clap::Error {
    match error.kind() {
        ErrorKind::InvalidSubcommand => suggest(error),
        ErrorKind::ValueValidation => expect_a_number(error),
        _ => error,
    }
}

/// Adds that a whole number was expected.
fn expect_a_number(error: clap::Error) -> clap::Error {
    let reason = error.source().and_then(|reason| reason.downcast_ref::<ParseIntError>());
    let (Some(reason), Some(option), Some(value)) =
        (reason, error.get(ContextKind::InvalidArg), error.get(ContextKind::InvalidValue))
    else {
        return error;
    };
    let expected = match reason.kind() {
        IntErrorKind::Zero => "a whole number of 1 or more",
        IntErrorKind::PosOverflow => "a smaller whole number",
        _ => "a whole number without a sign",
    };
    // Without the usage line, which is about the whole program.
    let said = format!("invalid value '{value}' for '{option}': expected {expected}\n");
    clap::Error::raw(ErrorKind::ValueValidation, said)
}

/// Adds the nearest commands to the error about an unknown one. In short words clap's own measure misses transposed
/// letters.
fn suggest(mut error: clap::Error) -> clap::Error {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    let near = nearest(given);
    if !near.is_empty() {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(near));
    }
    error
}

/// The commands most similar to `given`, if one is similar enough.
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

    fn refusal(line: &str) -> String {
        let error = Cli::of(line.split(' ')).expect_err(line);
        assert_eq!(error.exit_code(), 2, "{line}");
        explain(error).to_string()
    }

    #[test]
    fn a_negative_number_is_refused_as_the_value_of_its_option() {
        for (line, option, expected) in [
            ("timegap campaign kills --seeds -1", "--seeds <N>", "without a sign"),
            ("timegap campaign kills --jobs 0", "--jobs <N>", "1 or more"),
            ("timegap r157 --seed 1e9", "--seed <S>", "without a sign"),
            ("timegap campaign kills --seeds 4294967296", "--seeds <N>", "a smaller whole number"),
        ] {
            let said = refusal(line);
            let says = format!("for '{option}': expected a");
            assert!(said.contains(&says) && said.contains(expected), "{said}");
        }
        assert!(Cli::of(["timegap", "run", "--seed", "-1"]).is_ok(), "the scenario checks it");
    }

    #[test]
    fn words_that_would_be_ignored_are_refused() {
        for (line, one, other) in [
            ("timegap layouts --law --msg x", "--law", "--msg <DIR>"),
            (
                "timegap sweep cacc-a --param a=1 --resume x --out y",
                "--resume <DIR>",
                "--out <DIR>",
            ),
            ("timegap compare cacc-a --resume x --keep all", "--keep <WHICH>", "--resume <DIR>"),
            ("timegap r157 --models-only --processes", "--models-only", "--processes"),
        ] {
            let said = refusal(line);
            let says = said.contains("cannot be used with") && said.contains(one);
            assert!(says && said.contains(other), "{line}: {said}");
        }
        for line in ["timegap merge x y --out z --force", "timegap resume x --jobs 2 --json"] {
            assert!(Cli::of(line.split(' ')).is_ok(), "{line}");
        }
        for (line, what) in [
            ("timegap merge x --seed 3", "unexpected argument '--seed'"),
            ("timegap resume x --out y", "--shard <I/N>"),
            ("timegap resume x --require comfort", "unexpected argument '--require'"),
        ] {
            assert!(refusal(line).contains(what), "{line}: {}", refusal(line));
        }
    }

    #[test]
    fn an_export_without_a_format_says_which_there_are() {
        assert!(refusal("timegap export x").contains("<--csv|--parquet|--pcap>"));
        assert!(Cli::of(["timegap", "export", "x", "--csv", "--pcap"]).is_ok());
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
