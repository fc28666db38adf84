//! The records of a study's runs: in memory, or in journals.
//!
//! A study may have a million runs. With a journal, memory holds only the place of each line.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use group::Error;
use serde::de::DeserializeOwned;

use super::Line;
use super::journal::{JournalError, Place};
use crate::drives::Drive;

/// The records of a study, by the numbers of their runs.
#[derive(Debug)]
pub struct Records<T> {
    runs: Vec<Entry<T>>,
    journals: Vec<PathBuf>,
    count: usize,
}

#[derive(Debug)]
enum Entry<T> {
    None,
    /// Boxed: the others are small, and there may be a million of them.
    Memory(Box<Line<T>>),
    /// Journal, and place in it.
    Journal(u32, Place),
}

impl<T> Records<T> {
    /// No record yet of `runs` runs.
    #[must_use]
    pub fn new(runs: usize) -> Self {
        let runs = std::iter::repeat_with(|| Entry::None).take(runs).collect();
        Self { runs, journals: Vec::new(), count: 0 }
    }

    /// Number of records.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// True if the run has one.
    #[must_use]
    pub fn has(&self, run: usize) -> bool {
        !matches!(self.runs.get(run), None | Some(Entry::None))
    }

    /// Keeps a record in memory.
    pub(crate) fn keep(&mut self, line: Line<T>) {
        let run = line.run;
        self.runs[run] = Entry::Memory(Box::new(line));
        self.count += 1;
    }

    /// The records added from now on are in this journal.
    pub(crate) fn begin(&mut self, journal: &Path) {
        self.journals.push(journal.to_owned());
    }

    /// Keeps the place of a record in the present journal. `is_mine` says whether the run is of the part that the
    /// journal belongs to.
    ///
    /// # Errors
    /// [`JournalError`] if the run belongs to another part, or is there twice.
    pub(crate) fn add(
        &mut self,
        run: usize,
        place: Place,
        is_mine: bool,
    ) -> Result<(), JournalError> {
        let journal = self.journals.len() - 1;
        let path = || self.journals[journal].clone();
        match self.runs.get(run) {
            Some(Entry::None) if is_mine => {}
            Some(Entry::Memory(_) | Entry::Journal(..)) if is_mine => {
                return Err(JournalError::Twice { path: path(), run });
            }
            _ => return Err(JournalError::OtherPart { path: path(), run }),
        }
        self.runs[run] = Entry::Journal(u32::try_from(journal).expect("few journals"), place);
        self.count += 1;
        Ok(())
    }
}

impl<T: DeserializeOwned> Records<T> {
    /// Hands over all records in the order of the runs, as often as it is called.
    ///
    /// # Errors
    /// If a journal cannot be read, or what `take` returns.
    pub fn each(&self, take: &mut dyn FnMut(usize, &T) -> Result<(), Error>) -> Result<(), Error> {
        self.each_line(&mut |run, line| take(run, &line.result))
    }

    fn each_line(
        &self,
        take: &mut dyn FnMut(usize, &Line<T>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut reader = Reader { journals: &self.journals, opened: None, bytes: Vec::new() };
        for (run, entry) in self.runs.iter().enumerate() {
            match entry {
                Entry::None => {}
                Entry::Memory(line) => take(run, line)?,
                Entry::Journal(journal, place) => {
                    take(run, &reader.read::<T>(*journal, *place)?)?;
                }
            }
        }
        Ok(())
    }

    /// Hands over all drives in the order of the runs, each with the record of its run.
    ///
    /// # Errors
    /// If a journal cannot be read, or what `take` returns.
    pub(crate) fn each_drive(
        &self,
        take: &mut dyn FnMut(usize, &T, &Drive) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.each_line(&mut |run, line| {
            line.drives.iter().try_for_each(|drive| take(run, &line.result, drive))
        })
    }

    /// All records with the numbers of their runs, in memory.
    ///
    /// # Errors
    /// If a journal cannot be read.
    pub fn all(self) -> Result<Vec<(usize, T)>, Error> {
        let mut reader = Reader { journals: &self.journals, opened: None, bytes: Vec::new() };
        let mut all = Vec::with_capacity(self.count);
        for (run, entry) in self.runs.into_iter().enumerate() {
            match entry {
                Entry::None => {}
                Entry::Memory(line) => all.push((run, line.result)),
                Entry::Journal(journal, place) => {
                    all.push((run, reader.read::<T>(journal, place)?.result));
                }
            }
        }
        Ok(all)
    }
}

/// Reads lines of journals, one open file at a time. A study of many parts has more journals than a process may have
/// files.
struct Reader<'a> {
    journals: &'a [PathBuf],
    opened: Option<(u32, File)>,
    bytes: Vec<u8>,
}

impl Reader<'_> {
    fn read<T: DeserializeOwned>(&mut self, journal: u32, place: Place) -> Result<Line<T>, Error> {
        let path = &self.journals[journal as usize];
        let error = |reason| Error::Path { action: "read", path: path.clone(), reason };
        let (_, file) = match self.opened.take().filter(|(of, _)| *of == journal) {
            Some(same) => self.opened.insert(same),
            None => self.opened.insert((journal, File::open(path).map_err(error)?)),
        };
        self.bytes.resize(place.length, 0);
        let read = file.read_exact_at(&mut self.bytes, place.offset);
        let line = read.and_then(|()| Ok(serde_json::from_slice::<Line<T>>(&self.bytes)?));
        line.map_err(error)
    }
}
