//! Texts of a scenario that end up in file names and on terminals.

use serde::{Deserialize, Serialize};

use crate::schema::{Schema, Shape};

/// Declares a text that is held to a rule: `Name: "not it", "what it is", |text| rule;`.
macro_rules! texts {
    ($($(#[$about:meta])* $name:ident: $not:literal, $expected:literal, $is_one:expr;)+) => {$(
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "String")]
        pub struct $name(String);

        impl $name {
            pub fn as_str(&self) -> &str {
                &self.0
            }

            /// Wraps a literal.
            ///
            /// # Panics
            /// When it breaks the rule.
            pub fn of(text: &str) -> Self {
                Self::try_from(text.to_owned()).expect("a literal that keeps the rule")
            }
        }

        impl TryFrom<String> for $name {
            type Error = &'static str;

            fn try_from(text: String) -> Result<Self, &'static str> {
                let is_one: fn(&str) -> bool = $is_one;
                if is_one(&text) { Ok(Self(text)) } else { Err(concat!($not, ", expected ", $expected)) }
            }
        }

        impl From<$name> for String {
            fn from(text: $name) -> String {
                text.0
            }
        }

        impl Schema for $name {
            fn shape() -> Shape {
                String::shape()
            }

            fn expected() -> Option<String> {
                Some($expected.to_owned())
            }
        }
    )+};
}

texts! {
    /// Name of a scenario, a law or an actor; a scenario's becomes part of the run directory's name.
    Name: "not a name", "1 to 64 letters, digits, `-` or `_`", |name| {
        let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        (1..=64).contains(&name.len()) && name.chars().all(good)
    };
    /// A line of prose, without control characters.
    #[derive(Default)]
    Line: "not a line of text", "at most 500 characters in one line", |line| {
        line.chars().count() <= 500 && !line.chars().any(char::is_control)
    };
}
