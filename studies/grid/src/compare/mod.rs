//! `timegap compare`: laws side by side on the same scenarios, with one seed or several.
//!
//! ```text
//! scenario 1 ─┬─ law A ─ seeds ─► rows ┐
//!             └─ law B ─ seeds ─► rows ┴─► block of scenario 1: the best of each column is marked
//!                                        └─► of several seeds: mean ± spread, and A - B seed by seed
//! ```

mod against;
mod differences;
mod results;

pub use results::{over_seeds, schema};

use against::Baseline;
use clap::Args;
use frame::batch::{self, Done, Job};
use frame::{Command, DriveOptions, Entry, Found, Needs, Recorded, RunOptions, Study, param};
use messages::Service;
use report::RunPicture;
use report::results::Document;
use results::{document, drives};
use runtime::Mode;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::{Error, Opening, ScenarioOptions, UsageError};

use crate::row::{Cell, Grid, Row};

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct CompareArguments {
    /// Names of built-in scenarios, or TOML files
    #[arg(required = true)]
    pub scenarios: Vec<String>,
    /// Laws, keys and requirements of all drives.
    #[command(flatten)]
    pub drives: DriveOptions,
    /// Seeds of every scenario: a number N for 1 to N, A..B or a,b,c; figures are means, differences are judged
    #[arg(long, value_name = "SEEDS")]
    pub seeds: Option<String>,
    /// Clock: figures of the drive repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_parser = supervise::mode(), default_value = "lockstep")]
    pub mode: Mode,
    /// Judge the runs by an earlier comparison, its compare.json: a figure that got worse is status 1
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
}

