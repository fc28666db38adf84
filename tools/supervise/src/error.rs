//! Why a command failed, and the exit status that says so.

use messages::UnknownService;
use recorder::ReadError;
use runtime::RuntimeError;
use scenario::{Problem, ScenarioError};
use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Meaning of the exit status of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The command has another result than it should have.
    Different = 1,
    /// Bad usage or a bad file.
    Usage = 2,
    /// The machine does not let it run.
    Machine = 3,
}

/// The error of an operation: it says for itself what it means for the command.
pub trait Failure: std::error::Error + Send + Sync + 'static {
    fn status(&self) -> Status {
        Status::Usage
    }
}

impl<E: Failure> From<E> for Error {
    fn from(error: E) -> Self {
        Self::Operation(Arc::new(error))
    }
}

/// A value of the user's that a command cannot use: an option's, or the content of a file.
///
/// ```
/// use supervise::UsageError;
///
/// let error = UsageError::option("--seeds", "0", "no seeds", "a number of 1 or more");
/// assert_eq!(error.to_string(), "--seeds 0: no seeds, expected a number of 1 or more");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {why}, expected {expected}")]
pub struct UsageError {
    /// The option with its value, or the file with its line.
    pub place: String,
    pub why: String,
    /// Values that are accepted.
    pub expected: String,
}

impl UsageError {
    /// A mistake at a place of any kind.
    pub fn at(place: impl Display, why: impl Display, expected: impl Display) -> Self {
        let (place, why) = (place.to_string(), why.to_string());
        Self { place, why, expected: expected.to_string() }
    }

    /// A mistake in the value of an option.
    pub fn option(
        option: &str,
        value: impl Display,
        why: impl Display,
        expected: impl Display,
    ) -> Self {
        Self::at(format_args!("{option} {value}"), why, expected)
    }
}

impl Failure for UsageError {}

/// A step that the machine does not allow.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct MachineError(pub String);

impl MachineError {
    /// The error of a step, from its reason.
    pub fn cannot<E: Display>(step: impl Display) -> impl Fn(E) -> Self {
        move |reason| Self(format!("cannot {step}: {reason}"))
    }
}

impl Failure for MachineError {
    fn status(&self) -> Status {
        Status::Machine
    }
}

impl Failure for drive::RequirementError {}

impl Failure for Problem {}

impl Failure for ReadError {}

impl Failure for UnknownService {}

/// A command's failure.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An operation failed. Not a `Box`, of which a text could be made as well.
    #[error(transparent)]
    Operation(Arc<dyn Failure>),
    /// The scenario, or an option that changes it, is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A file or directory of the user's cannot be used.
    #[error("cannot {action} {}: {reason}", path.display())]
    Path {
        action: &'static str,
        path: PathBuf,
        /// Cause by the system.
        reason: std::io::Error,
    },
    /// A service did not come up.
    #[error("{service} {what}")]
    NotReady {
        service: messages::Service,
        /// Its actual behaviour.
        what: String,
        /// It is a program of the user's, not one of this program's own services.
        foreign: bool,
    },
    /// The run's shared memory is not usable.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// Ctrl-C or SIGTERM before there was a result.
    #[error("interrupted")]
    Interrupted,
}

/// True if the room is used up, or the device failed: the machine's fault, not that of the place's name.
fn is_the_machines(reason: &std::io::Error) -> bool {
    /// A disk that fails, and a terminal that was closed (`EIO`).
    const DEVICE: i32 = rustix::io::Errno::IO.raw_os_error();
    /// `ErrorKind::FileTooLarge`: beyond `ulimit -f`.
    const LIMIT: i32 = rustix::io::Errno::FBIG.raw_os_error();
    matches!(reason.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
        || matches!(reason.raw_os_error(), Some(DEVICE | LIMIT))
}

impl Error {
    /// The error of an action with a file or directory of the user's.
    pub fn path(action: &'static str, path: &Path) -> impl Fn(std::io::Error) -> Self + Copy {
        move |reason| Self::Path { action, path: path.to_owned(), reason }
    }

    /// The text of a small file of the user's: a `what`.
    pub fn text_of(path: &Path, what: &str) -> Result<String, Self> {
        const MAX_BYTES: u64 = 1 << 20;
        let error = Self::path("read", path);
        let found = std::fs::metadata(path).map_err(error)?;
        if !found.is_file() || found.len() > MAX_BYTES {
            let expected = format_args!("a file of at most {MAX_BYTES} bytes");
            return Err(UsageError::at(path.display(), format_args!("no {what}"), expected).into());
        }
        std::fs::read_to_string(path).map_err(error)
    }

    /// Exit status as `--help` states it.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Operation(failure) => failure.status() as u8,
            Self::Path { reason, .. } if is_the_machines(reason) => 3,
            Self::Scenario(_) | Self::Path { .. } | Self::NotReady { foreign: true, .. } => 2,
            Self::NotReady { .. } | Self::Runtime(_) => 3,
            Self::Interrupted => 130,
        })
    }
}
