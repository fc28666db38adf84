//! Reasons why a record is not read.

use crate::error::ScenarioError;

/// Reason why a record is not read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordedError {
    /// A key does not fit the file.
    #[error("{key}: {message}, expected {expected}")]
    Key {
        /// Key of `profile.csv`.
        key: &'static str,
        /// The fault.
        message: String,
        /// The right form.
        expected: String,
    },
    /// Something in the file is wrong.
    #[error(transparent)]
    File(#[from] ScenarioError),
}

impl RecordedError {
    pub(super) fn key(
        key: &'static str,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Key { key, message: message.into(), expected: expected.into() }
    }
}
