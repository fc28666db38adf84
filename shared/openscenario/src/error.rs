//! Why a file was refused, and where.

use std::fmt;

/// A line and a column of a text, from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Spot {
    /// The line.
    pub line: usize,
    /// The column, in characters.
    pub column: usize,
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// A spot in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named.
    pub file: String,
    /// The place in it.
    pub spot: Spot,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.spot)
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
        /// Error of the system.
        reason: String,
    },
    /// The text is not well-formed XML.
    #[error("{place}: {reason}")]
    Syntax {
        /// Place.
        place: Place,
        /// Fault.
        reason: String,
    },
    /// Another version of the standard.
    #[error("{place}: version {found} of OpenSCENARIO XML is not supported, expected 1.0 to 1.3")]
    Version {
        /// Place.
        place: Place,
        /// The version that the file states.
        found: String,
    },
    /// An element outside the subset, or one that is missing or too many.
    #[error("{place}: element `{element}` in `{parent}` {fault}, expected {expected}")]
    Element {
        /// Place.
        place: Place,
        /// Its name.
        element: String,
        /// The element that it stands in.
        parent: String,
        /// Fault of the value.
        fault: &'static str,
        /// Expected value.
        expected: String,
    },
    /// An attribute that is unknown or missing, or whose value does not fit.
    #[error("{place}: attribute `{attribute}` of `{element}`: {reason}, expected {expected}")]
    Attribute {
        /// Its place; the beginning of its element if it is missing.
        place: Place,
        /// Its name.
        attribute: String,
        /// The element that it belongs to.
        element: String,
        /// Fault.
        reason: String,
        /// Expected content.
        expected: String,
    },
    /// A parameter whose value breaks its own constraints: a variation leaves such a combination out.
    #[error("{place}: parameter `{parameter}` has the value {value}, expected {expected}")]
    Constraint {
        /// Place of its declaration.
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
        /// Place.
        place: Place,
        /// Its name.
        parameter: String,
        /// Fault.
        reason: String,
        /// Expected content.
        expected: String,
    },
    /// Something that is well formed and cannot be simulated.
    #[error("{place}: {reason}, expected {expected}")]
    Meaning {
        /// Place.
        place: Place,
        /// Fault.
        reason: String,
        /// Expected content.
        expected: String,
    },
    /// A `--param` that names no parameter, or gives it a value that does not fit.
    #[error("parameter {name}={value}: {reason}, expected {expected}")]
    Override {
        /// Its name.
        name: String,
        /// The value given.
        value: String,
        /// Fault.
        reason: String,
        /// Expected content.
        expected: String,
    },
}

impl ReadError {
    /// An error about an assignment that stands in a file, with its place there.
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

/// Lists names, with the nearest one where `refused` may be a misspelling of it.
pub(crate) fn meant<'a>(refused: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let short: String = refused.chars().take(64).collect();
    let limit = 1 + short.chars().count() / 4;
    let distances = names.iter().map(|name| (strsim::osa_distance(&short, name), *name));
    let nearest = distances.min_by_key(|(distance, _)| *distance);
    let is_choice = names.len() > 1;
    match nearest.filter(|(distance, _)| is_choice && *distance <= limit) {
        Some((_, near)) => format!("{} (did you mean `{near}`?)", one_of(names)),
        None => one_of(names),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_gets_a_suggestion() {
        assert_eq!(
            meant("Storybord", ["Storyboard", "Init"]),
            "`Storyboard` or `Init` (did you mean `Storyboard`?)"
        );
        assert_eq!(meant("Wings", ["Axles", "Init"]), "`Axles` or `Init`");
        assert_eq!(meant("init", ["Init"]), "`Init`");
        assert_eq!(meant("a", []), "nothing here");
    }
}