pub fn run(command: &Command<CompareArguments>) -> Result<ExitCode, Error> {
    frame::run::<Laws>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Laws>();

/// The study: each scenario with each law and each seed.
struct Laws {
    grid: Grid,
    baseline: Option<Baseline>,
}

/// The name of a scenario in results: its own, or its file's where another file has the same name.
fn label(argument: &str, all: &[(String, String)]) -> String {
    let own = all.iter().find(|(known, _)| known == argument).map_or(argument, |(_, name)| name);
    if all.iter().filter(|(_, name)| name == own).count() < 2 {
        return own.to_owned();
    }
    let stem = |argument: &str| {
        Path::new(argument).file_stem().map(|stem| stem.to_string_lossy().into_owned())
    };
    match stem(argument) {
        Some(own)
            if all.iter().filter(|(known, _)| stem(known).as_ref() == Some(&own)).count() == 1 =>
        {
            own
        }
        _ => argument.to_owned(),
    }
}

/// The laws of the user's own: of the options, then those that every scenario declares. Returns also whether all
/// scenarios are of trucks.
fn own_laws(arguments: &CompareArguments) -> Result<(Vec<String>, bool), Error> {
    let mut own = arguments.drives.laws.names();
    let options = ScenarioOptions {
        set: arguments.drives.set.clone(),
        laws: arguments.drives.laws.clone(),
        // Any law will do to read what the file declares.
        controller: Some("acc-mpc".to_owned()),
        ..ScenarioOptions::default()
    };
    let mut declared: Option<Vec<String>> = None;
    let mut all_trucks = true;
    for argument in &arguments.scenarios {
        let scenario = supervise::open(argument, &options)?;
        all_trucks &= scenario.plant.vehicle.is_truck();
        let laws = scenario.laws;
        match &mut declared {
            Some(declared) => declared.retain(|name| laws.contains_key(name)),
            None => declared = Some(laws.into_keys().collect()),
        }
    }
    own.extend(
        declared.into_iter().flatten().filter(|name| !arguments.drives.laws.names().contains(name)),
    );
    Ok((own, all_trucks))
}

impl Study for Laws {
    type Arguments = CompareArguments;
    type Record = Row;
    /// Drives of the first seed alone are drawn.
    type Seen = Option<RunPicture>;

    const NAME: &'static str = "compare";
    const NEEDS: Needs = Needs::Part;

    fn plan(arguments: &CompareArguments, run: &RunOptions) -> Result<Self, Error> {
        let baseline = arguments.against.as_deref().map(Baseline::read).transpose()?;
        let (own, all_trucks) = own_laws(arguments)?;
        let laws = batch::laws::named(&arguments.drives.controllers, &own, all_trucks)?;
        arguments.drives.laws.expect_all_in(&laws)?;
        let mut programs = run.group.programs.iter();
        if laws.len() > 1 && programs.any(|(service, _)| *service == Service::Controller) {
            let why = format_args!("the program would replace each of {} laws", laws.len());
            let expected = "one law by --controllers";
            return Err(UsageError::at("--service controller=PROGRAM", why, expected).into());
        }
        let twice = |(place, name): &(usize, &String)| arguments.scenarios[..*place].contains(name);
        if let Some((_, name)) = arguments.scenarios.iter().enumerate().find(twice) {
            let why = format_args!("{name} is there twice");
            return Err(UsageError::at("the scenarios", why, "each of them once").into());
        }
        let seeds = arguments.seeds.as_deref().map(param::seeds).transpose()?.unwrap_or_default();
        let mut grid =
            Grid { openings: Vec::new(), cells: Vec::new(), seeds, mode: arguments.mode };
        for argument in &arguments.scenarios {
            for law in &laws {
                let options = ScenarioOptions {
                    controller: Some(law.clone()),
                    set: arguments.drives.set.clone(),
                    laws: arguments.drives.laws.clone(),
                    require: arguments.drives.require.clone(),
                    ..ScenarioOptions::default()
                };
                if arguments.seeds.is_some() {
                    param::refuse_if_set("--seeds", "seed", &options)?;
                }
                let (label, opening, settings) =
                    (argument.clone(), grid.openings.len(), Vec::new());
                grid.openings.push(Opening::of(argument, &options)?);
                grid.cells.push(Cell { label, opening, settings });
            }
        }
        let mut names: Vec<(String, String)> = Vec::new();
        let mut arguments = grid.cells.iter().map(|cell| cell.label.clone());
        grid.check(&run.group, &mut |scenario| {
            for notice in scenario.notices() {
                eprintln!("note: {notice}");
            }
            let argument = arguments.next().expect("each cell is read once");
            if names.last().is_none_or(|(known, _)| *known != argument) {
                names.push((argument, scenario.name.as_str().to_owned()));
            }
        })?;
        drop(arguments);
        grid.cells.iter_mut().for_each(|cell| cell.label = label(&cell.label, &names));
        Ok(Self { grid, baseline })
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
        let Done { summary, drive, .. } = result?;
        let is_drawn = run.is_multiple_of(self.grid.seeds());
        let picture = is_drawn.then(|| RunPicture::of_drive(&job.scenario, &drive));
        Ok((self.grid.row(run, summary, true), picture))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let rows: Vec<(usize, Row)> = found.records.all()?;
        let drives = drives(&rows, &found.seen);
        let rows: Vec<Row> = rows.into_iter().map(|(_, row)| row).collect();
        let against = self.baseline.as_ref().map(|baseline| baseline.judge(&rows)).transpose()?;
        Ok(document(rows, self.grid.seeds(), drives, against))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_are_distinguished_by_their_folders() {
        let all = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            pairs.iter().map(|(file, name)| ((*file).to_owned(), (*name).to_owned())).collect()
        };
        let one = all(&[("a/x.toml", "mine"), ("cut-in", "cut-in")]);
        assert_eq!(
            (label("a/x.toml", &one), label("cut-in", &one)),
            ("mine".into(), "cut-in".into())
        );
        let two = all(&[("a/x.toml", "mine"), ("b/y.toml", "mine")]);
        assert_eq!((label("a/x.toml", &two), label("b/y.toml", &two)), ("x".into(), "y".into()));
        let same = all(&[("a/x.toml", "mine"), ("b/x.toml", "mine")]);
        assert_eq!(label("b/x.toml", &same), "b/x.toml");
    }

    #[test]
    fn one_program_is_not_compared_with_itself() {
        let program = ["--service", "controller=./mine"];
        let said = plan(&program).err().expect("many laws").to_string();
        assert!(said.contains("expected one law by --controllers"), "{said}");
        let one = [&program[..], &["--controllers", "acc-mpc"]].concat();
        assert_eq!(plan(&one).expect("one law").runs(), 1);
    }

    fn plan(words: &[&str]) -> Result<Laws, Error> {
        let command = Command::read(&[&["cacc-a"], words].concat()).expect("they are arguments");
        Laws::plan(&command.study, &command.options)
    }

    #[test]
    fn every_law_meets_every_seed() {
        let two = ["--controllers", "acc-mpc,six-mode", "--seeds", "3"];
        let laws = plan(&two).expect("built in");
        let run = |run| {
            let scenario = laws.grid.scenario(run).expect("built in");
            (scenario.controller.name.as_str().to_owned(), scenario.seed.value())
        };
        assert_eq!(laws.runs(), 6);
        assert_eq!((run(2), run(3)), (("acc-mpc".into(), 3), ("six-mode".into(), 1)));
        let set = [&two[..], &["--set", "seed=7"]].concat();
        let said = plan(&set).err().expect("two seeds").to_string();
        assert!(said.contains("--seeds: --set seed=7 says what it is"), "{said}");
    }
}
