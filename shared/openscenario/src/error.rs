//! Why a file was refused, and where.

use std::fmt;

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// A scenario, catalog, road or variation file that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The file is not there, or not readable.
    #[error("{file}: {reason}")]
    File {
        /// Its path.
        file: String,
        /// What the system said.
        reason: String,
    },
    /// The text is not well-formed XML.
    #[error("{place}: {reason}")]
    Syntax {
        /// Where.
        place: Place,
        /// What is wrong.
        reason: String,
    },
    /// Another version of the standard.
    #[error("{place}: version {found} of OpenSCENARIO XML is not supported, expected 1.0 to 1.3")]
    Version {
        /// Where.
        place: Place,
        /// The version that the file states.
        found: String,
    },
    /// An element outside the subset, or one that is missing or too many.
    #[error("{place}: element `{element}` in `{parent}` {fault}, expected {expected}")]
    Element {
        /// Where.
        place: Place,
        /// Its name.
        element: String,
        /// The element that it stands in.
        parent: String,
        /// What is wrong with it.
        fault: &'static str,
        /// What would have been right.
        expected: String,
    },
    /// An attribute that is unknown or missing, or whose value does not fit.
    #[error("{place}: attribute `{attribute}` of `{element}`: {reason}, expected {expected}")]
    Attribute {
        /// Where its element begins.
        place: Place,
        /// Its name.
        attribute: String,
        /// The element that it belongs to.
        element: String,
        /// What is wrong.
        reason: String,
        /// What would have been right.
        expected: String,
    },
    /// A parameter whose value breaks its own constraints: a variation leaves such a combination out.
    #[error("{place}: parameter `{parameter}` has the value {value}, expected {expected}")]
    Constraint {
        /// Where it is declared.
        place: Place,
        /// Its name.
        parameter: String,
        /// Its value.
        value: String,
        /// The constraints.
        expected: String,
    },
    /// A parameter that is not declared, or depends on itself.
    #[error("{place}: parameter `{parameter}` {reason}, expected {expected}")]
    Parameter {
        /// Where.
        place: Place,
        /// Its name.
        parameter: String,
        /// What is wrong.
        reason: String,
        /// What would have been right.
        expected: String,
    },
    /// Something that is well formed and cannot be simulated.
    #[error("{place}: {reason}, expected {expected}")]
    Meaning {
        /// Where.
        place: Place,
        /// What is wrong.
        reason: String,
        /// What would have been right.
        expected: String,
    },
    /// A `--param` that names no parameter, or gives it a value that does not fit.
    #[error("parameter {name}={value}: {reason}, expected {expected}")]
    Override {
        /// Its name.
        name: String,
        /// The value given.
        value: String,
        /// What is wrong.
        reason: String,
        /// What would have been right.
        expected: String,
    },
}

impl ReadError {
    /// The same for a value that was given in a file: says where.
    pub(crate) fn given_at(self, place: &Place) -> Self {
        match self {
            Self::Override { name, value, reason, expected } => Self::Meaning {
                place: place.clone(),
                reason: format!("parameter {name}={value}: {reason}"),
                expected,
            },
            other => other,
        }
    }
}

/// Lists names as `a`, `b` or `c`.
pub(crate) fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        None => "nothing here".to_owned(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}
