//! Reasons why a value does not fit a type.

use super::accepted::{accepted, nearest};
use serde::de::{self, Deserialize, Deserializer, Expected, Unexpected};
use std::fmt;
use std::ops::Range;

/// An error in two parts: what is wrong, and what would have been right.
pub(crate) trait Explained {
    /// The fault.
    fn message(&self) -> String;

    /// The right form.
    fn expected(&self) -> String;
}

/// Reads a `From` and converts it. The two parts of an error stay apart.
pub(crate) fn convert<'de, From, To, D>(deserializer: D) -> Result<To, D::Error>
where
    From: Deserialize<'de>,
    To: TryFrom<From, Error: Explained>,
    D: Deserializer<'de>,
{
    To::try_from(From::deserialize(deserializer)?).map_err(|error| {
        let expected = error.expected();
        de::Error::invalid_value(Unexpected::Other(&error.message()), &expected.as_str())
    })
}

/// Implements reading of `$type` by the conversion from `$from`.
macro_rules! read_from {
    ($type:ty, $from:ty) => {
        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                crate::refusal::convert::<$from, Self, D>(deserializer)
            }
        }
    };
}
pub(crate) use read_from;

/// Reason why a value does not fit a type, and where that was found.
#[derive(Clone, Debug)]
pub(super) struct Refusal {
    message: String,
    expected: String,
    place: Option<Range<usize>>,
    /// A key that is not known here, if the list has no similar key.
    stray: Option<String>,
    /// A key that is not there.
    missing: Option<&'static str>,
    /// The key of a shared table whose value is refused.
    key: Option<&'static str>,
}

impl Refusal {
    pub(super) fn new(message: impl Into<String>, expected: impl Into<String>) -> Self {
        let (message, expected) = (message.into(), expected.into());
        Self { message, expected, place: None, stray: None, missing: None, key: None }
    }

    /// The value is not one of the kinds with these names.
    pub(super) fn not_one(found: &str, words: &[&str]) -> Self {
        let words = accepted("", words.iter().copied());
        Self::new(format!("invalid type: {found}"), format!("exactly one of {words}"))
    }

    /// The value cannot be read as any type.
    pub(super) fn unreadable(found: &str, expected: &dyn Expected) -> Self {
        Self::new(format!("invalid value: {found}"), expected.to_string())
    }

    pub(super) fn message(&self) -> &str {
        &self.message
    }

    /// The right form; empty if it is not known.
    pub(super) fn expected(&self) -> &str {
        &self.expected
    }

    /// A key that is not known here, if no key here is like it.
    pub(super) fn stray(&self) -> Option<&str> {
        self.stray.as_deref()
    }

    /// A key that is not there.
    pub(super) fn missing(&self) -> Option<&'static str> {
        self.missing
    }

    /// The key of a shared table whose value is refused.
    pub(super) fn key(&self) -> Option<&'static str> {
        self.key
    }

    /// Notes that key.
    pub(super) fn of_key(self, key: &'static str) -> Self {
        Self { key: Some(key), ..self }
    }

    /// Says what would have been right.
    pub(super) fn expecting(self, expected: impl Into<String>) -> Self {
        Self { expected: expected.into(), ..self }
    }

    pub(super) fn place(&self) -> Option<&Range<usize>> {
        self.place.as_ref()
    }

    /// Notes a place; the innermost one counts.
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
        Self::new(said.to_string(), "")
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        // An enum: the kind's own keys are missing.
        if found == Unexpected::UnitVariant {
            return Self::new(
                "the kind without what it is to be",
                "a table with its name as the key",
            );
        }
        Self::new(format!("invalid type: {found}"), expected.to_string())
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        match found {
            // The message of `convert`.
            Unexpected::Other(message) => Self::new(message, expected.to_string()),
            found => Self::new(format!("invalid value: {found}"), expected.to_string()),
        }
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::new(format!("invalid length {length}"), expected.to_string())
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
        Self { missing: Some(key), ..Self::new(format!("missing key `{key}`"), "") }
    }

    fn duplicate_field(key: &'static str) -> Self {
        Self::new(format!("`{key}` stands here twice"), "it once")
    }
}
