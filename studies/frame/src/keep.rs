//! `--keep`: trajectories of a study's runs, in one Parquet file.
//!
//! ```text
//! run ends ─► offer (its steps as columns) ─► settle ─► row groups, in the order of the runs
//! ```
//!
//! A row is a step of a drive. Columns: `run`, `scenario`, `law`, `seed`, the keys that the study varies, then those of
//! `trajectory.csv`. The law's own figures follow by their place, from `figure_0` on. The file's metadata has their
//! names, as `figures.LAW`.

use parquet_writer::{Cells, Writer};
use report::output::OutputDirectory;
use report::summary::Summary;
use report::trajectory::{COLUMNS, LATER, StepColumn};
use scenario::Scenario;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs::File;
use std::io::{self, BufWriter};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Mutex;
use supervise::report::Outcome;
use supervise::{Drive, DriveStep, Error};

pub const FILE: &str = "trajectories.parquet";

/// The drives whose trajectories are kept.
///
/// ```
/// use frame::keep::Keep;
///
/// assert_eq!("worst:3".parse::<Keep>().unwrap(), Keep::Worst(3.try_into().unwrap()));
/// assert!("best:3".parse::<Keep>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    All,
    /// Drives that did not end as completed.
    Failures,
    /// This number of drives, those with the smallest gaps.
    Worst(NonZeroUsize),
}

impl FromStr for Keep {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, &'static str> {
        match text {
            "all" => Ok(Self::All),
            "failures" => Ok(Self::Failures),
            _ => {
                let count = text.strip_prefix("worst:").and_then(|count| count.parse().ok());
                count
                    .map(Self::Worst)
                    .ok_or("expected all, failures or worst:N with N of 1 or more")
            }
        }
    }
}

/// The trajectory of a run.
struct Kept {
    cells: Vec<Cells>,
    failed: bool,
    /// Smallest gap, m; infinite without a vehicle ahead.
    gap_m: f64,
    figures: Option<(String, String)>,
}

/// Takes the trajectories of runs as they end, and writes those that are to be kept.
pub(crate) struct Keeper {
    keep: Keep,
    path: PathBuf,
    keys: Vec<Key>,
    /// Drives that ended, of runs that are not settled. Workers offer them.
    offered: Mutex<BTreeMap<usize, Vec<Kept>>>,
    book: Mutex<Book>,
}

/// The share of the command's own thread.
#[derive(Default)]
struct Book {
    /// Runs that are not settled, in order.
    expected: VecDeque<usize>,
    settled: BTreeSet<usize>,
    /// Drives of settled runs that are written when all before them are settled, or at the end. They stand by the
    /// number of the run, and their place in it.
    waiting: BTreeMap<(usize, usize), Kept>,
    writer: Option<Writer<BufWriter<File>>>,
    written: usize,
}

impl Keeper {
    /// Begins for the runs `left` of a study with these keys. The file begins with the first trajectory.
    pub(crate) fn new(
        keep: Keep,
        output: &OutputDirectory,
        left: &[usize],
        keys: Vec<Key>,
    ) -> Self {
        Self {
            keep,
            path: output.path().join(FILE),
            keys,
            offered: Mutex::default(),
            book: Mutex::new(Book { expected: left.iter().copied().collect(), ..Book::default() }),
        }
    }

    /// Takes the trajectory of a drive of a run, in the worker's thread.
    pub(crate) fn offer(
        &self,
        run: usize,
        scenario: &Scenario,
        values: &[(String, String)],
        summary: &Summary,
        drive: &Drive,
    ) {
        let failed = summary.outcome != Outcome::Completed;
        if self.keep == Keep::Failures && !failed {
            return;
        }
        let law = summary.controller.clone();
        let names = controller::laws::figure_names(scenario);
        let figures = (!names.is_empty()).then(|| (law.clone(), names.join(",")));
        let gap_m = summary.control.figures.min_gap_m.unwrap_or(f64::INFINITY);
        let cells = cells(run, scenario, &law, &self.keys, values, drive);
        let kept = Kept { cells, failed, gap_m, figures };
        let mut offered = self.offered.lock().expect("no worker panics here");
        let drives = offered.entry(run).or_default();
        drives.push(kept);
        // A run may be thousands of drives.
        if let Keep::Worst(most) = self.keep
            && drives.len() > most.get()
        {
            let gap = |place: &usize| drives[*place].gap_m;
            let best = (0..drives.len()).max_by(|a, b| gap(a).total_cmp(&gap(b)));
            drives.remove(best.expect("it is not empty"));
        }
    }

