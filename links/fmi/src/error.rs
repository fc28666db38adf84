//! Why a unit cannot be used.

/// A unit that cannot be used: the file and its part, the fault, and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {fault}, expected {expected}")]
pub struct UnitError {
    /// The file, or a file inside it.
    pub place: String,
    /// The fault.
    pub fault: String,
    /// The right form.
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
