//! Why a command failed, and the exit status that says so.

use runtime::RuntimeError;
use std::path::PathBuf;
use std::process::ExitCode;

/// A command's failure.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad usage or a bad file.
    #[error("{0}")]
    Usage(String),
    /// A file or directory of the user's cannot be used.
    #[error("cannot {action} {}: {reason}", path.display())]
    Path {
        /// What was tried.
        action: &'static str,
        /// On what.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// The machine would not let it run.
    #[error("{0}")]
    Machine(String),
    /// A service did not come up.
    #[error("{service} {what}")]
    NotReady {
        /// The service.
        service: messages::Service,
        /// What it did instead.
        what: String,
    },
    /// The run's shared memory is not usable.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// Ctrl-C or SIGTERM before there was a result.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Exit status as promised by `--help`.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Usage(_) | Self::Path { .. } => 2,
            Self::Machine(_) | Self::NotReady { .. } | Self::Runtime(_) => 3,
            Self::Interrupted => 130,
        })
    }
}
