//! Why a command failed, and the exit status that says so.

use runtime::RuntimeError;
use scenario::ScenarioError;
use scenario::storyboard::OpenError;
use std::path::PathBuf;
use std::process::ExitCode;

pub use super::room::RoomError;
pub use super::root::RootError;

/// A command's failure.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad usage or a bad file.
    #[error("{0}")]
    Usage(String),
    /// The scenario, or an option that changes it, is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The OpenSCENARIO file is wrong, or not of the subset that is read here.
    #[error(transparent)]
    OpenScenario(Box<OpenError>),
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
    /// The machine has no room for a run.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// The run's own directory cannot be made.
    #[error(transparent)]
    Root(#[from] RootError),
    /// A service did not come up.
    #[error("{service} {what}")]
    NotReady {
        /// The service.
        service: messages::Service,
        /// What it did instead.
        what: String,
        /// It is a program of the user's, not one of this program's own services.
        foreign: bool,
    },
    /// The run's shared memory is not usable.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A run in one process and the same run in a process group gave different bytes.
    #[error("{0}")]
    Different(String),
    /// Ctrl-C or SIGTERM before there was a result.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// Exit status as promised by `--help`.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Usage(_)
            | Self::Scenario(_)
            | Self::OpenScenario(_)
            | Self::Path { .. }
            | Self::NotReady { foreign: true, .. } => 2,
            Self::Machine(_)
            | Self::Room(_)
            | Self::Root(_)
            | Self::NotReady { .. }
            | Self::Runtime(_) => 3,
            Self::Different(_) => 1,
            Self::Interrupted => 130,
        })
    }
}
