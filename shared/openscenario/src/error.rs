//! Why a file was refused, and where.

use std::fmt;

/// A line and a column of a text, from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Spot {
    pub line: usize,
    /// In characters.
    pub column: usize,
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    pub file: String,
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
    #[error("{file}: {reason}")]
    File { file: String, reason: String },
    #[error("{place}: {reason}")]
    Syntax { place: Place, reason: String },
    /// A part of the file is outside the subset, does not fit, or cannot be simulated.
    #[error("{place}: {reason}, expected {expected}")]
    Meaning { place: Place, reason: String, expected: String },
    /// A parameter that is not declared, or depends on itself.
    #[error("{place}: parameter `{parameter}` {reason}, expected {expected}")]
    Parameter { place: Place, parameter: String, reason: String, expected: String },
    /// A parameter whose value breaks its own constraints: a variation leaves such a combination out.
    #[error("{place}: parameter `{parameter}` has the value {value}, expected {expected}")]
    Constraint { place: Place, parameter: String, value: String, expected: String },
    /// A `--param` that names no parameter, or gives it a value that does not fit.
    #[error("parameter {name}={value}: {reason}, expected {expected}")]
    Override { name: String, value: String, reason: String, expected: String },
}

impl ReadError {
    pub(crate) fn meaning(
        place: Place,
        reason: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Meaning { place, reason: reason.into(), expected: expected.into() }
    }

    pub(crate) fn element(
        place: Place,
        (element, parent): (&str, &str),
        fault: &str,
        expected: impl Into<String>,
    ) -> Self {
        Self::meaning(place, format!("element `{element}` in `{parent}` {fault}"), expected)
    }

    /// An error about an attribute of an element. The place of a missing one is its element's.
    pub(crate) fn attribute(
        place: Place,
        (attribute, element): (&str, &str),
        reason: impl fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::meaning(place, format!("attribute `{attribute}` of `{element}`: {reason}"), expected)
    }

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
