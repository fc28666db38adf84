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
mod words;

use clap::Args;
pub use results::schema;
use serde::{Deserialize, Serialize};

use frame::batch::{self, Done, Job};
use frame::param::{self, Param};
use frame::{Command, Entry, Found, Needs, RunOptions, Study, seeds};
use group::{Error, Failure, ModeName, ScenarioOptions};
use report::results::Document;
use results::{Run, Sweep};
use runtime::Mode;
use scenario::Scenario;
use std::process::ExitCode;

/// Most runs of a sweep.
const MAX_RUNS: usize = 100_000;

/// Arguments of `sweep`.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct SweepArguments {
    /// Name of a built-in scenario (see `timegap list`), or a TOML file
    pub scenario: String,
    /// A key and its values: `KEY=A..B/STEP` or `KEY=a,b,c`; given again: their grid
    #[arg(long = "param", value_name = "KEY=VALUES", required = true)]
    pub params: Vec<String>,
    /// Seeds of every point: a number N for 1 to N, A..B or a,b,c
    #[arg(long, value_name = "SEEDS", conflicts_with = "seed")]
    pub seeds: Option<String>,
    /// Options of all points of the grid.
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
    /// Clock: curves repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_enum, default_value_t = ModeName::Lockstep)]
    pub mode: ModeName,
}

/// Runs the command.
///
/// # Errors
/// A scenario, key or grid that cannot be driven, else as [`frame::run`].
pub fn run(command: &Command<SweepArguments>) -> Result<ExitCode, Error> {
    frame::run::<Grid>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Grid>();

/// The study: each point of the grid with each seed.
struct Grid {
    /// Name of the scenario, or its file, as on the command line.
    scenario: String,
    options: ScenarioOptions,
    mode: Mode,
    params: Vec<Param>,
    /// The keys of each run.
    points: Vec<Vec<String>>,
    /// Controllers of the runs, each once.
    controllers: Vec<String>,
}

fn open(scenario: &str, options: &ScenarioOptions, keys: &[String]) -> Result<Scenario, Error> {
    group::open_with(scenario, options, "--param", keys)
}

impl Study for Grid {
    type Arguments = SweepArguments;
    type Record = Run;
    type Seen = ();

    const NAME: &'static str = "sweep";
    const NEEDS: Needs = Needs::Any;

    /// Everything is read before anything runs; the scenarios are made again when their turn comes.
    fn plan(arguments: &SweepArguments, run: &RunOptions) -> Result<Self, Error> {
        let (params, points) = points(arguments)?;
        let (mode, options) = (arguments.mode.into(), arguments.scenario_options.clone());
        let argument = arguments.scenario.clone();
        let mut controllers: Vec<String> = Vec::new();
        for keys in &points {
            let scenario = open(&argument, &options, keys)?;
            batch::check(&scenario, mode, &run.group)?;
            let name = scenario.controller.name.as_str();
            if !controllers.iter().any(|known| known == name) {
                controllers.push(name.to_owned());
            }
        }
        options.laws.expect_all_in(&controllers)?;
        Ok(Self { scenario: argument, options, mode, params, points, controllers })
    }

    fn runs(&self) -> usize {
        self.points.len()
    }

    fn mode(&self) -> Mode {
        self.mode
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let scenario = open(&self.scenario, &self.options, &self.points[run])?;
        Ok(Job { mode: self.mode, ..Job::lockstep(scenario) })
    }

    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Run, ()), Error> {
        // A program that cannot start is not a result of a point.
        if let Err(error @ Error::NotReady { foreign: true, .. }) = result {
            return Err(error);
        }
        let (seed, summary) = (job.scenario.seed.value(), result.map(|done| done.summary));
        Ok((Run::new(&self.points[run], seed, summary), ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let pair = |setting: &String| {
            let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
            (key.to_owned(), value.trim_matches('"').to_owned())
        };
        // The seed has a column of its own.
        self.points[run].iter().map(pair).filter(|(key, _)| key != "seed").collect()
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let runs = found.records.all()?.into_iter().map(|(_, run)| run).collect();
        let controllers = self.controllers.clone();
        let sweep = Sweep::new(&self.scenario, controllers, self.mode, &self.params, runs);
        Ok(page::document(&sweep))
    }
}

/// Reason why a grid is not swept.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Seeds have an option of their own.
    #[error("--param {argument}: points are run with several seeds by --seeds N")]
    Seed {
        /// The argument.
        argument: String,
    },
    /// Two axes of the same key.
    #[error("--param {key}: the key is given twice")]
    Twice {
        /// The key.
        key: String,
    },
    /// The grid is too large.
    #[error("the grid has more than {MAX_RUNS} runs")]
    TooManyRuns,
}

impl Failure for SweepError {}

/// The keys and the points of their grid, seeds included.
fn points(arguments: &SweepArguments) -> Result<(Vec<Param>, Vec<Vec<String>>), Error> {
    let mut params = Vec::new();
    for argument in &arguments.params {
        let param = Param::parse(argument)?;
        if param.key == "seed" {
            return Err(SweepError::Seed { argument: argument.clone() }.into());
        }
        if params.iter().any(|known: &Param| known.key == param.key) {
            return Err(SweepError::Twice { key: param.key }.into());
        }
        param::refuse_if_set(
            &format!("--param {}", param.key),
            &param.key,
            &arguments.scenario_options,
        )?;
        params.push(param);
    }
    let mut all = params.clone();
    if let Some(seeds) = &arguments.seeds {
        let seeds = seeds::read(seeds)?.into_iter().map(|seed| seed.value().to_string());
        all.push(Param { key: "seed".into(), values: seeds.collect() });
    }
    let runs = all.iter().map(|param| param.values.len()).try_fold(1, usize::checked_mul);
    if runs.is_none_or(|runs| runs > MAX_RUNS) {
        return Err(SweepError::TooManyRuns.into());
    }
    Ok((params, param::grid(&all)))
}
