//! Why a value does not fit a type.

use super::accepted::{accepted, nearest};
use super::problem::sentence;
use serde::de::{self, Expected, Unexpected};
use std::fmt;
use std::ops::Range;

/// Why a value does not fit a type, and where that was found. serde hands it over in parts, so that no
/// text has to be read again.
#[derive(Clone, Debug)]
pub(super) struct Refusal {
    message: String,
    expected: String,
    place: Option<Range<usize>>,
    /// A key that nothing reads here, where the list of keys has none like it.
    stray: Option<String>,
}

impl Refusal {
    fn new(message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { message: message.into(), expected: expected.into(), place: None, stray: None }
    }

    /// What was found is not one of the kinds with these names.
    pub(super) fn not_one(found: &str, words: &[&str]) -> Self {
        let words = accepted("", words.iter().copied());
        Self::new(format!("invalid type: {found}"), format!("exactly one of {words}"))
    }

    pub(super) fn message(&self) -> &str {
        &self.message
    }

    /// What would have been right; empty where that is not known.
    pub(super) fn expected(&self) -> &str {
        &self.expected
    }

    /// A key that nothing reads here, where no key here is like it.
    pub(super) fn stray(&self) -> Option<&str> {
        self.stray.as_deref()
    }

    pub(super) fn place(&self) -> Option<&Range<usize>> {
        self.place.as_ref()
    }

    /// The innermost place counts.
    pub(super) fn at(mut self, place: &Range<usize>) -> Self {
        self.place.get_or_insert_with(|| place.clone());
        self
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.expected.as_str() {
            "" => f.write_str(&self.message),
            expected => write!(f, "{}, expected {expected}", self.message),
        }
    }
}

impl std::error::Error for Refusal {}

impl de::Error for Refusal {
    /// A sentence of a type's own check.
    fn custom<T: fmt::Display>(said: T) -> Self {
        let said = said.to_string();
        let (message, expected) = sentence(&said);
        Self::new(message, expected)
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        // Of an enum: what was meant is in the kind's own keys.
        if found == Unexpected::UnitVariant {
            return Self::new(
                "the kind without what it is to be",
                "a table with its name as the key",
            );
        }
        Self::new(format!("invalid type: {found}"), in_words(expected))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::new(format!("invalid value: {found}"), in_words(expected))
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::new(format!("invalid length {length}"), in_words(expected))
    }

    fn unknown_variant(found: &str, words: &'static [&'static str]) -> Self {
        Self::new(format!("unknown value `{found}`"), accepted(found, words.iter().copied()))
    }

    fn unknown_field(found: &str, words: &'static [&'static str]) -> Self {
        let refusal =
            Self::new(format!("unknown key `{found}`"), accepted(found, words.iter().copied()));
        let is_stray = nearest(found, words.iter().copied()).is_none();
        Self { stray: is_stray.then(|| found.to_owned()), ..refusal }
    }

    fn missing_field(key: &'static str) -> Self {
        Self::new(format!("missing key `{key}`"), "")
    }

    fn duplicate_field(key: &'static str) -> Self {
        Self::new(format!("`{key}` stands here twice"), "it once")
    }
}

/// The name of a type, in the words of a scenario's author.
fn in_words(expected: &dyn Expected) -> String {
    let name = expected.to_string();
    match name.as_str() {
        "f64" => "a number".to_owned(),
        "i64" | "u64" | "i32" | "u32" | "u16" | "u8" | "usize" => "a whole number".to_owned(),
        "a nonzero usize" | "a nonzero u64" | "a nonzero u32" => {
            "a whole number of 1 or more".to_owned()
        }
        "a map" => "a table".to_owned(),
        "a sequence" => "an array".to_owned(),
        "a boolean" => "true or false".to_owned(),
        other if other.starts_with("struct ") => "a table".to_owned(),
        other if other.starts_with("an array of length ") => {
            other.replace("an array of length ", "a list of ") + " values"
        }
        _ => name,
    }
}
