//! A part under way.

use std::collections::{BTreeMap, BTreeSet};

use group::Error;
use report::output::{OutputDirectory, OutputOptions};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::begun::{self, Begun, SoFar};
use super::journal::{self, Journal, JournalError};
use super::{
    FILE, Line, PartError, PartFile, PartOptions, Records, Shard, ShardChoice, Study, read_file,
};
use crate::batch::{ProcessesSample, Repetition};
use crate::drives::Drive;

/// A part under way: its journal and what is left to do.
pub struct Part<T> {
    shard: Option<Shard>,
    study: Study,
    journal: Option<Journal>,
    begun: Begun,
    so_far: BTreeMap<usize, SoFar>,
    records: Records<T>,
    sample: ProcessesSample,
}

impl<T: Serialize + DeserializeOwned> Part<T> {
    /// Opens the directory of a part, or of the whole study. `name` is for a directory that the command names itself.
    /// Without the options of parts no run is written before the end, unless there are too many records for memory.
    ///
    /// # Errors
    /// [`ArrayJobError`](super::ArrayJobError), [`PartError`], [`JournalError`], or a file cannot be read or written.
    pub fn open(
        name: &str,
        options: &PartOptions,
        output: &OutputOptions,
        study: Study,
        keeps_journal: bool,
    ) -> Result<(Self, OutputDirectory), Error> {
        let shard = options.shard.map(ShardChoice::resolve).transpose()?;
        let directory = match &options.resume {
            Some(path) => OutputDirectory::resume(path, FILE)?,
            None => OutputDirectory::create(output, name)?,
        };
        let records = Records::new(study.runs);
        let sample = ProcessesSample::default();
        let (begun, so_far) = Default::default();
        let mut part = Self { shard, journal: None, begun, so_far, records, sample, study };
        if shard.is_some() || options.resume.is_some() || keeps_journal {
            part.begin(&directory)?;
        }
        Ok((part, directory))
    }

    fn begin(&mut self, directory: &OutputDirectory) -> Result<(), Error> {
        let path = directory.path().join(FILE);
        let own = PartFile { study: self.study.clone(), shard: self.shard };
        if path.exists() {
            if read_file(&path)? != own {
                return Err(PartError::OtherStudy(directory.path().to_owned()).into());
            }
        } else {
            let text = serde_json::to_string_pretty(&own).expect("plain data") + "\n";
            directory.write(FILE, text.as_bytes())?;
        }
        let Self { records, sample, shard, .. } = self;
        records.begin(&directory.path().join(journal::FILE));
        let mut each = |place, line| Ok(take::<T>(records, sample, *shard, place, line)?);
        self.journal = Some(Journal::open(directory.path(), journal::FILE, &mut each)?);
        (self.begun, self.so_far) = Begun::open(directory.path())?;
        self.so_far.retain(|run, _| !self.records.has(*run));
        Ok(())
    }

    /// The records so far.
    pub fn records(&self) -> &Records<T> {
        &self.records
    }

    /// The file of runs that have begun, with what those of an earlier command had computed.
    pub(crate) fn take_begun(&mut self) -> (Begun, BTreeMap<usize, SoFar>) {
        (std::mem::take(&mut self.begun), std::mem::take(&mut self.so_far))
    }

    /// All runs have ended: what they had computed before is of no more use.
    pub(crate) fn end(&self, directory: &OutputDirectory) {
        if self.journal.is_some() {
            begun::remove(directory.path());
        }
    }

    /// The runs of this part that are left to do.
    pub fn left(&self) -> Vec<usize> {
        self.mine().filter(|run| !self.records.has(*run)).collect()
    }

    /// The runs of this part.
    pub fn mine(&self) -> impl Iterator<Item = usize> {
        (0..self.study.runs).filter(|run| holds(self.shard, *run))
    }

    /// Part of the study; `None` is the whole.
    pub fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// Runs of this part.
    pub fn runs(&self) -> usize {
        self.mine().count()
    }

    /// The runs of the whole study that are repeated in process groups.
    pub(crate) fn sampled(&self, seed: u64) -> BTreeSet<usize> {
        crate::batch::choose(seed, self.study.runs)
    }

    /// Keeps the record of a run with the figures of its drives.
    ///
    /// # Errors
    /// If the journal cannot be written.
    pub(crate) fn keep(
        &mut self,
        run: usize,
        result: T,
        drives: Vec<Drive>,
        repetition: Option<&Repetition>,
    ) -> Result<(), Error> {
        let same_in_processes = repetition.map(|repetition| *repetition == Repetition::Same);
        let line = Line { run, same_in_processes, drives, result };
        self.sample.count(run, repetition);
        match &mut self.journal {
            Some(journal) => Ok(self.records.add(run, journal.add(&line)?, true)?),
            None => {
                self.records.keep(journal::as_read_back(&line));
                Ok(())
            }
        }
    }

    /// Prints the command that continues runs which ended early.
    pub(crate) fn print_how_to_continue(&self, directory: &OutputDirectory) {
        if self.journal.is_some() {
            let (done, all) = (self.records.len(), self.runs());
            let command = self.study.resume(directory.path());
            eprintln!("{done} of {all} runs are kept; to continue: {command}");
        }
    }

    /// The records of the runs, and the result of the repeated ones.
    pub fn into_records(self) -> (Records<T>, ProcessesSample) {
        (self.records, self.sample)
    }
}

/// True if a run belongs to a part. Nothing else decides it.
pub(crate) fn holds(shard: Option<Shard>, run: usize) -> bool {
    shard.is_none_or(|shard| shard.holds(run))
}

/// Takes a line of the journal of a part.
pub(crate) fn take<T>(
    records: &mut Records<T>,
    sample: &mut ProcessesSample,
    shard: Option<Shard>,
    place: journal::Place,
    line: Line<T>,
) -> Result<(), JournalError> {
    records.add(line.run, place, holds(shard, line.run))?;
    let repetition = line.same_in_processes.map(Repetition::of_same);
    sample.count(line.run, repetition.as_ref());
    Ok(())
}
