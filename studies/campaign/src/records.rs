//! The records of a campaign, where its journals have them.
//!
//! A campaign may have a million runs: what stays in memory of each is where its line is.

use super::record::Record;
use frame::parts::journal::{self, Place};
use group::Error;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

/// All records of a campaign, or of a part of it.
#[derive(Debug, Default)]
pub struct Records {
    journals: Vec<PathBuf>,
    places: Vec<RunPlace>,
}

#[derive(Clone, Copy, Debug)]
struct RunPlace {
    run: usize,
    /// Which journal.
    journal: usize,
    place: Place,
}

impl Records {
    /// A journal more; the records that are added from now on are its.
    pub fn begin(&mut self, journal: &Path) {
        self.journals.push(journal.to_owned());
    }

    /// Adds the record of a run.
    pub fn add(&mut self, run: usize, place: Place) {
        let journal = self.journals.len() - 1;
        self.places.push(RunPlace { run, journal, place });
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Hands over all records in the order of the runs.
    ///
    /// # Errors
    /// If a journal cannot be read.
    pub fn each(&mut self, take: &mut dyn FnMut(&Record)) -> Result<(), Error> {
        self.places.sort_unstable_by_key(|place| place.run);
        let error = |path: &Path, reason| {
            let path = path.to_owned();
            Error::Path { action: "read", path, reason }
        };
        // One at a time: a campaign of many shards has more journals than a process may have files.
        let mut opened: Option<(usize, File)> = None;
        let mut line = Vec::new();
        for &RunPlace { journal, place, .. } in &self.places {
            let path = &self.journals[journal];
            let (_, file) = match opened.take().filter(|(of, _)| *of == journal) {
                Some(same) => opened.insert(same),
                None => opened.insert((journal, File::open(path).map_err(|e| error(path, e))?)),
            };
            line.resize(place.length, 0);
            let read = file.read_exact_at(&mut line, place.offset);
            let record = read.and_then(|()| Ok(serde_json::from_slice(&line)?));
            take(&record.map_err(|reason| error(path, reason))?);
        }
        Ok(())
    }
}

/// Reads the journal of a part; `check` refuses runs that are not of it.
///
/// # Errors
/// What `check` refuses, or the journal cannot be read.
pub fn read(
    records: &mut Records,
    journal: &Path,
    check: &mut dyn FnMut(usize) -> Result<(), Error>,
) -> Result<(), Error> {
    records.begin(journal);
    let mut each = |place, record: Record| {
        check(record.run)?;
        records.add(record.run, place);
        Ok(())
    };
    journal::read(journal, &mut each).map(drop)
}