    /// Decides on a run that ended.
    pub(crate) fn settle(&self, run: usize) -> Result<(), Error> {
        let offered = self.offered.lock().expect("no worker panics here").remove(&run);
        let mut book = self.book.lock().expect("one thread settles");
        book.settled.insert(run);
        let drives = offered.into_iter().flatten().enumerate();
        let chosen = drives.filter(|(_, kept)| match self.keep {
            Keep::All | Keep::Worst(_) => true,
            Keep::Failures => kept.failed,
        });
        book.waiting.extend(chosen.map(|(place, kept)| ((run, place), kept)));
        if let Keep::Worst(most) = self.keep {
            while book.waiting.len() > most.get() {
                let gap = |entry: &(&(usize, usize), &Kept)| entry.1.gap_m;
                let best = book.waiting.iter().max_by(|a, b| gap(a).total_cmp(&gap(b)));
                let best = best.map(|(place, _)| *place).expect("it is not empty");
                book.waiting.remove(&best);
            }
            return Ok(());
        }
        // In the order of the runs, so that the file repeats.
        while let Some(next) = book.expected.front().copied()
            && book.settled.remove(&next)
        {
            book.expected.pop_front();
            let behind = book.waiting.split_off(&(next + 1, 0));
            for kept in std::mem::replace(&mut book.waiting, behind).into_values() {
                self.write(&mut book, &kept)?;
            }
        }
        Ok(())
    }

    /// Writes what is left, also of a study that was interrupted. Returns the number of trajectories.
    pub(crate) fn finish(&self) -> Result<usize, Error> {
        let mut book = std::mem::take(&mut *self.book.lock().expect("one thread settles"));
        for (_, kept) in std::mem::take(&mut book.waiting) {
            self.write(&mut book, &kept)?;
        }
        if let Some(writer) = book.writer {
            writer.finish().map_err(Error::path("write", &self.path))?;
        }
        Ok(book.written)
    }

    fn write(&self, book: &mut Book, kept: &Kept) -> Result<(), Error> {
        let mut write = || -> io::Result<()> {
            if book.writer.is_none() {
                let names = names(&self.keys);
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let file = BufWriter::new(File::create(&self.path)?);
                book.writer = Some(Writer::new(file, &names, &[])?);
            }
            let writer = book.writer.as_mut().expect("it was made above");
            if let Some((law, figures)) = &kept.figures {
                writer.metadata(&format!("figures.{law}"), figures);
            }
            writer.group(&kept.cells)
        };
        write().map_err(Error::path("write", &self.path))?;
        book.written += 1;
        Ok(())
    }
}

/// Figures of the law that a step has room for.
const FIGURES: usize = 8;

/// Names of the columns: of the run with the study's keys, then of a step.
fn names(keys: &[Key]) -> Vec<String> {
    let of_run = ["run", "scenario", "law", "seed"].into_iter().map(str::to_owned);
    let of_step = |columns: &[StepColumn]| -> Vec<String> {
        columns.iter().map(|(name, ..)| (*name).to_owned()).collect()
    };
    let figures = (0..FIGURES).map(|place| format!("figure_{place}"));
    let keys = keys.iter().map(|key| key.name.clone());
    of_run.chain(keys).chain(of_step(&COLUMNS)).chain(figures).chain(of_step(&LATER)).collect()
}

/// A key that the study varies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    pub name: String,
    /// Its values are numbers in all runs.
    pub is_number: bool,
}

