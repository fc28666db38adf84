//! The study that a directory holds a part of.

use std::path::Path;
use std::process::ExitCode;

use supervise::{Error, UsageError};

use super::command::{MergeArguments, ResumeArguments};
use super::{Study, run};
use crate::parts::PartFile;

/// A study as `merge` and `resume` find it: by the name in `part.json`.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    name: &'static str,
    merge: fn(&MergeArguments, PartFile) -> Result<ExitCode, Error>,
    resume: fn(&ResumeArguments, PartFile) -> Result<ExitCode, Error>,
}

impl Entry {
    pub const fn of<S: Study>() -> Self {
        Self { name: S::NAME, merge: run::merge::<S>, resume: run::resume::<S> }
    }
}

/// Joins the parts of one of the `studies`.
pub fn merge(arguments: &MergeArguments, studies: &[Entry]) -> Result<ExitCode, Error> {
    let (entry, part) = find(&arguments.parts[0], studies)?;
    (entry.merge)(arguments, part)
}

/// Goes on with one of the `studies` in its directory.
pub fn resume(arguments: &ResumeArguments, studies: &[Entry]) -> Result<ExitCode, Error> {
    let (entry, part) = find(&arguments.directory, studies)?;
    (entry.resume)(arguments, part)
}

/// The study that a directory holds a part of.
fn find<'a>(directory: &Path, studies: &'a [Entry]) -> Result<(&'a Entry, PartFile), Error> {
    let part = PartFile::read(directory)?;
    let entry = studies.iter().find(|entry| entry.name == part.study);
    let names = || studies.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ");
    let unknown = || {
        let why = format_args!("`{}` is not a study of this version", part.study);
        UsageError::at(directory.display(), why, names())
    };
    Ok((entry.ok_or_else(unknown)?, part))
}
