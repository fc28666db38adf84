//! `timegap sweep`: what a key of the scenario does to the drive.
//!
//! Every point of the grid is a run of its own through real processes. In lockstep delays, jitter
//! and misses are emulated exactly, so that the same sweep gives the same bytes.

mod figure;
mod page;
mod param;
mod results;
mod words;

use crate::batch::{self, Job};
use clap::Args;
use group::Error;
use group::{GroupOptions, ModeName, ScenarioOptions};
use param::Param;
use report::output::{OutputDirectory, OutputOptions};
use report::print;
use results::{Run, Sweep};
use runtime::report::Outcome;
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// Most runs of a sweep.
const MAX_RUNS: usize = 100_000;

/// Arguments of `sweep`.
#[derive(Debug, Args)]
pub struct SweepArguments {
    /// Name of a built-in scenario (see `timegap list`), or a TOML file
    pub scenario: String,
    /// A key and its values: `KEY=A..B/STEP` or `KEY=a,b,c`; given again: their grid
    #[arg(long = "param", value_name = "KEY=VALUES", required = true)]
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
    let (params, points) = points(arguments)?;
    // Everything is read before anything runs.
    let mode = arguments.mode.into();
    let mut jobs = Vec::new();
    for keys in &points {
        let options = &arguments.scenario_options;
        let scenario = group::open_with(&arguments.scenario, options, "--param", keys)?;
        jobs.push(Job { scenario, mode, sample_every: None });
    }
    let output = OutputDirectory::create(&arguments.output, "sweep")?;
    let bar = report::progress::count_bar(jobs.len(), arguments.json);
    bar.set_message(format!("sweep {}", jobs[0].scenario.name.as_str()));
    let mut runs: Vec<Option<Run>> = vec![None; jobs.len()];
    let at_once = batch::at_once(arguments.jobs, mode);
    let end = batch::run(&jobs, at_once, &arguments.group, &bar, &mut |index, result| {
        let seed = jobs[index].scenario.seed.value();
        runs[index] = Some(Run::new(&points[index], seed, result.map(|done| done.summary)));
        Ok(())
    });
    bar.finish_and_clear();

    let runs = runs.into_iter().flatten().collect();
    let mut controllers: Vec<String> = Vec::new();
    for job in &jobs {
        let name = job.scenario.controller.name.as_str();
        if !controllers.iter().any(|known| known == name) {
            controllers.push(name.to_owned());
        }
    }
    let mut sweep = Sweep::new(&arguments.scenario, controllers, mode, &params, runs);
    sweep.processes_sample = end.as_ref().cloned().unwrap_or_default();
    let json = serde_json::to_string_pretty(&sweep).expect("plain data") + "\n";
    let written = output
        .write("sweep.csv", sweep.csv().as_bytes())
        .and_then(|()| output.write("sweep.json", json.as_bytes()))
        .and_then(|()| output.write(report::FILE, page::page(&sweep).as_bytes()));
    // What an interrupt left undone is missing; what was done is kept.
    if end.is_ok() && arguments.json {
        print::out(&json)?;
    } else if !arguments.json {
        print::out(&sweep.table())?;
        print::out(&format!("results: {}\n", output.path().display()))?;
        print::out(&format!("report:  {}\n", output.path().join(report::FILE).display()))?;
    }
    // Printed first: a full disk does not take what was measured.
    written?;
    end?;
    let whole = sweep.runs.iter().all(|run| run.outcome == Outcome::Completed);
    Ok(if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The keys and the points of their grid, seeds included.
fn points(arguments: &SweepArguments) -> Result<(Vec<Param>, Vec<Vec<String>>), Error> {
    let mut params = Vec::new();
    for argument in &arguments.params {
        let param = Param::parse(argument)?;
        if param.key == "seed" {
            let instead = "points are run with several seeds by --seeds A..B";
            return Err(Error::Usage(format!("--param {argument}: {instead}")));
        }
        if params.iter().any(|known: &Param| known.key == param.key) {
            return Err(Error::Usage(format!("--param {}: the key is given twice", param.key)));
        }
        params.push(param);
    }
    let mut all = params.clone();
    if let Some(seeds) = &arguments.seeds {
        let values = param::values(seeds, Some("1")).map_err(|what| {
            Error::Usage(format!("--seeds {seeds}: {what}, expected A..B or a,b,c"))
        })?;
        all.push(Param { key: "seed".into(), values });
    }
    let runs = all.iter().map(|param| param.values.len()).try_fold(1, usize::checked_mul);
    if runs.is_none_or(|runs| runs > MAX_RUNS) {
        return Err(Error::Usage(format!("the grid has more than {MAX_RUNS} runs")));
    }
    Ok((params, param::grid(&all)))
}
