//! Units of the Functional Mock-up Interface (FMI) 2.0 and 3.0 for co-simulation, as laws and as vehicles.
//!
//! ```text
//! unit.fmu ── archive ─► description ─► wiring: quantities of timegap ↔ variables of the unit
//!                                          │
//! question ─► pipe ─► serve (a process) ─► instance: set, step, get ─► pipe ─► answer
//! ```
//!
//! A unit is foreign code that may crash, hang or end its process. So it runs in a process of its own,
//! `timegap service fmu`, which the controller and the plant host as they host a program of the user's. [`check_law`]
//! and [`check_vehicle`] read a unit without any of its code, before a run begins.
//!
//! Standards: *Functional Mock-up Interface Specification* 2.0.4 and 3.0.1 (Modelica Association).

mod archive;
mod description;
mod instance;
mod measure;
mod quantity;
mod serve;
mod unit;
mod wiring;

pub use archive::pack;
pub use description::Version;
pub use quantity::{Motion, Request};
pub use serve::{ended, run};
pub use unit::platform;

use messages::LawInput;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use unit::Unit;

/// Beginning of the line on standard error with which a unit's process explains its end.
pub const LAST_WORD: &str = "unit failed: ";

/// True if the first word of a command is a unit, not a program.
///
/// ```
/// assert!(fmi::is_unit("models/law.fmu") && !fmi::is_unit("./law"));
/// ```
pub fn is_unit(word: &str) -> bool {
    word.len() > 4 && word.to_ascii_lowercase().ends_with(".fmu")
}

/// Checks that a unit can be a law; `words` are those behind it in its command.
///
/// # Errors
/// Names the part that is wrong.
pub fn check_law(path: &Path, words: &[String]) -> Result<(), UnitError> {
    Unit::<LawInput, _>::read(path, words).map(|_| ())
}

/// Checks that a unit can be a vehicle. True if it begins with the speed that it is given.
///
/// # Errors
/// Names the part that is wrong.
pub fn check_vehicle(path: &Path, words: &[String]) -> Result<bool, UnitError> {
    Unit::<Request, _>::read(path, words).map(|unit| unit.begins_as_given())
}

/// True if the system can run the file at `path`.
pub fn is_executable(path: &Path) -> bool {
    path.metadata().is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o111 != 0)
}

/// The program `name` in the directories of the PATH.
pub fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).map(|place| place.join(name)).find(|file| is_executable(file))
}

/// The words that start a unit's process, without its own: the program `timegap`, and what it is asked for.
///
/// # Errors
/// When this process is another program, and `timegap` is not on the PATH.
pub fn host(part: &str) -> Result<Vec<String>, UnitError> {
    let own = std::env::current_exe().ok().filter(|path| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("timegap"))
    });
    let program: PathBuf = own.or_else(|| on_path("timegap")).ok_or_else(|| {
        UnitError::new("a unit", "the program that runs it is not found", "`timegap` on the PATH")
    })?;
    let program = program.to_string_lossy().into_owned();
    Ok([program, "service".into(), "fmu".into(), part.into()].to_vec())
}

/// A unit that cannot be used: the file and its part, the fault, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {fault}, expected {expected}")]
pub struct UnitError {
    /// The file, or a file inside it.
    pub place: String,
    pub fault: String,
    pub expected: String,
}

impl UnitError {
    pub(crate) fn new(
        place: impl std::fmt::Display,
        fault: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self { place: place.to_string(), fault: fault.into(), expected: expected.into() }
    }
}