/// The keys of a study by those of its runs. A key need not apply in every run.
pub fn keys(runs: impl Iterator<Item = Vec<(String, String)>>) -> Vec<Key> {
    // Each key, and whether numbers and words were seen as its values.
    let mut seen: Vec<(String, bool, bool)> = Vec::new();
    for run in runs {
        if seen.is_empty() {
            seen = run.iter().map(|(name, _)| (name.clone(), false, false)).collect();
        }
        for ((_, number, word), (_, value)) in seen.iter_mut().zip(&run) {
            let is_number = value.parse::<f64>().is_ok();
            *number |= is_number;
            *word |= !is_number && !value.is_empty();
        }
    }
    let key = |(name, number, word): (String, bool, bool)| Key { name, is_number: number && !word };
    seen.into_iter().map(key).collect()
}

/// The cells of a run, in the order of the columns.
fn cells(
    run: usize,
    scenario: &Scenario,
    law: &str,
    keys: &[Key],
    values: &[(String, String)],
    drive: &Drive,
) -> Vec<Cells> {
    let steps = &drive.steps;
    let text = |text: &str| Cells::Text(vec![Some(text.to_owned()); steps.len()]);
    let number =
        |of: &dyn Fn(&DriveStep) -> Option<f64>| Cells::Number(steps.iter().map(of).collect());
    let whole =
        |of: &dyn Fn(&DriveStep) -> Option<i64>| Cells::Integer(steps.iter().map(of).collect());
    let mut cells = vec![
        whole(&|_| Some(run as i64)),
        text(scenario.name.as_str()),
        text(law),
        whole(&|_| i64::try_from(scenario.seed.value()).ok()),
    ];
    cells.extend(keys.iter().zip(values).map(|(key, (_, value))| match key.is_number {
        true => number(&|_| value.parse().ok()),
        false if value.is_empty() => Cells::Text(vec![None; steps.len()]),
        false => text(value),
    }));
    let of_step = |(_, is_whole, value): &StepColumn| match is_whole {
        true => whole(&|step| value(step).map(|value| value as i64)),
        false => number(value),
    };
    cells.extend(COLUMNS.iter().map(of_step));
    cells.extend((0..FIGURES).map(|place| number(&|step| step.figures?.get(place).copied())));
    cells.extend(LATER.iter().map(of_step));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keeper(keep: Keep, name: &str) -> (Keeper, PathBuf) {
        let path = std::env::temp_dir().join(format!("timegap-keep-{name}-{}", std::process::id()));
        let book = Mutex::new(Book { expected: (0..4).collect(), ..Book::default() });
        let keeper =
            Keeper { keep, path: path.clone(), keys: Vec::new(), offered: Mutex::default(), book };
        for (run, gap_m) in [(0, 5.0), (1, 1.0), (2, 9.0), (3, 2.0)] {
            let one = || Cells::Number(vec![Some(gap_m)]);
            let names = names(&[]);
            let cells = names.iter().map(|_| one()).collect();
            let kept = Kept { cells, failed: gap_m < 3.0, gap_m, figures: None };
            keeper.offered.lock().expect("alone").insert(run, vec![kept]);
        }
        // They end in another order.
        for run in [2, 0, 3, 1] {
            keeper.settle(run).expect("writable");
        }
        (keeper, path)
    }

    #[test]
    fn the_chosen_runs_are_written() {
        let two = NonZeroUsize::new(2).expect("not zero");
        for (keep, name, count) in
            [(Keep::All, "all", 4), (Keep::Failures, "failures", 2), (Keep::Worst(two), "worst", 2)]
        {
            let (keeper, path) = keeper(keep, name);
            if keep != Keep::All {
                let book = keeper.book.lock().expect("alone");
                let waiting: Vec<usize> = book.waiting.keys().map(|(run, _)| *run).collect();
                let expected: &[usize] = if keep == Keep::Failures { &[] } else { &[1, 3] };
                assert_eq!(waiting, expected);
            }
            assert_eq!(keeper.finish().expect("writable"), count, "{name}");
            let file = std::fs::read(&path).expect("it was written");
            std::fs::remove_file(&path).expect("it was written");
            assert!(file.ends_with(b"PAR1"));
        }
    }
}
