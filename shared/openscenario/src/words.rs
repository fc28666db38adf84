//! Words of a file that stand for the variants of an enumeration, and the rules among them that compare two values.

use jiff::Timestamp;
use jiff::tz::TimeZone;

use crate::expression::Value;

/// An enumeration whose variants have words.
pub(crate) trait Words: Copy + 'static {
    /// The words with their meanings, in the order in which errors list them.
    const WORDS: &'static [(&'static str, Self)];

    /// The first word of a variant.
    fn word(self) -> &'static str
    where
        Self: PartialEq,
    {
        Self::WORDS.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| word)
    }
}

/// Declares enumerations, each variant with its words.
macro_rules! word_enums {
    ($($(#[$meta:meta])* $name:ident {
        $($(#[$about:meta])* $variant:ident: $($word:literal)|+,)+
    })*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name {
            $($(#[$about])* $variant,)+
        }

        impl $crate::words::Words for $name {
            const WORDS: &'static [(&'static str, Self)] = &[$($(($word, Self::$variant)),+),+];
        }
    )*};
}

pub(crate) use word_enums;

word_enums! {
    Rule {
        EqualTo: "equalTo",
        NotEqualTo: "notEqualTo",
        GreaterThan: "greaterThan",
        LessThan: "lessThan",
        GreaterOrEqual: "greaterOrEqual",
        LessOrEqual: "lessOrEqual",
    }
}

impl Rule {
    /// True if it holds between numbers.
    ///
    /// ```
    /// use openscenario::Rule;
    ///
    /// assert!(Rule::LessThan.holds(1.0, 2.0));
    /// ```
    pub fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::EqualTo => left == right,
            Self::NotEqualTo => left != right,
            Self::GreaterThan => left > right,
            Self::LessThan => left < right,
            Self::GreaterOrEqual => left >= right,
            Self::LessOrEqual => left <= right,
        }
    }

    /// True if it holds between values: as numbers where both are numbers, as text otherwise.
    pub fn compares(self, left: &Value, right: &Value) -> bool {
        match (left.number(), right.number()) {
            (Some(left), Some(right)) => self.holds(left, right),
            _ => match self {
                Self::EqualTo => left.text() == right.text(),
                Self::NotEqualTo => left.text() != right.text(),
                _ => false,
            },
        }
    }
}

/// Seconds since 1970 of a date and time of ISO 8601, without a zone in UTC. `None` for any other text.
///
/// ```
/// use openscenario::instant_s;
///
/// assert_eq!(instant_s("1970-01-01T01:00:01.5+01:00"), Some(1.5));
/// assert_eq!(instant_s("1970-01-01 00:00:01.5"), Some(1.5));
/// assert_eq!(instant_s("19700101"), None);
/// ```
pub fn instant_s(text: &str) -> Option<f64> {
    let in_utc = || TimeZone::UTC.to_timestamp(text.parse().ok()?).ok();
    // A date alone, or a number, is not an instant.
    let stamp: Timestamp = text.contains(':').then(|| text.parse().ok().or_else(in_utc))??;
    Some(stamp.as_nanosecond() as f64 * 1e-9)
}
