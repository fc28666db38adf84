//! `runs.csv`: the summary figures of every drive of a study, as one tidy table.
//!
//! A row is a drive. Columns: `run`, `scenario`, `law`, `seed`, the keys that the study varies, `outcome`,
//! `duration_s`. Figures of `summary.json` follow, by their names there. A figure that does not apply is empty. A run
//! of a study may be several drives, which then have a key of their own. The figures are kept with the run's record, so
//! that a study in parts has the same table.
//!
//! ```text
//! run,scenario,law,seed,runtime.extra_delay_ms,outcome,duration_s,min_gap_m,...
//! 0,cut-in,acc-mpc,1,0,completed,40,12.3,...
//! ```

mod figures;

use group::Error;
use group::report::Outcome;
use report::output::OutputDirectory;
use report::results::field;
use report::table::csv_row;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::keep::Key;
use figures::FIGURES;
use report::summary::Summary;

/// Name of the file.
pub const FILE: &str = "runs.csv";

/// The figures of a drive.
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
    /// In the order of [`FIGURES`].
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
            figures: FIGURES.iter().map(|(_, of)| of(summary)).collect(),
        }
    }

    /// A drive with these figures and nothing else.
    #[cfg(test)]
    pub(crate) fn with_figures(figures: Vec<Option<f64>>) -> Self {
        let (scenario, law) = ("a".to_owned(), "b".to_owned());
        let (keys, outcome) = (Vec::new(), Outcome::Completed);
        Self { scenario, law, seed: 1, keys, outcome, duration_s: 1.0, figures }
    }

    fn line(&self, run: usize) -> Vec<u8> {
        let outcome = serde_json::to_value(self.outcome).expect("an outcome is a word");
        let number = |value: Option<f64>| field(&value.map_or(Value::Null, Value::from));
        let names =
            [run.to_string(), self.scenario.clone(), self.law.clone(), self.seed.to_string()];
        let ends = [field(&outcome), number(Some(self.duration_s))];
        let figures = self.figures.iter().map(|figure| number(*figure));
        csv_row(names.into_iter().chain(self.keys.iter().cloned()).chain(ends).chain(figures))
    }
}

/// The line of the names; `keys` are those of the study.
fn head(keys: &[Key]) -> Vec<u8> {
    let keys = keys.iter().map(|key| key.name.as_str());
    let figures = FIGURES.iter().map(|(name, _)| *name);
    let names = ["run", "scenario", "law", "seed"].into_iter().chain(keys);
    csv_row(names.chain(["outcome", "duration_s"]).chain(figures))
}

/// Takes a drive of the run with this number.
pub(crate) type Take<'a> = &'a mut dyn FnMut(usize, &Drive) -> Result<(), Error>;

/// Writes the table of all drives, which `each` hands over; no file without any.
///
/// # Errors
/// If a journal cannot be read, or the file cannot be written.
pub(crate) fn write(
    each: &dyn Fn(Take<'_>) -> Result<(), Error>,
    keys: &[Key],
    output: &OutputDirectory,
) -> Result<(), Error> {
    let mut is_empty = true;
    each(&mut |_, _| {
        is_empty = false;
        Ok(())
    })?;
    if is_empty {
        return Ok(());
    }
    output.write_by(FILE, |file| {
        file.add(&head(keys))?;
        each(&mut |run, drive| file.add(&drive.line(run)))
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
            figures: FIGURES
                .iter()
                .enumerate()
                .map(|(place, _)| (place == 1).then_some(0.25))
                .collect(),
        };
        let text = String::from_utf8([head(&keys), drive.line(3)].concat()).expect("text");
        assert!(
            text.starts_with("run,scenario,law,seed,controller.time_headway_s,outcome,"),
            "{text}"
        );
        assert!(text.contains("\n3,cut-in,mine,7,\"1,5\",red_light,12.5,,0.25,,"), "{text}");
        let fields: Vec<usize> =
            text.replace("1,5", "1").lines().map(|line| line.split(',').count()).collect();
        assert_eq!(fields, [7 + FIGURES.len(); 2]);
    }
}
