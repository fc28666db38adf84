//! Reading of values into types, with the path of what does not fit.

use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;
use toml::Value;

use super::form::{self, below};
use super::problem::Problem;
use super::words::accepted;
use crate::schema::{self, Schema};

/// Reads a value into a type that declares its keys; `path` is the value's own.
///
/// # Errors
/// The first value or key that does not fit.
pub(super) fn declared<T: DeserializeOwned + Schema>(
    value: Value,
    path: &str,
) -> Result<T, Problem> {
    check_form::<T>(&value, path)?;
    plain(value, path)
}

/// Compares a value with the declaration of a type; `path` is the value's own.
///
/// # Errors
/// The first value or key that does not have the declared form.
pub(crate) fn check_form<T: Schema>(value: &Value, path: &str) -> Result<(), Problem> {
    form::check(schema::shape_of::<T>(), value, path)
}

/// Reads a value into a type; `path` is the value's own.
///
/// # Errors
/// The first value or key that does not fit.
pub(crate) fn plain<T: DeserializeOwned>(value: Value, path: &str) -> Result<T, Problem> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().iter().fold(path.to_owned(), |path, segment| match segment {
            Segment::Seq { index } => below(&path, index),
            Segment::Map { key } => below(&path, key),
            Segment::Enum { variant } => below(&path, variant),
            Segment::Unknown => path,
        });
        in_words(path, error.inner().message())
    })
}

/// A reader's sentence in the words of a scenario. Its two parts come apart.
fn in_words(path: String, said: &str) -> Problem {
    let (message, expected) = said.split_once(", expected ").unwrap_or((said, ""));
    let quoted = |text: &str| -> Vec<String> {
        text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let word = quoted(message).first().cloned().unwrap_or_default();
    let known = || {
        let words = quoted(expected);
        accepted(&word, words.iter().map(String::as_str))
    };
    match message.split_once(" `").map(|(kind, _)| kind) {
        Some("unknown field") => {
            Problem::new(path, format!("unknown key `{word}`"), known()).of_key()
        }
        Some("unknown variant") => Problem::new(path, format!("unknown value `{word}`"), known()),
        Some("missing field") => Problem::new(path, format!("missing key `{word}`"), ""),
        _ if expected.starts_with("a nonzero ") => {
            Problem::new(path, message, "a whole number of 1 or more")
        }
        _ if expected == "a sequence" => Problem::new(path, message, "a list"),
        _ => Problem::new(path, message, expected),
    }
}
