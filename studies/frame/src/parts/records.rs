//! The records of a study's runs, in their journals.
//!
//! A study may have a million runs: memory holds only the place of each line.

use std::fs::File;
use std::marker::PhantomData;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use supervise::{Error, UsageError};

use super::Line;
use super::journal::Place;
use crate::drives::Drive;

/// The records of a study, by the numbers of their runs.
#[derive(Debug)]
pub struct Records<T> {
    /// Journal of each record, and place in it.
    runs: Vec<Option<(u32, Place)>>,
    journals: Vec<PathBuf>,
    count: usize,
    records: PhantomData<fn() -> T>,
}

impl<T> Records<T> {
    /// No record yet of `runs` runs.
    pub fn new(runs: usize) -> Self {
        Self { runs: vec![None; runs], journals: Vec::new(), count: 0, records: PhantomData }
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// True if the run has one.
    pub fn has(&self, run: usize) -> bool {
        self.runs.get(run).is_some_and(Option::is_some)
    }

    /// The records added from now on are in this journal.
    pub(crate) fn begin(&mut self, journal: &Path) {
        self.journals.push(journal.to_owned());
    }

    /// Keeps the place of a record in the present journal. `is_mine` says whether the run is of the part that the
    /// journal belongs to.
    pub(crate) fn add(&mut self, run: usize, place: Place, is_mine: bool) -> Result<(), Error> {
        let journal = self.journals.len() - 1;
        let why = match self.runs.get(run) {
            Some(None) if is_mine => None,
            Some(Some(_)) if is_mine => Some("is there twice"),
            _ => Some("does not belong to this part"),
        };
        if let Some(why) = why {
            let (path, why) = (self.journals[journal].display(), format_args!("run {run} {why}"));
            return Err(UsageError::at(path, why, "each run of the part once").into());
        }
        self.runs[run] = Some((u32::try_from(journal).expect("few journals"), place));
        self.count += 1;
        Ok(())
    }
}

impl<T: DeserializeOwned> Records<T> {
    /// Hands over all records in the order of the runs, as often as it is called.
    pub fn each(&self, take: &mut dyn FnMut(usize, &T) -> Result<(), Error>) -> Result<(), Error> {
        self.lines(&mut |run, line| take(run, &line.result))
    }

    /// Hands over all drives in the order of the runs, each with the record of its run.
    pub(crate) fn each_drive(
        &self,
        take: &mut dyn FnMut(usize, &T, &Drive) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.lines(&mut |run, line| {
            line.drives.iter().try_for_each(|drive| take(run, &line.result, drive))
        })
    }

    /// All records with the numbers of their runs, in memory.
    pub fn all(self) -> Result<Vec<(usize, T)>, Error> {
        let mut all = Vec::with_capacity(self.count);
        self.lines(&mut |run, line| {
            all.push((run, line.result));
            Ok(())
        })?;
        Ok(all)
    }

    /// Reads the lines, with one open file at a time. A study of many parts has more journals than a process may have
    /// files.
    fn lines(
        &self,
        take: &mut dyn FnMut(usize, Line<T>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut opened: Option<(u32, File)> = None;
        let mut bytes = Vec::new();
        for (run, entry) in self.runs.iter().enumerate() {
            let Some((journal, place)) = *entry else { continue };
            let path = &self.journals[journal as usize];
            let error = Error::path("read", path);
            let (_, file) = match opened.take().filter(|(of, _)| *of == journal) {
                Some(same) => opened.insert(same),
                None => opened.insert((journal, File::open(path).map_err(error)?)),
            };
            bytes.resize(place.length, 0);
            let read = file.read_exact_at(&mut bytes, place.offset);
            let line = read.and_then(|()| Ok(serde_json::from_slice::<Line<T>>(&bytes)?));
            take(run, line.map_err(error)?)?;
        }
        Ok(())
    }
}
