//! Pieces of a paper, and the runner that drives their scenarios.

use super::row::Row;
use frame::batch::{Done, Job};
use frame::{Crew, batch};
use report::RunPicture;
use report::chart::Plot;
use report::summary::Summary;
use scenario::{Scenario, Setting};
use std::cell::Cell;
use std::sync::Arc;
use supervise::{Drive, DriveStep, Error, GroupOptions, ScenarioOptions};

/// Result of a piece.
#[derive(Default)]
pub struct Part {
    pub rows: Vec<Row>,
    pub pictures: Pictures,
}

impl Part {
    /// A result without pictures.
    pub fn of_rows(rows: Vec<Row>) -> Self {
        Self { rows, ..Self::default() }
    }
}

type Reproduce = dyn Fn(&Runner<'_>) -> Result<Part, Error> + Send + Sync;

/// Rows of a paper that wait for no other piece: a few drives, one after another.
#[derive(Clone)]
pub struct Piece {
    /// Its name among those of the paper.
    pub name: String,
    reproduce: Arc<Reproduce>,
}

impl Piece {
    /// A piece with its work.
    pub fn new(
        name: impl Into<String>,
        reproduce: impl Fn(&Runner<'_>) -> Result<Part, Error> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), reproduce: Arc::new(reproduce) }
    }

    /// Drives its scenarios and compares.
    pub fn reproduce(&self, runner: &Runner<'_>) -> Result<Part, Error> {
        (self.reproduce)(runner)
    }
}

/// The keys of a piece's drive: its number in the piece, and the keys that it sets.
pub fn keys(paper: &str, piece: &str, drive: usize, set: &[Setting]) -> Vec<(String, String)> {
    let words = set.iter().map(Setting::shown).map(|(key, value)| format!("{key}={value}"));
    let keys = [
        ("paper", paper.to_owned()),
        ("piece", piece.to_owned()),
        ("drive", drive.to_string()),
        ("set", words.collect::<Vec<_>>().join(" ")),
    ];
    keys.map(|(name, value)| (name.to_owned(), value)).to_vec()
}

/// The drives of one piece.
pub struct Runner<'a> {
    crew: &'a Crew<'a>,
    run: usize,
    /// The paper, and the piece of it.
    names: (&'a str, &'a str),
    drives: Cell<usize>,
    /// Standard deviation of the skilled driver's aimed speed, m/s.
    pub driver_spread_mps: f64,
}

impl<'a> Runner<'a> {
    /// A runner for the piece that is run number `run`.
    pub fn new(
        crew: &'a Crew<'a>,
        run: usize,
        names: (&'a str, &'a str),
        driver_spread_mps: f64,
    ) -> Self {
        Self { crew, run, names, drives: Cell::default(), driver_spread_mps }
    }

    /// Drives a built-in scenario with these settings.
    pub fn drive(&self, name: &str, set: &[Setting]) -> Result<Driven, Error> {
        let job = Job::lockstep(open(name, set)?);
        let done = self.crew.drive(self.run, &job)?;
        let scenario = job.scenario;
        batch::whole(&done.summary)?;
        self.drives.set(self.drives.get() + 1);
        let (paper, piece) = self.names;
        let keys = self::keys(paper, piece, self.drives.get(), set);
        self.crew.observe(self.run, &keys, &scenario, &done);
        Ok(Driven::of(scenario, done))
    }
}

/// A scenario that was driven in lockstep.
pub struct Driven {
    /// The scenario as it took effect.
    pub scenario: Scenario,
    pub drive: Drive,
    pub summary: Summary,
    /// Names of the law's figures in the drive.
    pub figure_names: Vec<&'static str>,
}

impl Driven {
    /// Drives a built-in scenario with these settings, in this thread.
    pub fn alone(name: &str, set: &[Setting]) -> Result<Self, Error> {
        let group = GroupOptions { programs: Vec::new(), ready_timeout: 10.0, processes: false };
        let scenario = open(name, set)?;
        let done = batch::lockstep(&scenario, &group, &|| true)?;
        batch::whole(&done.summary)?;
        Ok(Self::of(scenario, done))
    }

    pub(crate) fn of(scenario: Scenario, done: Done) -> Self {
        let figure_names = controller::laws::figure_names(&scenario);
        Self { scenario, drive: done.drive, summary: done.summary, figure_names }
    }

    /// One of the law's figures over the control cycles: (time in s, value).
    pub fn figure(&self, name: &str) -> Vec<(f64, f64)> {
        let index = self.figure_names.iter().position(|figure| *figure == name);
        let index = index.expect("the law has a figure of this name");
        self.points(|step| Some(step.figures?[index]))
    }

    /// A value over time, where it is known.
    pub fn points(&self, value: impl Fn(&DriveStep) -> Option<f64>) -> Vec<(f64, f64)> {
        self.drive.steps.iter().filter_map(|step| Some((step.time_s, value(step)?))).collect()
    }

    /// Its picture, under the scenario's and the controller's names.
    pub fn picture(&self) -> (String, RunPicture) {
        let scenario = &self.scenario;
        let name = format!("{} · {}", scenario.name.as_str(), scenario.controller.name.as_str());
        (name, RunPicture::of_drive(scenario, &self.drive))
    }
}

pub(crate) fn open(name: &str, set: &[Setting]) -> Result<Scenario, Error> {
    let set = set.to_vec();
    supervise::open(name, &ScenarioOptions { set, ..ScenarioOptions::default() })
}

/// A number with the digits that it has when it is printed with these decimals.
pub(crate) fn printed(number: f64, decimals: usize) -> f64 {
    format!("{number:.decimals$}").parse().expect("it was a number")
}

/// Pictures of a paper, for its page.
#[derive(Debug, Default)]
pub struct Pictures {
    pub drives: Vec<(String, RunPicture)>,
    /// The paper's own figures.
    pub galleries: Vec<Gallery>,
}

impl Pictures {
    /// Adds those of another piece.
    pub fn extend(&mut self, other: Self) {
        self.drives.extend(other.drives);
        self.galleries.extend(other.galleries);
    }
}

/// Plots below one heading.
#[derive(Debug)]
pub struct Gallery {
    pub heading: String,
    pub plots: Vec<Plot>,
}
