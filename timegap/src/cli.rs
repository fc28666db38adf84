//! The command line.

use crate::recordings::diff::DiffArguments;
use crate::recordings::export::ExportArguments;
use crate::recordings::info::InfoArguments;
use crate::recordings::recover::RecoverArguments;
use crate::recordings::replay::ReplayArguments;
use crate::studies;
use crate::trace::TraceArguments;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use scenario::ScenarioError;
use std::error::Error;
use std::ffi::OsString;
use std::num::{IntErrorKind, ParseIntError};

/// Runs an adaptive-cruise stack as real processes over shared memory, measures it, and injects faults.
#[derive(Debug, Parser)]
#[command(name = "timegap", version, after_help = EXIT_STATUS, disable_help_subcommand = true)]
#[command(
    help_template = "{about}\n\n{usage-heading} {usage}\n\n{before-help}Options:\n{options}{after-help}"
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_STATUS: &str = "Exit status: 0 all well; 1 the run broke a requirement (a collision, a \
red light, a failed check); 2 bad usage or a bad file; 3 the machine would not let it run; \
130 interrupted.";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run the process group through a scenario
    Run(Box<crate::run::RunArguments>),
    /// Inject a fault into a run in progress
    Inject(crate::inject::InjectArguments),
    /// Show a run in progress or a recording live in Foxglove
    Bridge(crate::bridge::BridgeArguments),
    /// Run a scenario's roadside units for vehicles on other hosts
    Rsu(crate::rsu::RsuArguments),
    /// Drive scenarios with several controllers and compare them
    Compare(studies::Compare),
    /// Drive a scenario for several values of its keys, and show the figures as functions of them
    Sweep(studies::Sweep),
    /// Drive a string of cars and print how it amplifies speed changes
    String(studies::String),
    /// Search the scenes and faults that break a requirement
    Search(studies::Search),
    /// Drive many seeded runs with faults and give one verdict
    Campaign(studies::Campaign),
    /// Drive a standard's tests, or a population of random scenes, and judge them
    Test(studies::Test),
    /// Run a paper's scenarios and compare the results with its published figures
    Papers(studies::Papers),
    /// Join the parts of a study
    Merge(studies::Merge),
    /// Go on with a study that was interrupted
    Resume(studies::Resume),
    /// Show, repair, export, replay or compare recordings
    #[command(subcommand)]
    Recording(RecordingCommand),
    /// Measure latency, jitter and deadline misses against the machine's own floor
    Bench(studies::Bench),
    /// Check this machine for real time, and print commands that improve it
    Doctor(doctor::DoctorArguments),
    /// Write a law as a unit of FMI 2.0, alone or in the loop of a deployment
    ExportFmu(studies::ExportFmu),
    /// List scenarios, controllers, campaigns and tests
    List(studies::List),
    /// Print schemas, layouts, references, completions or the man page
    Print(studies::Print),
    /// Run one service; used by the launcher
    #[command(hide = true)]
    Service(crate::service::ServiceArguments),
}

#[derive(Debug, Subcommand)]
pub enum RecordingCommand {
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
    /// Convert a recorded run to a trace for Perfetto
    Trace(TraceArguments),
    /// Show a recorded motion of a vehicle as a scenario reads it
    Lead(crate::lead::LeadArguments),
}

/// Commands by what they are for, as `--help` shows them.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Drive", &["run", "inject", "bridge", "rsu"]),
    ("Compare and search", &["compare", "sweep", "string", "search"]),
    ("Judge", &["campaign", "test", "papers", "merge", "resume"]),
    ("Recordings and this machine", &["recording", "bench", "doctor"]),
    ("Look up and hand on", &["list", "print", "export-fmu"]),
];

/// Names of version 0.2 and the present ones. Each works in this version, with a note.
const RENAMED: [(&[&str], &[&str]); 17] = [
    (&["reproduce"], &["papers"]),
    (&["r157"], &["test", "r157"]),
    (&["iso15622"], &["test", "iso15622"]),
    (&["campaign", "signals"], &["test", "signals"]),
    (&["campaign", "curves"], &["test", "curves"]),
    (&["campaign", "plausibility"], &["test", "plausibility"]),
    (&["info"], &["recording", "info"]),
    (&["recover"], &["recording", "recover"]),
    (&["export"], &["recording", "export"]),
    (&["replay"], &["recording", "replay"]),
    (&["diff"], &["recording", "diff"]),
    (&["trace"], &["recording", "trace"]),
    (&["lead"], &["recording", "lead"]),
    (&["layouts"], &["print", "layouts"]),
    (&["generate", "man"], &["print", "man"]),
    (&["generate"], &["print", "completions"]),
    (&["list", "--schema"], &["print", "schema"]),
];

