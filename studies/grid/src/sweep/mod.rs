//! `timegap sweep`: figures of a drive as functions of keys of its scenario.
//!
//! ```text
//! KEY=A..B/STEP ─┐
//! KEY=a,b,c ─────┴─ grid ─ seeds ─► runs ─ fold over the seeds ─► points ─► curves
//! ```
//!
//! Every point of the grid is a run of its own. In lockstep, delays, jitter and misses are emulated
//! exactly. So the same sweep gives the same bytes, in one go or in parts.

mod page;
mod results;

use clap::Args;
pub use results::schema;
use serde::{Deserialize, Serialize};

use frame::batch::{Done, Job};
use frame::param::{self, Param};
use frame::{Command, Entry, Found, Needs, Recorded, RunOptions, Study};
use report::results::Document;
use results::Sweep;
use runtime::Mode;
use std::process::ExitCode;
use supervise::{Error, Opening, ScenarioOptions, UsageError};

use crate::row::{Cell, Grid, Row};

/// Most runs of a sweep.
const MAX_RUNS: usize = 100_000;

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct SweepArguments {
    /// Name of a built-in scenario (see `timegap list`), or a TOML file
    pub scenario: String,
    /// A key and its values: `KEY=A..B/STEP` or `KEY=a,b,c`; given again: their grid
    #[arg(long = "vary", value_name = "KEY=VALUES", required = true)]
    pub params: Vec<String>,
    /// Seeds of every point: a number N for 1 to N, A..B or a,b,c
    #[arg(long, value_name = "SEEDS", conflicts_with = "seed")]
    pub seeds: Option<String>,
    /// Options of all points of the grid.
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
    /// Clock: curves repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_parser = supervise::mode(), default_value = "lockstep")]
    pub mode: Mode,
}

pub fn run(command: &Command<SweepArguments>) -> Result<ExitCode, Error> {
    frame::run::<Points>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Points>();

/// The study: each point of the grid with each seed.
struct Points {
    grid: Grid,
    /// Name of the scenario, or its file, as on the command line.
    scenario: String,
    params: Vec<Param>,
    /// Controllers of the runs, each once.
    controllers: Vec<String>,
}

impl Study for Points {
    type Arguments = SweepArguments;
    type Record = Row;
    type Seen = ();

    const NAME: &'static str = "sweep";
    const NEEDS: Needs = Needs::Any;

    /// Everything is read before anything runs; the scenarios are made again when their turn comes.
    fn plan(arguments: &SweepArguments, run: &RunOptions) -> Result<Self, Error> {
        let scenario = arguments.scenario.clone();
        let params = params(arguments)?;
        let seeds = arguments.seeds.as_deref().map(param::seeds).transpose()?.unwrap_or_default();
        let values = params.iter().map(|param| param.settings.len());
        let runs = values.chain([seeds.len().max(1)]).try_fold(1, usize::checked_mul);
        if runs.is_none_or(|runs| runs > MAX_RUNS) {
            let expected = format_args!("at most {MAX_RUNS} runs");
            return Err(UsageError::at("the grid", "it has more runs", expected).into());
        }
        let label = scenario.clone();
        let cell = |settings| Cell { label: label.clone(), opening: 0, settings };
        let cells = param::grid(&params).into_iter().map(cell).collect();
        let openings = vec![Opening::of(&scenario, &arguments.scenario_options)?];
        let grid = Grid { openings, cells, seeds, mode: arguments.mode };
        let mut controllers: Vec<String> = Vec::new();
        grid.check(&run.group, &mut |scenario| {
            let name = scenario.controller.name.as_str();
            if !controllers.iter().any(|known| known == name) {
                controllers.push(name.to_owned());
            }
        })?;
        arguments.scenario_options.laws.expect_all_in(&controllers)?;
        Ok(Self { grid, scenario, params, controllers })
    }

    fn runs(&self) -> usize {
        self.grid.runs()
    }

    fn mode(&self) -> Mode {
        self.grid.mode
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        self.grid.job(run)
    }

    fn record(&self, run: usize, job: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        match result {
            Ok(done) => Ok((self.grid.row(run, done.summary, false), ())),
            // A program that cannot start is not a result of a point.
            Err(error @ Error::NotReady { foreign: true, .. }) => Err(error),
            Err(error) => Ok((self.grid.aborted(run, job, &error), ())),
        }
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        self.grid.keys(run)
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let rows = found.records.all()?.into_iter().map(|(_, row)| row).collect();
        let params = self.params.iter().map(|param| param.key.clone()).collect();
        let controllers = self.controllers.clone();
        Ok(page::document(&Sweep::new(&self.scenario, controllers, self.grid.mode, params, rows)))
    }
}

/// The keys with their values.
fn params(arguments: &SweepArguments) -> Result<Vec<Param>, Error> {
    let mut params: Vec<Param> = Vec::new();
    for argument in &arguments.params {
        let param = Param::parse(argument)?;
        if param.key == "seed" {
            let why = "seeds have an option of their own";
            return Err(UsageError::option("--vary", argument, why, "--seeds").into());
        }
        if params.iter().any(|known| known.key == param.key) {
            let why = "the key is given twice";
            return Err(UsageError::option("--vary", param.key, why, "each key once").into());
        }
        let by = format!("--vary {}", param.key);
        param::refuse_if_set(&by, &param.key, &arguments.scenario_options)?;
        params.push(param);
    }
    Ok(params)
}
