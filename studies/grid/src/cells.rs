//! The engine: cells of a grid, each driven with every seed.

use frame::batch::{self, Job};
use report::figures::Values;
use report::summary::Summary;
use runtime::Mode;
use scenario::quantity::Seed;
use scenario::{Scenario, Setting};
use supervise::report::Outcome;
use supervise::{Error, GroupOptions, Opening};

use crate::row::Row;

/// A scenario with a law and with values of the keys.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Name of the scenario in results.
    pub label: String,
    /// Place of its scenario among the grid's.
    pub opening: usize,
    pub settings: Vec<Setting>,
}

/// Cells of a grid, each driven with every seed; the seed varies fastest.
#[derive(Debug)]
pub struct Grid {
    /// Scenarios with the options that hold for all their cells.
    pub openings: Vec<Opening>,
    pub cells: Vec<Cell>,
    /// Seeds of each cell; empty: the scenario's own.
    pub seeds: Vec<Seed>,
    pub mode: Mode,
}

impl Grid {
    /// Runs of a cell.
    pub fn seeds(&self) -> usize {
        self.seeds.len().max(1)
    }

    pub fn runs(&self) -> usize {
        self.cells.len() * self.seeds()
    }

    pub fn cell(&self, run: usize) -> &Cell {
        &self.cells[run / self.seeds()]
    }

    pub fn scenario(&self, run: usize) -> Result<Scenario, Error> {
        let cell = self.cell(run);
        let scenario = self.openings[cell.opening].with("--vary", &cell.settings)?;
        let seed = self.seeds.get(run % self.seeds()).copied().unwrap_or(scenario.seed);
        Ok(Scenario { seed, ..scenario })
    }

    /// Reads the scenario of each cell, and refuses one that its run would refuse.
    pub fn check(
        &self,
        group: &GroupOptions,
        each: &mut dyn FnMut(&Scenario),
    ) -> Result<(), Error> {
        for run in (0..self.runs()).step_by(self.seeds()) {
            let scenario = self.scenario(run)?;
            batch::check(&scenario, self.mode, group)?;
            each(&scenario);
        }
        Ok(())
    }

    pub fn job(&self, run: usize) -> Result<Job, Error> {
        Ok(Job { mode: self.mode, ..Job::lockstep(self.scenario(run)?) })
    }

    pub fn keys(&self, run: usize) -> Vec<(String, String)> {
        self.cell(run).settings.iter().map(Setting::shown).collect()
    }

    /// The row of a run that could not be started.
    pub fn aborted(&self, run: usize, job: &Job, error: &Error) -> Row {
        Row {
            scenario: self.cell(run).label.clone(),
            controller: job.scenario.controller.name.as_str().to_owned(),
            seed: job.scenario.seed.value(),
            mode: self.mode.name().to_owned(),
            values: self.keys(run).into_iter().map(|(_, value)| value).collect(),
            outcome: Outcome::Aborted,
            aborted_because: Some(error.to_string()),
            requirements: Vec::new(),
            figures: Values::default(),
            parts: None,
        }
    }

    pub fn row(&self, run: usize, summary: Summary, keeps_parts: bool) -> Row {
        let values = self.keys(run).into_iter().map(|(_, value)| value).collect();
        Row::of(&self.cell(run).label, values, summary, keeps_parts)
    }
}
