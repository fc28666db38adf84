//! Reasons why a bag gives no series.

use std::io;

/// Reason why a bag gives no series.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}{}", .expected.as_ref().map_or(String::new(), |form| format!(", expected {form}")))]
pub struct BagError {
    /// Reason of the refusal.
    pub kind: BagFault,
    /// The fault in words.
    pub message: String,
    /// The right form, if it is known.
    pub expected: Option<String>,
}

/// What of a question about a bag is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BagFault {
    /// The file: it is no bag that is read, or it is damaged.
    File,
    /// The topic: it is not there, is empty, or its encoding is not read.
    Topic,
    /// The field: the messages have no such number.
    Field,
}

impl BagError {
    pub(crate) fn file(message: impl Into<String>) -> Self {
        Self { kind: BagFault::File, message: message.into(), expected: None }
    }

    /// The error that a record is shorter than its stated lengths.
    pub(crate) fn malformed() -> Self {
        Self::file("a record in it is not whole")
    }

    /// The error that a chunk cannot be unpacked.
    pub(crate) fn chunk(reason: impl std::fmt::Display) -> Self {
        Self::file(format!("a chunk in it cannot be read: {reason}"))
    }

    pub(crate) fn topic(message: String) -> Self {
        Self { kind: BagFault::Topic, message, expected: None }
    }

    pub(crate) fn field(message: String) -> Self {
        Self { kind: BagFault::Field, message, expected: None }
    }

    pub(crate) fn expecting(self, form: impl Into<String>) -> Self {
        Self { expected: Some(form.into()), ..self }
    }
}

impl From<io::Error> for BagError {
    fn from(error: io::Error) -> Self {
        Self::file(format!("it cannot be read: {error}"))
    }
}

impl From<crate::mcap::Malformed> for BagError {
    fn from(_: crate::mcap::Malformed) -> Self {
        Self::malformed()
    }
}

const MOST_LISTED: usize = 30;

/// Names of which one was expected.
pub(crate) fn one_of(names: &[String]) -> String {
    let quoted = names.iter().take(MOST_LISTED).map(|name| format!("`{name}`"));
    let rest = if names.len() > MOST_LISTED { ", …" } else { "" };
    match names {
        [] => "one of no name".to_owned(),
        _ => format!("one of {}{rest}", quoted.collect::<Vec<_>>().join(", ")),
    }
}