/// Options of version 0.2 with their commands and the present names. Each works in this version, with a note.
const RENAMED_OPTIONS: [(&str, &str, &str); 8] = [
    ("sweep", "--param", "--vary"),
    ("string", "--param", "--vary"),
    ("search", "--seeds", "--trials"),
    ("test r157", "--csv", "--table"),
    ("recording lead", "--csv", "--table"),
    ("recording recover", "--out", "--file"),
    ("recording replay", "--out", "--file"),
    ("recording trace", "--out", "--file"),
];

/// Replaces old names of the command's options.
fn with_new_options(mut words: Vec<OsString>) -> (Vec<OsString>, Option<String>) {
    let mut note = None;
    for (command, old, new) in RENAMED_OPTIONS {
        let is_it = |(place, name)| words.get(1 + place).is_some_and(|word| word == name);
        if !command.split(' ').enumerate().all(is_it) {
            continue;
        }
        for word in &mut words {
            let rest = word.to_str().and_then(|word| word.strip_prefix(old));
            let Some(rest) = rest.filter(|rest| rest.is_empty() || rest.starts_with('=')) else {
                continue;
            };
            *word = format!("{new}{rest}").into();
            note = Some(format!("note: `{old}` of `timegap {command}` is `{new}` now"));
        }
    }
    (words, note)
}

/// Replaces an old name at the start of the words.
fn renamed(words: Vec<OsString>) -> (Vec<OsString>, Option<String>) {
    let begins =
        |old: &&[&str]| words.len() > old.len() && old.iter().zip(&words[1..]).all(|(a, b)| b == a);
    let Some((old, new)) = RENAMED.iter().find(|(old, _)| begins(old)) else {
        return (words, None);
    };
    let note = format!("note: `timegap {}` is `timegap {}` now", old.join(" "), new.join(" "));
    let rest = words[1 + old.len()..].iter().cloned();
    let words = words[..1].iter().cloned().chain(new.iter().map(OsString::from)).chain(rest);
    (words.collect(), Some(note))
}

fn groups(command: &clap::Command) -> String {
    let line = |name: &&str| {
        let about = command.find_subcommand(name).and_then(clap::Command::get_about);
        format!("  {name:<10} {}\n", about.map(ToString::to_string).unwrap_or_default())
    };
    let group = |(title, names): &(&str, &[&str])| {
        format!("{title}:\n{}", names.iter().map(line).collect::<String>())
    };
    GROUPS.map(|one| group(&one)).join("\n").trim_end().to_owned()
}

impl Cli {
    /// Reads the command line. Help and errors end the process, in clap's words.
    pub fn read() -> Result<Self, supervise::Error> {
        let (words, note) = renamed(std::env::args_os().collect());
        let (words, of_option) = with_new_options(words);
        note.iter().chain(&of_option).for_each(|note| eprintln!("{note}"));
        studies::hand_over(&words)?;
        Ok(Self::of(words).unwrap_or_else(|error| explain(error).exit()))
    }

    /// A word such as `-1` is a value. It is refused as the value of its option, not as an option.
    fn of<T: Into<OsString> + Clone>(
        words: impl IntoIterator<Item = T>,
    ) -> Result<Self, clap::Error> {
        let command = Self::command();
        let groups = groups(&command);
        let command = as_we_read(command).before_help(groups);
        Self::from_arg_matches(&command.try_get_matches_from(words)?)
    }
}

/// In all subcommands a word such as `-1` is a value, and `--help` has one line for each option.
fn as_we_read(command: clap::Command) -> clap::Command {
    let help = Arg::new("help").short('h').long("help").help("Print help");
    let command = command.disable_help_flag(true).arg(help.action(ArgAction::HelpShort));
    command.allow_negative_numbers(true).mut_subcommands(as_we_read)
}

/// Adds the expected value where clap leaves it out.
fn explain(error: clap::Error) -> clap::Error {
    match error.kind() {
        ErrorKind::InvalidSubcommand => suggest(error),
        ErrorKind::ValueValidation => show_place(error).unwrap_or_else(expect_a_number),
        _ => error,
    }
}

/// Shows the place in a setting that cannot be read.
fn show_place(error: clap::Error) -> Result<clap::Error, clap::Error> {
    let refusal = error.source().and_then(|reason| reason.downcast_ref::<ScenarioError>());
    let Some(said) = refusal.map(ToString::to_string) else { return Err(error) };
    let said = said.strip_prefix("error: ").unwrap_or(&said);
    Ok(clap::Error::raw(ErrorKind::ValueValidation, format!("{said}\n")))
}

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

/// The commands most similar to `given`, if one is similar enough. Those below another one are named with it.
fn nearest(given: &str) -> Vec<String> {
    let command = Cli::command();
    let visible = |command: &&clap::Command| !command.is_hide_set();
    let mut names: Vec<(&str, String)> = Vec::new();
    for one in command.get_subcommands().filter(visible) {
        names.push((one.get_name(), one.get_name().to_owned()));
        let below = one.get_subcommands().filter(visible);
        names.extend(
            below.map(|two| (two.get_name(), format!("{} {}", one.get_name(), two.get_name()))),
        );
    }
    let distance = |name: &str| strsim::osa_distance(given, name);
    let least = names.iter().map(|(name, _)| distance(name)).min();
    let least = least.filter(|least| *least <= 1 + given.chars().count() / 4);
    let near = names.into_iter().filter(|(name, _)| Some(distance(name)) == least);
    near.map(|(_, whole)| whole).collect()
}

