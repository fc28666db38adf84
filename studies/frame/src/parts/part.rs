//! A part under way.

use std::collections::BTreeMap;

use report::output::OutputDirectory;
use serde::Serialize;
use serde::de::DeserializeOwned;
use supervise::{Error, UsageError};

use super::begun::{self, Begun, SoFar};
use super::file::resume_command;
use super::journal::{self, Journal};
use super::{FILE, Line, PartFile, Records, Shard, holds};
use crate::drives::Drive;

/// A part under way: its journal and what is left to do.
pub struct Part<T> {
    file: PartFile,
    journal: Journal,
    begun: Begun,
    so_far: BTreeMap<usize, SoFar>,
    records: Records<T>,
}

impl<T: Serialize + DeserializeOwned> Part<T> {
    /// Begins a part in its directory, or continues the one that is there.
    pub fn open(file: PartFile, directory: &OutputDirectory) -> Result<Self, Error> {
        let place = directory.path();
        if !place.join(FILE).exists() {
            directory.write_input(FILE, file.text().as_bytes())?;
        } else if PartFile::read(place)? != file {
            let why = "it holds another study, or another part of it";
            return Err(UsageError::at(place.display(), why, "the one that it began with").into());
        }
        let mut records = Records::new(file.runs);
        records.begin(&place.join(journal::FILE));
        let mut each =
            |place, line: Line<T>| records.add(line.run, place, holds(file.shard, line.run));
        let journal = Journal::open(place, journal::FILE, &mut each)?;
        let (begun, mut so_far) = Begun::open(place)?;
        so_far.retain(|run, _| !records.has(*run));
        Ok(Self { file, journal, begun, so_far, records })
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
        begun::remove(directory.path());
    }

    /// A run that has not ended has kept values.
    pub(crate) fn has_begun(&self, directory: &OutputDirectory) -> bool {
        directory.path().join(begun::FILE).exists()
    }

    /// The runs of this part that are left to do.
    pub fn left(&self) -> Vec<usize> {
        self.mine().filter(|run| !self.records.has(*run)).collect()
    }

    fn mine(&self) -> impl Iterator<Item = usize> {
        (0..self.file.runs).filter(|run| holds(self.file.shard, *run))
    }

    /// Part of the study; `None` is the whole.
    pub fn shard(&self) -> Option<Shard> {
        self.file.shard
    }

    pub fn runs(&self) -> usize {
        self.mine().count()
    }

    /// Keeps the record of a run with the figures of its drives.
    pub(crate) fn keep(&mut self, run: usize, result: T, drives: Vec<Drive>) -> Result<(), Error> {
        let place = self.journal.add(&Line { run, drives, result })?;
        self.records.add(run, place, true)
    }

    /// Prints the command that continues runs which ended early.
    pub(crate) fn print_how_to_continue(&self, directory: &OutputDirectory) {
        let (done, all) = (self.records.len(), self.runs());
        let command = resume_command(directory.path());
        eprintln!("{done} of {all} runs are kept; to continue: {command}");
    }

    pub fn into_records(self) -> Records<T> {
        self.records
    }
}
