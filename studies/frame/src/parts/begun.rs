//! Runs that have begun and not ended: the values that they have computed so far.
//!
//! A run may be thousands of drives. Its line in the journal comes at its end, and an interrupt would lose all of them.
//! So such a run keeps its values here as they come (`Crew::keep`), and gets them back when it begins again. Numbers
//! are kept as their bits: the run must go on as if it had not been interrupted.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use supervise::Error;

use super::journal::Journal;
use crate::drives::{Drive, ExactDrive};

/// Name of the file in a part's directory.
pub(super) const FILE: &str = "begun.jsonl";

/// A line: values of a run, and the figures of the drives since the line before.
#[derive(Serialize, Deserialize)]
struct Line {
    run: usize,
    values: Vec<u64>,
    drives: Vec<ExactDrive>,
}

/// Results of an interrupted run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SoFar {
    pub values: Vec<f64>,
    pub drives: Vec<Drive>,
}

/// The file of a part; without a directory nothing is kept. The file begins with the first value.
#[derive(Default)]
pub(crate) struct Begun {
    directory: Option<PathBuf>,
    journal: Mutex<Option<Journal>>,
}

impl Begun {
    /// Opens the file of a part, with what it holds.
    pub fn open(directory: &Path) -> Result<(Self, BTreeMap<usize, SoFar>), Error> {
        let mut runs: BTreeMap<usize, SoFar> = BTreeMap::new();
        let own = Self { directory: Some(directory.to_owned()), journal: Mutex::default() };
        if !directory.join(FILE).exists() {
            return Ok((own, runs));
        }
        let journal = Journal::open(directory, FILE, &mut |_, line: Line| {
            let so_far = runs.entry(line.run).or_default();
            so_far.values.extend(line.values.into_iter().map(f64::from_bits));
            so_far.drives.extend(line.drives.into_iter().map(Drive::from));
            Ok(())
        })?;
        Ok((Self { journal: Mutex::new(Some(journal)), ..own }, runs))
    }

    pub fn keep(&self, run: usize, values: &[f64], drives: &[Drive]) -> Result<(), Error> {
        let Some(directory) = &self.directory else { return Ok(()) };
        let values = values.iter().map(|value| value.to_bits()).collect();
        let drives = drives.iter().cloned().map(ExactDrive::from).collect();
        let mut journal = self.journal.lock().expect("no worker panics here");
        let journal = match &mut *journal {
            Some(journal) => journal,
            none => none.insert(Journal::open(directory, FILE, &mut |_, _: Line| Ok(()))?),
        };
        journal.add(&Line { run, values, drives }).map(drop)
    }
}

/// Removes the file of a part whose runs have all ended.
pub(crate) fn remove(directory: &Path) {
    // It may not be there, and a file that stays is of no use and no harm.
    let _ = std::fs::remove_file(directory.join(FILE));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_to_the_last_bit() {
        let directory = std::env::temp_dir().join(format!("begun-{}", std::process::id()));
        std::fs::create_dir_all(&directory).expect("writable");
        let (begun, empty) = Begun::open(&directory).expect("new");
        assert!(empty.is_empty());
        let values = [1.0 / 3.0, f64::NEG_INFINITY, -0.0, 5e-324];
        let drive = Drive::with_figures(vec![Some(0.1 + 0.2), None]);
        begun.keep(4, &values[..2], std::slice::from_ref(&drive)).expect("writable");
        begun.keep(2, &[7.0], &[]).expect("writable");
        begun.keep(4, &values[2..], &[]).expect("writable");
        drop(begun);
        // A line that was cut off.
        let path = directory.join(FILE);
        let text = std::fs::read_to_string(&path).expect("written");
        std::fs::write(&path, format!("{text}{{\"run\":4,")).expect("writable");
        let (_, runs) = Begun::open(&directory).expect("readable");
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&runs[&4].values), bits(&values));
        assert_eq!((&runs[&4].drives, &runs[&2].values), (&vec![drive], &vec![7.0]));
        std::fs::remove_dir_all(&directory).expect("ours");
    }
}
