//! A run of a grid: its record, and a row of the results.

use frame::batch::{self, Job};
use report::figures::{Fold, Folded, Measured, Values, compared};
use report::results::Object;
use report::summary::{Aebs, Control, LawAccount, Summary, Timing};
use report::{print, verdicts};
use runtime::Mode;
use scenario::quantity::Seed;
use scenario::{Scenario, Setting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use supervise::report::Outcome;
use supervise::{Error, GroupOptions, Opening, RequirementVerdict};

/// A run.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Scenario that was driven.
    pub scenario: String,
    /// Control law that drove.
    pub controller: String,
    /// Seed of the run.
    pub seed: u64,
    /// Clock of the run.
    pub mode: String,
    /// Value of each key.
    #[serde(default)]
    pub values: Vec<String>,
    /// How the run ended.
    #[schemars(with = "String")]
    pub outcome: Outcome,
    /// Why the run was aborted.
    #[serde(default)]
    pub aborted_because: Option<String>,
    /// Verdicts on the requirements, as in summary.json.
    #[serde(default)]
    #[schemars(with = "Vec<Object>")]
    pub requirements: Vec<RequirementVerdict>,
    /// Figures of the drive.
    #[serde(default)]
    pub figures: Values,
    /// Parts of the summary, which a comparison has.
    #[serde(flatten)]
    pub parts: Option<Parts>,
}

/// Parts of a run's summary.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Parts {
    /// Figures from ground truth, as in summary.json.
    #[schemars(with = "Object")]
    pub control: Control,
    /// Latencies and deadlines, as in summary.json.
    #[schemars(with = "Object")]
    pub timing: Timing,
    /// Interventions of the emergency brake, as in summary.json.
    #[schemars(with = "Object")]
    pub aebs: Braking,
    /// Cycles by who commanded, as in summary.json.
    #[serde(default)]
    #[schemars(with = "Option<Object>")]
    pub law: Option<LawAccount>,
}

/// Interventions of the emergency brake in a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Braking {
    pub enabled: bool,
    pub warnings: Option<u64>,
    pub interventions: Option<u64>,
    pub braking_s: Option<f64>,
}

impl From<&Aebs> for Braking {
    fn from(aebs: &Aebs) -> Self {
        let Aebs { enabled, warnings, interventions, braking_s, .. } = *aebs;
        Self { enabled, warnings, interventions, braking_s }
    }
}

impl<'a> From<&'a Parts> for Measured<'a> {
    fn from(Parts { control, timing, aebs, law }: &'a Parts) -> Self {
        let Braking { warnings, interventions, braking_s, .. } = *aebs;
        Self { control, timing, law: law.as_ref(), warnings, interventions, braking_s }
    }
}

impl Row {
    /// The row of a run that ended; `keeps_parts` of its summary.
    pub fn of(label: &str, values: Vec<String>, summary: Summary, keeps_parts: bool) -> Self {
        Self {
            scenario: label.to_owned(),
            values,
            figures: Values::of(&summary),
            controller: summary.controller,
            seed: summary.seed,
            mode: summary.mode.to_owned(),
            outcome: summary.outcome,
            aborted_because: summary.aborted_because,
            requirements: summary.requirements,
            parts: keeps_parts.then(|| Parts {
                control: summary.control,
                timing: summary.timing,
                aebs: Braking::from(&summary.aebs),
                law: summary.law,
            }),
        }
    }

    /// Rows of a caller: a list as in the JSON of `compare`, also without figures beside the parts.
    pub fn read(rows: &str) -> serde_json::Result<Vec<Self>> {
        let rows: Vec<Self> = serde_json::from_str(rows)?;
        Ok(rows.into_iter().map(Self::with_figures).collect())
    }

    /// The row with the figures of its parts, if it has none.
    pub fn with_figures(self) -> Self {
        match self.parts.as_ref().filter(|_| self.figures == Values::default()) {
            Some(parts) => Self { figures: Values::of(parts), ..self },
            None => self,
        }
    }
}

/// Interventions of the emergency brake in all rows.
pub fn interventions(rows: &[Row]) -> u64 {
    let of = |row: &Row| row.figures.get(&report::figures::INTERVENTIONS);
    rows.iter().filter_map(of).map(|times| times as u64).sum()
}

