//! Texts of a scenario that end up in file names and on terminals.

use serde::Serialize;

use super::refusal::{Explained, read_from};
use super::schema::{Schema, Shape};

/// Name of a scenario, a law or an actor; a scenario's becomes part of the run directory's name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct Name(String);

/// A line of prose, without control characters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct Line(String);

impl Name {
    /// A name from a literal.
    ///
    /// # Panics
    /// When it is not a name.
    #[must_use]
    pub fn of(name: &str) -> Self {
        Self::try_from(name.to_owned()).expect("a literal that is a name")
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Line {
    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Not a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a name, expected {NAME}")]
pub struct NotAName;

/// Not a line of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a line of text, expected {LINE}")]
pub struct NotALine;

/// A name in words.
const NAME: &str = "1 to 64 letters, digits, `-` or `_`";
/// A line in words.
const LINE: &str = "at most 500 characters in one line";

/// Implements reading and the schema of a text.
macro_rules! text {
    ($type:ident, $error:ident, $message:literal, $expected:ident) => {
        impl Explained for $error {
            fn message(&self) -> String {
                $message.to_owned()
            }

            fn expected(&self) -> String {
                $expected.to_owned()
            }
        }

        impl Schema for $type {
            fn shape() -> Shape {
                String::shape()
            }

            fn expected() -> Option<String> {
                Some($expected.to_owned())
            }
        }

        read_from!($type, String);
    };
}

text!(Name, NotAName, "not a name", NAME);
text!(Line, NotALine, "not a line of text", LINE);

impl TryFrom<String> for Name {
    type Error = NotAName;

    fn try_from(name: String) -> Result<Self, NotAName> {
        let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if (1..=64).contains(&name.len()) && name.chars().all(good) {
            Ok(Self(name))
        } else {
            Err(NotAName)
        }
    }
}

impl TryFrom<String> for Line {
    type Error = NotALine;

    fn try_from(line: String) -> Result<Self, NotALine> {
        if line.chars().count() <= 500 && !line.chars().any(char::is_control) {
            Ok(Self(line))
        } else {
            Err(NotALine)
        }
    }
}

impl From<Name> for String {
    fn from(name: Name) -> String {
        name.0
    }
}

impl From<Line> for String {
    fn from(line: Line) -> String {
        line.0
    }
}
