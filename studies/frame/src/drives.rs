//! `runs.csv`: the summary figures of every drive of a study, as one tidy table.
//!
//! A row is a drive. Columns: `run`, `scenario`, `law`, `seed`, the keys that the study varies, `outcome`,
//! `duration_s`. The study's own columns follow ([`Study::OWN_COLUMNS`](crate::Study::OWN_COLUMNS)), then the
//! [`report::figures`]. A figure that does not apply is empty. A run of a study may be several drives, which then have a
//! key of their own. The figures are kept with the run's record, so that a study in parts has the same table.
//!
//! ```text
//! run,scenario,law,seed,runtime.extra_delay_ms,outcome,duration_s,min_gap_m,...
//! 0,cut-in,acc-mpc,1,0,completed,40,12.3,...
//! ```

use report::figures::{self, Values};
use report::output::OutputDirectory;
use report::results::{Column, csv_fields, csv_names, field};
use report::table::csv_row;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use supervise::Error;
use supervise::report::Outcome;

use crate::keep::Key;
use report::summary::Summary;

pub const FILE: &str = "runs.csv";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Drive {
    scenario: String,
    law: String,
    seed: u64,
    /// Values of the study's keys.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    keys: Vec<String>,
    outcome: Outcome,
    duration_s: f64,
    /// In the order of [`figures::ALL`].
    figures: Vec<Option<f64>>,
}

/// A drive whose figures are kept as their bits: a number that JSON gives back may differ in its last digit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ExactDrive {
    /// Without its figures.
    drive: Drive,
    figures: Vec<Option<u64>>,
}

impl From<Drive> for ExactDrive {
    fn from(mut drive: Drive) -> Self {
        let figures = std::mem::take(&mut drive.figures);
        Self { drive, figures: figures.into_iter().map(|one| one.map(f64::to_bits)).collect() }
    }
}

impl From<ExactDrive> for Drive {
    fn from(ExactDrive { drive, figures }: ExactDrive) -> Self {
        let figures = figures.into_iter().map(|one| one.map(f64::from_bits)).collect();
        Self { figures, ..drive }
    }
}

impl Drive {
    pub(crate) fn of(scenario: &Scenario, keys: &[(String, String)], summary: &Summary) -> Self {
        Self {
            scenario: scenario.name.as_str().to_owned(),
            law: summary.controller.clone(),
            seed: summary.seed,
            keys: keys.iter().map(|(_, value)| value.clone()).collect(),
            outcome: summary.outcome,
            duration_s: summary.duration_s,
            figures: Values::of(summary).0.to_vec(),
        }
    }

    /// A drive with these figures and nothing else.
    #[cfg(test)]
    pub(crate) fn with_figures(figures: Vec<Option<f64>>) -> Self {
        let (scenario, law) = ("a".to_owned(), "b".to_owned());
        let (keys, outcome) = (Vec::new(), Outcome::Completed);
        Self { scenario, law, seed: 1, keys, outcome, duration_s: 1.0, figures }
    }

    /// A line of the table; `own` are the study's own fields.
    fn line(&self, run: usize, own: Vec<String>) -> Vec<u8> {
        let outcome = serde_json::to_value(self.outcome).expect("an outcome is a word");
        let number = |value: Option<f64>| field(&value.map_or(Value::Null, Value::from));
        let names =
            [run.to_string(), self.scenario.clone(), self.law.clone(), self.seed.to_string()];
        let ends = [field(&outcome), number(Some(self.duration_s))];
        let figures = self.figures.iter().map(|figure| number(*figure));
        let keys = self.keys.iter().cloned();
        csv_row(names.into_iter().chain(keys).chain(ends).chain(own).chain(figures))
    }
}

/// The line of the names; `keys` and `own` are those of the study.
fn head(keys: &[Key], own: Vec<&str>) -> Vec<u8> {
    let keys = keys.iter().map(|key| key.name.as_str());
    let figures = figures::ALL.iter().map(|figure| figure.name);
    let names = ["run", "scenario", "law", "seed"].into_iter().chain(keys);
    csv_row(names.chain(["outcome", "duration_s"]).chain(own).chain(figures))
}

/// Takes a drive, with the number and the record of its run.
type Take<'a, R> = &'a mut dyn FnMut(usize, &R, &Drive) -> Result<(), Error>;

/// Writes the table of all drives, which `each` hands over; no file without any.
pub(crate) fn write<R: Serialize>(
    each: &dyn Fn(Take<'_, R>) -> Result<(), Error>,
    keys: &[Key],
    own: &[Column<R>],
    output: &OutputDirectory,
) -> Result<(), Error> {
    let mut is_empty = true;
    each(&mut |_, _, _| {
        is_empty = false;
        Ok(())
    })?;
    if is_empty {
        return Ok(());
    }
    output.write_by(FILE, |file| {
        file.add(&head(keys, csv_names(own).collect()))?;
        each(&mut |run, record, drive| {
            file.add(&drive.line(run, csv_fields(own, record).collect()))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_a_field_for_each_name() {
        let keys = [Key { name: "controller.time_headway_s".to_owned(), is_number: false }];
        let drive = Drive {
            scenario: "cut-in".to_owned(),
            law: "mine".to_owned(),
            seed: 7,
            keys: vec!["1,5".to_owned()],
            outcome: Outcome::RedLight,
            duration_s: 12.5,
            figures: Values::default().with(&figures::MAX_ABS_GAP_ERROR_M, 0.25).0.to_vec(),
        };
        let own = vec!["a, b".to_owned()];
        let lines = [head(&keys, vec!["fault"]), drive.line(3, own)].concat();
        let text = String::from_utf8(lines).expect("text");
        assert!(
            text.starts_with("run,scenario,law,seed,controller.time_headway_s,outcome,"),
            "{text}"
        );
        assert!(
            text.contains("\n3,cut-in,mine,7,\"1,5\",red_light,12.5,\"a, b\",,0.25,,"),
            "{text}"
        );
        let fields: Vec<usize> = text
            .replace("1,5", "1")
            .replace("a, b", "a")
            .lines()
            .map(|line| line.split(',').count())
            .collect();
        assert_eq!(fields, [8 + figures::COUNT; 2]);
    }
}