/// A cell of the grid, folded over its seeds.
pub struct Point<'a> {
    /// Its runs; the first stands for all.
    pub rows: &'a [Row],
    /// Runs that reached the scenario's end.
    pub completed: usize,
    /// The compared figures.
    pub folded: Vec<Folded>,
    /// Least margin of each requirement.
    pub requirements: Vec<RequirementVerdict>,
}

/// The points of rows whose seeds stand together.
pub fn points(rows: &[Row]) -> Vec<Point<'_>> {
    let cell = |row: &Row| (row.scenario.clone(), row.controller.clone(), row.values.clone());
    rows.chunk_by(|a, b| cell(a) == cell(b)).map(Point::of).collect()
}

impl<'a> Point<'a> {
    fn of(rows: &'a [Row]) -> Self {
        let fold = |figure: &'static report::figures::Figure| {
            figure.fold.over(rows.iter().map(|row| row.figures.get(figure)))
        };
        let verdicts = rows.iter().map(|row| (String::new(), row.requirements.as_slice()));
        let least = verdicts::least(verdicts).into_iter().map(|least| least.verdict);
        Self {
            rows,
            completed: rows.iter().filter(|row| row.outcome == Outcome::Completed).count(),
            folded: compared().map(fold).collect(),
            requirements: least.collect(),
        }
    }

    pub fn figures(&self, of: impl Fn(&Folded) -> Value) -> Map<String, Value> {
        let names = compared().map(|figure| figure.name.to_owned());
        names.zip(self.folded.iter().map(of)).collect()
    }

    /// The row for people. A mean has its spread, and its n where the figure does not apply in every run; `all_means`
    /// shows means of the other figures too.
    pub fn shown(&self, all_means: bool) -> Map<String, Value> {
        let mut shown = Map::new();
        for (figure, Folded { value, spread }) in compared().zip(&self.folded) {
            let n = (spread.n != self.rows.len()).then_some(spread.n);
            let is_mean = all_means || (figure.fold == Fold::Mean && spread.deviation.is_some());
            let cell = match spread.mean.filter(|_| is_mean) {
                Some(mean) => json!({"mean": mean, "deviation": spread.deviation, "n": n}),
                None => json!(value),
            };
            shown.insert(figure.name.to_owned(), cell);
        }
        let ended = print::outcomes(self.rows.iter().map(|row| row.outcome));
        let ok = self.completed == self.rows.len();
        shown.insert("ended".to_owned(), json!({"text": ended, "ok": ok}));
        shown.insert("margins".to_owned(), json!(verdicts::words(&self.requirements)));
        shown
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use report::figures::{
        INTERVENTIONS, MEDIAN_TIME_GAP_S, MIN_GAP_M, MIN_TIME_GAP_S, RMS_GAP_ERROR_M,
    };
    use report::{Following, Trip};
    use supervise::report::ControlFigures;

    /// A row of a car: without fuel, and without deadlines, since it was driven in lockstep.
    pub fn row(controller: &str, seed: u64, min_gap_m: f64) -> Row {
        let figures = Values::default()
            .with(&MIN_GAP_M, min_gap_m)
            .with(&RMS_GAP_ERROR_M, 0.5)
            .with(&MIN_TIME_GAP_S, 1.25)
            .with(&MEDIAN_TIME_GAP_S, 1.5)
            .with(&INTERVENTIONS, 2.0);
        Row {
            scenario: "following".into(),
            controller: controller.into(),
            seed,
            mode: "lockstep".into(),
            values: Vec::new(),
            outcome: Outcome::Completed,
            aborted_because: None,
            requirements: Vec::new(),
            figures,
            parts: Some(parts()),
        }
    }

    fn parts() -> Parts {
        Parts {
            control: Control {
                figures: ControlFigures::default(),
                following: Following::default(),
                trip: Trip::default(),
                mode_changes: None,
            },
            timing: Timing::default(),
            aebs: Braking { interventions: Some(3), ..Braking::default() },
            law: None,
        }
    }

    #[test]
    fn rows_of_a_caller_have_the_figures_of_their_parts() {
        let figures = Values::default();
        let rows = vec![Row { figures, ..row("a", 1, 0.0) }];
        let rows = Row::read(&serde_json::to_string(&rows).expect("plain data")).expect("rows");
        assert_eq!(rows[0].figures.get(&INTERVENTIONS), Some(3.0));
        assert_eq!(interventions(&rows), 3);
    }
}

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
