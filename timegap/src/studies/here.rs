//! The studies, the bench, and what accompanies the command.

mod layouts;
mod list;
mod reference;

use crate::cli::{Cli, Command};
use clap::{Args, CommandFactory, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;
use supervise::Error;

pub type Compare = frame::Command<grid::compare::CompareArguments>;
pub type Sweep = frame::Command<grid::sweep::SweepArguments>;
pub type String = frame::Command<string::StringArguments>;
pub type Search = Box<frame::Command<search::SearchArguments>>;
pub type Campaign = frame::Command<campaign::CampaignArguments>;
pub type Papers = frame::Command<papers::ReproduceArguments>;
pub type Merge = frame::MergeArguments;
pub type Resume = frame::ResumeArguments;
pub type Bench = bench::BenchArguments;
pub type ExportFmu = fmi_unit::ExportArguments;
pub type List = list::ListArguments;

#[derive(Debug, Args)]
pub struct Test {
    #[command(subcommand)]
    test: TestCommand,
}

#[derive(Debug, Subcommand)]
enum TestCommand {
    /// UN R157's cut-in, following and cut-out scenarios, with our controllers and its models
    R157(frame::Command<standards::r157::R157Arguments>),
    /// ISO 15622's tests of adaptive cruise control
    Iso15622(frame::Command<standards::iso15622::Iso15622Arguments>),
    #[command(flatten)]
    Population(populations::PopulationCommand),
}

#[derive(Debug, Args)]
pub struct Print {
    #[command(subcommand)]
    what: PrintCommand,
}

#[derive(Debug, Subcommand)]
enum PrintCommand {
    /// JSON Schema of the scenario file, for editors, or of all results that `--json` prints
    Schema(list::SchemaArguments),
    /// The messages' layouts for Python or C
    Layouts(layouts::LayoutsArguments),
    #[command(flatten)]
    Generated(list::Generated),
}

/// Does the work of a word that only this program knows.
pub fn run(command: Command) -> Result<ExitCode, Error> {
    match command {
        Command::Compare(arguments) => grid::compare::run(&arguments),
        Command::Sweep(arguments) => grid::sweep::run(&arguments),
        Command::String(arguments) => string::run(&arguments),
        Command::Search(arguments) => search::run(&arguments),
        Command::Campaign(arguments) => campaign::run(&arguments),
        Command::Test(Test { test: TestCommand::R157(it) }) => standards::r157::run(&it),
        Command::Test(Test { test: TestCommand::Iso15622(it) }) => standards::iso15622::run(&it),
        Command::Test(Test { test: TestCommand::Population(it) }) => populations::run(&it),
        Command::Papers(arguments) => papers::run(&arguments),
        Command::Merge(arguments) => frame::merge(&arguments, &studies()),
        Command::Resume(arguments) => frame::resume(&arguments, &studies()),
        Command::Bench(arguments) => match &arguments.graph {
            Some(file) => graph::run(file, &arguments),
            None => bench::run(&arguments),
        },
        Command::ExportFmu(arguments) => fmi_unit::run(&arguments),
        Command::List(arguments) => list::run(&arguments, &Cli::command()),
        Command::Print(Print { what: PrintCommand::Schema(it) }) => list::print_schema(&it),
        Command::Print(Print { what: PrintCommand::Layouts(it) }) => layouts::run(&it),
        Command::Print(Print { what: PrintCommand::Generated(it) }) => {
            list::generate(&it, Cli::command())
        }
        command => unreachable!("{command:?} has its arm in both programs"),
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

/// This program knows every word.
pub fn hand_over(_: &[OsString]) -> Result<(), Error> {
    Ok(())
}

/// The processes that only studies and the bench start: their name and arguments.
pub fn serve(name: &str, arguments: &[&str]) -> Option<Result<ExitCode, Error>> {
    match (name, arguments) {
        ("unit", [resources]) => Some(Ok(fmi_unit::serve(resources.as_ref()))),
        ("bench", [root, job]) => Some(bench::run_peer(root.as_ref(), job)),
        ("node", [node, root, number]) => Some(graph::run_node(root.as_ref(), node, number)),
        _ => None,
    }
}
