//! `timegap sweep`: what a key of the scenario does to the drive.
//!
//! Every point of the grid is a run of its own. In lockstep delays, jitter and misses are emulated
//! exactly, so that the same sweep gives the same bytes, in one go or in parts.

mod figure;
mod page;
mod results;
mod words;

use clap::Args;
use frame::batch::{self, Job, ProcessesSample, Source};
use frame::param::{self, Param, ValuesError};
use frame::parts::{self, Merged, Part, PartOptions, Study, name_incomplete};
use group::{Error, Failure, GroupOptions, ModeName, ScenarioOptions};
use report::output::{OutputDirectory, OutputOptions};
use report::print;
use results::{Run, Sweep};
use runtime::report::Outcome;
use scenario::Scenario;
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// Most runs of a sweep.
const MAX_RUNS: usize = 100_000;

/// Words that the parts have said already, by their names.
const WITHOUT_MERGE: [&str; 9] =
    ["scenario", "params", "seeds", "controller", "seed", "duration", "set", "mode", "jobs"];

/// Arguments of `sweep`.
#[derive(Debug, Args)]
#[command(mut_arg("merge", |merge| merge.conflicts_with_all(WITHOUT_MERGE).conflicts_with_all(parts::OF_RUNS)))]
pub struct SweepArguments {
    /// Name of a built-in scenario (see `timegap list`), or a TOML file
    #[arg(required_unless_present = "merge")]
    pub scenario: Option<String>,
    /// A key and its values: `KEY=A..B/STEP` or `KEY=a,b,c`; given again: their grid
    #[arg(long = "param", value_name = "KEY=VALUES", required_unless_present = "merge")]
    pub params: Vec<String>,
    /// Seeds, by commas or as A..B; every point is run with each
    #[arg(long, value_name = "SEEDS", conflicts_with = "seed")]
    pub seeds: Option<String>,
    /// What every point of the grid has in common.
    #[command(flatten)]
    pub scenario_options: ScenarioOptions,
    /// Clock: curves repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_enum, default_value_t = ModeName::Lockstep)]
    pub mode: ModeName,
    /// Runs at once [default: one per core; 1 in realtime]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// A part of the sweep, or parts put together.
    #[command(flatten)]
    pub parts: PartOptions,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go, and in which form.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the points as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &SweepArguments) -> Result<ExitCode, Error> {
    if arguments.parts.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// What is swept.
struct Plan {
    scenario: String,
    params: Vec<Param>,
    /// The keys of each run.
    points: Vec<Vec<String>>,
    /// Controllers of the runs, each once.
    controllers: Vec<String>,
    /// The first run's scenario.
    first: Scenario,
}

impl Plan {
    /// Everything is read before anything runs; the scenarios are made again when their turn comes.
    fn of(arguments: &SweepArguments) -> Result<Self, Error> {
        let (params, points) = points(arguments)?;
        let mut controllers: Vec<String> = Vec::new();
        let mut first = None;
        for keys in &points {
            let scenario = open(arguments, keys)?;
            batch::check(&scenario, arguments.mode.into(), &arguments.group)?;
            let name = scenario.controller.name.as_str();
            if !controllers.iter().any(|known| known == name) {
                controllers.push(name.to_owned());
            }
            first.get_or_insert(scenario);
        }
        let first = first.expect("a grid has a point");
        let scenario = arguments.scenario.clone().unwrap_or_default();
        Ok(Self { scenario, params, points, controllers, first })
    }
}

fn open(arguments: &SweepArguments, keys: &[String]) -> Result<Scenario, Error> {
    let name = arguments.scenario.as_deref().unwrap_or_default();
    group::open_with(name, &arguments.scenario_options, "--param", keys)
}

/// Does the runs that are left of this part.
fn drive(arguments: &SweepArguments) -> Result<ExitCode, Error> {
    let plan = Plan::of(arguments)?;
    let mode = arguments.mode.into();
    let study = Study::of_this_command(plan.points.len(), &plan.first);
    let (mut part, output) = Part::<Run>::open(&arguments.parts, &arguments.output, study)?;
    let left = part.left();
    let bar = report::progress::count_bar(part.runs(), arguments.json);
    bar.set_message(format!("sweep {}", plan.first.name.as_str()));
    bar.set_position((part.runs() - left.len()) as u64);
    let repeated = part.repeated(&left, plan.first.seed.value());
    let at_once = batch::at_once(arguments.jobs, mode);
    let make = |index: usize| {
        let scenario = open(arguments, &plan.points[left[index]])?;
        Ok(Job { scenario, mode, sample_every: None, record: false })
    };
    let source = Source { runs: left.len(), make: &make };
    let mut each = |index: usize, job: &Job, result: Result<batch::Done, Error>| {
        // A program that cannot start is no result of a point.
        let result = match result {
            Err(error @ Error::NotReady { foreign: true, .. }) => return Err(error),
            result => result,
        };
        let run = left[index];
        let repetition = result.as_ref().ok().and_then(|done| done.repetition.clone());
        let seed = job.scenario.seed.value();
        let kept = Run::new(&plan.points[run], seed, result.map(|done| done.summary));
        part.keep(run, kept, repetition.as_ref())
    };
    let end = batch::run_made(&repeated, &source, at_once, &arguments.group, &bar, &mut each);
    let end = part.finish(end, left.len(), &bar, &output);
    let (runs, sample) = part.into_results();
    let agreed = end.and_then(|()| {
        let point = |run: usize| format!(" ({})", plan.points[run].join(" "));
        Ok(sample.clone().agreed(point)?)
    });
    conclude(arguments, arguments, &plan, (runs, sample), &output, agreed.map(|_| ()))
}

/// Puts parts together.
fn merge(arguments: &SweepArguments) -> Result<ExitCode, Error> {
    let merged =
        Merged::<Run>::read("sweep", &arguments.parts.merge, arguments.output.out.as_deref())?;
    let of_parts: SweepArguments = merged.study.arguments()?;
    let plan = Plan::of(&of_parts)?;
    merged.check(plan.points.len(), &plan.first)?;
    name_incomplete(&merged.incomplete);
    let output = OutputDirectory::create(&arguments.output, "sweep")?;
    let whole = merged.incomplete.is_empty();
    let results = merged.into_results()?;
    let code = conclude(arguments, &of_parts, &plan, results, &output, Ok(()))?;
    Ok(if whole { code } else { ExitCode::FAILURE })
}

/// Writes and prints. What an interrupt left undone is missing; what was done is kept.
fn conclude(
    arguments: &SweepArguments,
    of_runs: &SweepArguments,
    plan: &Plan,
    (runs, sample): (Vec<Option<Run>>, ProcessesSample),
    output: &OutputDirectory,
    end: Result<(), Error>,
) -> Result<ExitCode, Error> {
    let runs = runs.into_iter().flatten().collect();
    let mode = of_runs.mode.into();
    let mut sweep = Sweep::new(&plan.scenario, plan.controllers.clone(), mode, &plan.params, runs);
    sweep.processes_sample = if end.is_ok() { sample } else { ProcessesSample::default() };
    let json = serde_json::to_string_pretty(&sweep).expect("plain data") + "\n";
    let written = output
        .write("sweep.csv", sweep.csv().as_bytes())
        .and_then(|()| output.write("sweep.json", json.as_bytes()))
        .and_then(|()| output.write(report::FILE, page::page(&sweep).as_bytes()));
    if end.is_ok() && arguments.json {
        print::out(&json)?;
    } else if !arguments.json {
        print::out(&sweep.table())?;
        print::out(&output.places())?;
    }
    // Printed first: a full disk does not take what was measured.
    written?;
    end?;
    let whole = sweep.runs.iter().all(|run| run.outcome == Outcome::Completed);
    Ok(if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Why a grid is not swept.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Seeds have an option of their own.
    #[error("--param {argument}: points are run with several seeds by --seeds A..B")]
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
    /// The seeds cannot be read.
    #[error("--seeds {seeds}: {reason}, expected A..B or a,b,c")]
    Seeds {
        /// The argument.
        seeds: String,
        /// What is wrong with it.
        #[source]
        reason: ValuesError,
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
        param::refuse_if_set(&param.key, &arguments.scenario_options)?;
        params.push(param);
    }
    let mut all = params.clone();
    if let Some(seeds) = &arguments.seeds {
        let values = param::values(seeds, Some("1"))
            .map_err(|reason| SweepError::Seeds { seeds: seeds.clone(), reason })?;
        all.push(Param { key: "seed".into(), values });
    }
    let runs = all.iter().map(|param| param.values.len()).try_fold(1, usize::checked_mul);
    if runs.is_none_or(|runs| runs > MAX_RUNS) {
        return Err(SweepError::TooManyRuns.into());
    }
    Ok((params, param::grid(&all)))
}