#[cfg(all(test, feature = "studies"))]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_understood() {
        for (given, meant) in
            [("rnu", "run"), ("lsit", "list"), ("benhc", "bench"), ("inof", "recording info")]
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
            ("timegap test r157 --seed 1e9", "--seed <S>", "without a sign"),
            ("timegap campaign kills --seeds 4294967296", "--seeds <N>", "a smaller whole number"),
        ] {
            let said = refusal(line);
            let says = format!("for '{option}': expected a");
            assert!(said.contains(&says) && said.contains(expected), "{said}");
        }
        assert!(Cli::of(["timegap", "run", "--seed", "-1"]).is_ok(), "the scenario checks it");
    }

    #[test]
    fn a_setting_that_cannot_be_read_is_shown_with_its_place() {
        for (line, what) in [
            ("timegap run --set nonsense", "error: --set nonsense: no `=`"),
            ("timegap run --duration 30s", "error: --duration 30s: `30s` is not a number"),
            ("timegap sweep a --vary a=1 --seed 7x", "error: --seed 7x: `7x` is not a number"),
        ] {
            let said = refusal(line);
            assert!(said.starts_with(what) && said.contains("^ expected"), "{said}");
        }
    }

    #[test]
    fn words_that_would_be_ignored_are_refused() {
        for (line, one, other) in [
            ("timegap print layouts --law --msg x", "--law", "--msg <DIR>"),
            ("timegap sweep cacc-a --vary a=1 --resume x --out y", "--resume <DIR>", "--out <DIR>"),
            ("timegap compare cacc-a --resume x --keep all", "--keep <WHICH>", "--resume <DIR>"),
            ("timegap test r157 --models-only --processes", "--models-only", "--processes"),
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
        assert!(refusal("timegap recording export x").contains("<--csv|--parquet|--pcap>"));
        assert!(Cli::of(["timegap", "recording", "export", "x", "--csv", "--pcap"]).is_ok());
    }

    #[test]
    fn an_old_name_is_read_as_the_present_one() {
        let of = |line: &str| {
            let (words, note) = renamed(line.split(' ').map(OsString::from).collect());
            (words.join(&OsString::from(" ")).into_string().expect("text"), note.is_some())
        };
        for (old, new) in [
            ("timegap reproduce cacc --json", "timegap papers cacc --json"),
            ("timegap campaign signals --seeds 3", "timegap test signals --seeds 3"),
            ("timegap generate bash", "timegap print completions bash"),
            ("timegap list --schema results", "timegap print schema results"),
        ] {
            assert_eq!(of(old), (new.to_owned(), true));
        }
        for present in ["timegap campaign kills", "timegap list", "timegap papers"] {
            assert_eq!(of(present), (present.to_owned(), false));
        }
        for (_, new) in RENAMED {
            let words = ["timegap"].iter().chain(new).chain(&["--help"]);
            let help = Cli::of(words).expect_err("help ends the reading");
            assert_eq!(help.kind(), ErrorKind::DisplayHelp, "{new:?}");
        }
        let words = ["timegap", "sweep", "a", "--param=x=1", "--param", "y=2"].map(OsString::from);
        let (words, note) = with_new_options(words.to_vec());
        assert!(words[3] == "--vary=x=1" && words[4] == "--vary" && note.is_some(), "{words:?}");
        let words = ["timegap", "run", "a.xosc", "--param", "y=2"].map(OsString::from).to_vec();
        assert_eq!(with_new_options(words.clone()), (words, None));
    }

    #[test]
    fn every_command_stands_in_one_group_of_the_help() {
        let command = Cli::command();
        let mut visible: Vec<&str> = command
            .get_subcommands()
            .filter(|one| !one.is_hide_set())
            .map(clap::Command::get_name)
            .collect();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
        visible.sort_unstable();
        grouped.sort_unstable();
        assert_eq!(visible, grouped);
        let help = Cli::of(["timegap", "--help"]).expect_err("help ends the reading").to_string();
        assert!(help.contains("Judge:\n  campaign   Drive many seeded runs"), "{help}");
        assert!(!help.contains("\n\n\n"), "{help}");
    }

    #[test]
    fn a_help_page_fits_a_screen() {
        for line in
            ["run", "compare", "sweep", "string", "search", "campaign", "test r157", "bench"]
        {
            let words = ["timegap"].into_iter().chain(line.split(' ')).chain(["--help"]);
            let help = Cli::of(words).expect_err("help ends the reading").to_string();
            assert!(help.lines().count() <= 48, "{line}: {} lines", help.lines().count());
        }
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
