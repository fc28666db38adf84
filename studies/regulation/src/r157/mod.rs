//! `timegap r157`: UN R157's matrices, by its performance models and by our control laws.

pub mod drive;
pub mod judge;
mod judged;
mod limits;
pub mod matrix;
mod page;
mod plan;
mod print;
mod results;
pub mod scene;
pub mod settled;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::table;
use clap::Args;
use group::{Error, Failure, GroupOptions};
use judged::Judged;
use matrix::{Case, Matrix};
use plan::{Kept, Plan, first_scenario};
use report::output::{OutputDirectory, OutputOptions};
use results::{MatrixResult, Results};
use runtime::Mode;

use frame::batch::{self, ProcessesSample, Repetition};
use frame::parts::{self, Merged, Part, PartOptions, Study, name_incomplete};

/// Words that the parts have said already, by their names.
const WITHOUT_MERGE: [&str; 4] = ["matrix", "controllers", "sample", "seed"];

/// Arguments of `r157`.
#[derive(Debug, Args)]
#[command(mut_arg("merge", |merge| merge.conflicts_with_all(WITHOUT_MERGE).conflicts_with_all(parts::OF_RUNS)))]
pub struct R157Arguments {
    /// Matrices, by commas [default: all]
    #[arg(long, value_enum, value_name = "NAME,...", value_delimiter = ',')]
    pub matrix: Vec<Matrix>,
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "models_only")]
    pub controllers: Vec<String>,
    /// Drive the regulation's models alone, no controller and no process
    #[arg(
        long,
        conflicts_with_all = ["processes", "programs", "ready_timeout", "shard", "resume", "merge"]
    )]
    pub models_only: bool,
    /// Draw this many cases of each matrix [default: all]
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Seed of the drawn cases and of the sensors' noise [default: 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u32>,
    /// Write the models' outcomes of the cut-ins as a table
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// A part of the runs, or parts put together.
    #[command(flatten)]
    pub parts: PartOptions,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the results as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// [`Error::Scenario`] for an unknown controller, [`NoCutIns`], else what keeps the runs from
/// starting.
pub fn run(arguments: &R157Arguments) -> Result<ExitCode, Error> {
    if arguments.parts.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// Does the runs that are left of this part.
fn drive(arguments: &R157Arguments) -> Result<ExitCode, Error> {
    let plan = Plan::of(arguments)?;
    write_table(arguments.csv.as_deref(), &plan.matrices)?;
    let runs = plan.runs();
    let study = Study::of_this_command(runs, &first_scenario(arguments)?);
    let (mut part, output) = Part::<Kept>::open(&arguments.parts, &arguments.output, study)?;
    let left = part.left();
    let bar = report::progress::count_bar(part.runs(), arguments.json);
    bar.set_position((part.runs() - left.len()) as u64);
    let repeated = part.repeated(&left, plan.settled.seed());
    let at_once = batch::at_once(None, Mode::Lockstep);
    let mut sample = ProcessesSample::default();
    let work = |index: usize, going_on: &dyn Fn() -> bool| {
        plan.drive(left[index], repeated.contains(&index), &arguments.group, going_on)
    };
    let mut each = |index: usize, driven: Result<(Kept, Option<Repetition>), Error>| {
        let (kept, repetition) = driven?;
        sample.count(left[index], repetition.as_ref());
        part.keep(left[index], kept, repetition.as_ref())
    };
    let end = batch::share(left.len(), at_once, &bar, &work, &mut each);
    let end = end.map(|()| sample);
    part.finish(end, left.len(), &bar, &output)?;
    let (shard, done) = (part.shard(), part.runs());
    let (kept, sample) = part.into_results();
    let sample = sample.agreed(|_| String::new())?;
    if let Some(shard) = shard {
        let (name, directory) = (String::from(shard), output.path().display());
        eprintln!(
            "shard {name}: {done} runs in {directory}; timegap r157 --merge puts all together"
        );
        return Ok(ExitCode::SUCCESS);
    }
    conclude(arguments, &plan, kept, sample, &output)
}

/// Puts parts together; without all of them a matrix has no figures.
fn merge(arguments: &R157Arguments) -> Result<ExitCode, Error> {
    let merged =
        Merged::<Kept>::read("r157", &arguments.parts.merge, arguments.output.out.as_deref())?;
    let of_parts: R157Arguments = merged.study.arguments()?;
    let plan = Plan::of(&of_parts)?;
    write_table(arguments.csv.as_deref(), &plan.matrices)?;
    merged.check(plan.runs(), &first_scenario(&of_parts)?)?;
    name_incomplete(&merged.incomplete);
    if !merged.incomplete.is_empty() {
        return Ok(ExitCode::FAILURE);
    }
    let output = OutputDirectory::create(&arguments.output, "r157")?;
    let (results, sample) = merged.into_results()?;
    conclude(arguments, &plan, results, sample, &output)
}

/// Judges, writes and prints.
fn conclude(
    arguments: &R157Arguments,
    plan: &Plan,
    kept: Vec<Option<Kept>>,
    processes_sample: ProcessesSample,
    output: &OutputDirectory,
) -> Result<ExitCode, Error> {
    let judged = plan.judged(&kept)?.expect("every run has its verdict");
    let matrices: Vec<MatrixResult> = judged.iter().map(Judged::result).collect();
    let ok = matrices.iter().all(MatrixResult::holds);
    let results = Results { schema_version: 1, ok, matrices, processes_sample };
    let json = serde_json::to_string_pretty(&results).expect("plain data") + "\n";
    let written = output.write("r157.json", json.as_bytes());
    let written =
        written.and_then(|()| output.write(report::FILE, page::page(&results, &judged).as_bytes()));
    if arguments.json {
        report::print::out(&json)?;
    } else {
        report::print::out(&print::text(&results))?;
        report::print::out(&output.places())?;
    }
    written?;
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A table of cut-ins is to be written, and no matrix has any.
#[derive(Debug, thiserror::Error)]
#[error("--csv writes the cut-ins, and there are none: add --matrix cut-in")]
pub struct NoCutIns;

impl Failure for NoCutIns {}

fn write_table(path: Option<&Path>, matrices: &[(Matrix, Vec<Case>)]) -> Result<(), Error> {
    let Some(path) = path else { return Ok(()) };
    let cut_ins: Vec<_> = matrices
        .iter()
        .flat_map(|(_, cases)| cases)
        .filter_map(|case| match case {
            Case::CutIn(case) => Some(*case),
            Case::Following(_) | Case::CutOut(_) => None,
        })
        .collect();
    if cut_ins.is_empty() {
        return Err(NoCutIns.into());
    }
    let mut text = Vec::new();
    table::write_cut_ins(&mut text, cut_ins).expect("memory takes every byte");
    std::fs::write(path, text).map_err(|reason| Error::Path {
        action: "write",
        path: path.to_owned(),
        reason,
    })
}
