//! Why a directory takes no results.

use std::path::PathBuf;
use supervise::Failure;

/// Reason why a directory is not used for results.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// It is another command's.
    #[error(
        "{} belongs to a command that is still running: choose another directory", path.display()
    )]
    InUse { path: PathBuf },
    /// Results of an earlier command are in it.
    #[error(
        "{} holds results ({first}): choose another directory, or add --force to replace them",
        path.display()
    )]
    HoldsResults { path: PathBuf, first: &'static str },
    /// Its results were not begun in parts.
    #[error(
        "{} holds results ({first}) but no {expected}: nothing in it can be gone on with, choose another directory",
        path.display()
    )]
    NotBegun {
        path: PathBuf,
        first: &'static str,
        /// The file that says what was begun.
        expected: &'static str,
    },
}

impl Failure for OutputError {}
