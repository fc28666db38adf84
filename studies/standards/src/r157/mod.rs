//! `timegap r157`: UN R157's matrices, by its performance models and by our control laws.
//!
//! ```text
//! matrix ─► case ─┬─ models ──────────────► verdict ┐
//!                 └─ law, brake on and off ► verdict ┴─► criterion: collisions where a model has none
//! ```

mod asked;
mod columns;
pub mod drive;
pub mod judge;
mod judged;
mod kept;
mod limits;
pub mod matrix;
mod pictures;
mod plan;
mod results;
pub mod scene;
pub mod settled;

pub use columns::schema;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::table;
use clap::Args;
use frame::batch::{Done, Job};
use frame::{Command, Crew, Entry, Found, Needs, RunOptions, RunResult, Study};
use group::{Error, Failure, LawOptions};
use judged::Judged;
use kept::Kept;
use matrix::{Case, Matrix};
use plan::{Plan, first_scenario};
use report::results::Document;
use results::{MatrixResult, Results};
use scenario::Scenario;
use serde::{Deserialize, Serialize};

/// Arguments of `r157`.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct R157Arguments {
    /// Matrices, by commas [default: all]
    #[arg(long, value_enum, value_name = "NAME,...", value_delimiter = ',')]
    pub matrix: Vec<Matrix>,
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "models_only")]
    pub controllers: Vec<String>,
    /// Laws of the user's own.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Drive the regulation's models alone, without controllers and processes
    #[arg(
        long,
        conflicts_with_all = ["laws", "require", "processes", "programs", "ready_timeout", "shard", "resume"]
    )]
    pub models_only: bool,
    /// Draw this many cases of each matrix [default: all]
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Seed of the drawn cases and of the sensors' noise [default: 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u32>,
    /// Judge every drive by a requirement as well: a formula or a name (repeatable; docs/search.md)
    #[arg(long = "require", value_name = "FORMULA")]
    pub require: Vec<String>,
    /// Write the models' outcomes of the cut-ins as a table
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Error::Scenario`] for an unknown controller, [`NoCutIns`], else as [`frame::run`].
pub fn run(command: &Command<R157Arguments>) -> Result<ExitCode, Error> {
    if let Some(path) = &command.study.csv {
        write_table(path, &asked::matrices(&command.study))?;
    }
    frame::run::<Plan>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Plan>();

impl Study for Plan {
    type Arguments = R157Arguments;
    type Record = Kept;
    type Seen = ();

    const NAME: &'static str = "r157";
    const NEEDS: Needs = Needs::All;

    fn plan(arguments: &R157Arguments, _: &RunOptions) -> Result<Self, Error> {
        Self::of(arguments)
    }

    fn runs(&self) -> usize {
        self.number_of_runs()
    }

    fn subject(&self) -> Result<String, Error> {
        Ok(first_scenario(&self.settled)?.to_toml())
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        self.first_of(run).map(Job::lockstep)
    }

    fn record(&self, _: usize, _: &Job, result: Result<Done, Error>) -> Result<(Kept, ()), Error> {
        Ok((Kept::alone(&result?), ()))
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Result<RunResult<Kept, ()>, Error> {
        let drive = |aebs: bool, scenario: Scenario| {
            let job = Job::lockstep(scenario);
            let done = crew.drive(run, &job)?;
            crew.observe(run, &self.keys_of(run, aebs), &job.scenario, &done);
            Ok(done)
        };
        Ok(RunResult { record: self.drive_case(run, &drive)?, seen: () })
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        self.keys_of(run, false)
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let mut kept = vec![None; self.number_of_runs()];
        for (run, record) in found.records.all()? {
            kept[run] = Some(record);
        }
        let judged = self.judged(&kept)?.expect("the frame judges whole studies alone");
        let matrices: Vec<MatrixResult> = judged.iter().map(Judged::result).collect();
        let ok = matrices.iter().all(|matrix| matrix.holds() && matrix.requirements_broken() == 0);
        let results = Results { schema_version: 1, ok, matrices };
        Ok(columns::document(&results, &judged))
    }
}

/// A table of cut-ins is to be written, and no matrix has any.
#[derive(Debug, thiserror::Error)]
#[error("--csv writes the cut-ins, and there are none: add --matrix cut-in")]
pub struct NoCutIns;

impl Failure for NoCutIns {}

fn write_table(path: &Path, matrices: &[(Matrix, Vec<Case>)]) -> Result<(), Error> {
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
