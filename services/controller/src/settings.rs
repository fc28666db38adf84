//! Reading and checking of the laws' settings: one error type, one wording.

use scenario::Problem;
use scenario::controller::Controller;
use scenario::schema::{self, Key, Schema, Shape};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use thiserror::Error;

/// A law's own table in a scenario file, as a type. Every key has a default.
pub trait Settings: Default + DeserializeOwned + Schema + Serialize {
    /// Shows every number with its range, in the order in which they are checked.
    fn ranges(&self, see: &mut Ranges<'_>);

    /// Checks what depends on several keys.
    ///
    /// # Errors
    /// The first key that is not usable.
    fn check_together(&self) -> Result<(), SettingError> {
        Ok(())
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first key that is not usable.
    fn check(&self) -> Result<(), SettingError> {
        let mut found = Ok(());
        self.ranges(&mut Ranges(&mut |key, value, range| {
            if found.is_ok() {
                found = value.map_or(Ok(()), |value| range.check(key, value));
            }
        }));
        found?;
        self.check_together()
    }
}

/// Takes the ranges of a table's numbers. A number may be absent.
pub struct Ranges<'a>(&'a mut dyn FnMut(&'static str, Option<f64>, Range));

impl Ranges<'_> {
    /// `least <= value <= most`.
    pub fn within(&mut self, key: &'static str, value: f64, least: f64, most: f64) {
        self.optional(key, Some(value), least, most);
    }

    /// `above < value <= most`.
    pub fn above(&mut self, key: &'static str, value: f64, above: f64, most: f64) {
        (self.0)(key, Some(value), Range::Above(above, most));
    }

    /// `least <= value <= most`, if there is a value.
    pub fn optional(&mut self, key: &'static str, value: Option<f64>, least: f64, most: f64) {
        (self.0)(key, value, Range::Within(least, most));
    }
}

/// The range of a number.
#[derive(Clone, Copy, Debug)]
enum Range {
    Within(f64, f64),
    Above(f64, f64),
}

impl Range {
    fn check(self, key: &'static str, value: f64) -> Result<(), SettingError> {
        match self {
            Self::Within(least, most) => within(key, value, least, most),
            Self::Above(bound, most) => above(key, value, bound, most),
        }
    }

    /// The refusal of `value`, which has the range in words.
    fn refusal(self, key: &'static str, value: f64) -> SettingError {
        match self {
            Self::Within(least, most) => SettingError::OutOfRange { key, value, least, most },
            Self::Above(above, most) => SettingError::NotAbove { key, value, above, most },
        }
    }
}

/// Reads and checks the table `controller.<table>` of a scenario.
///
/// # Errors
/// The place of the first wrong key or value.
pub fn read<T: Settings>(controller: &Controller, table: &str) -> Result<T, Problem> {
    let settings: T = controller.tables.read(table)?;
    settings.check().map_err(|error| error.in_table(&format!("controller.{table}")))?;
    Ok(settings)
}

/// A law's table as data.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// Name below `[controller]`.
    pub name: &'static str,
    /// The keys with their types, ranges, defaults and meanings.
    pub keys: fn() -> Vec<Key>,
    /// Reads the table and checks what does not depend on other keys.
    pub check: fn(&Controller, &str) -> Result<(), Problem>,
}

impl Table {
    /// The table `name`, of type `T`.
    #[must_use]
    pub const fn of<T: Settings>(name: &'static str) -> Self {
        Self {
            name,
            keys: keys::<T>,
            check: |controller, name| read::<T>(controller, name).map(drop),
        }
    }
}

/// The keys of a law's table, with the ranges that its check holds them to.
fn keys<T: Settings>() -> Vec<Key> {
    let mut ranges = BTreeMap::new();
    T::default().ranges(&mut Ranges(&mut |key, value, range| {
        ranges.insert(key, range.refusal(key, value.unwrap_or_default()));
    }));
    let mut keys = schema::keys_of::<T>();
    put_ranges(&mut keys, "", &ranges);
    keys
}

/// Puts the ranges beside the keys of the table at this path.
fn put_ranges(keys: &mut [Key], path: &str, ranges: &BTreeMap<&'static str, SettingError>) {
    for Key { name, shape, expected, .. } in keys {
        let path = format!("{path}{name}");
        match shape {
            Shape::Table(below) => put_ranges(below, &format!("{path}."), ranges),
            Shape::Number { range, .. } => {
                if let Some(refusal) = ranges.get(path.as_str()) {
                    *expected = Some(refusal.expected());
                    *range = refusal.range();
                }
            }
            _ => {}
        }
    }
}

/// A setting that a law refuses. The key is relative to the law's table.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SettingError {
    /// Outside its range.
    #[error("{}, expected {}", self.message(), self.expected())]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value.
        least: f64,
        /// Largest value.
        most: f64,
    },
    /// Not above its lower bound, or above the upper one.
    #[error("{}, expected {}", self.message(), self.expected())]
    NotAbove {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// Limit that it must exceed.
        above: f64,
        /// Largest value.
        most: f64,
    },
    /// Not below the value of another key.
    #[error("{}, expected {}", self.message(), self.expected())]
    NotBelow {
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The other key.
        other: &'static str,
        /// The other key's value.
        limit: f64,
    },
}

impl SettingError {
    /// The key that is refused.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match *self {
            Self::OutOfRange { key, .. }
            | Self::NotAbove { key, .. }
            | Self::NotBelow { key, .. } => key,
        }
    }

    /// The fault.
    #[must_use]
    pub fn message(&self) -> String {
        match self {
            Self::OutOfRange { key, value, .. } | Self::NotAbove { key, value, .. } => {
                format!("{key} = {value} is out of range")
            }
            Self::NotBelow { key, value, .. } => format!("{key} = {value} is too large"),
        }
    }

    /// Accepted values in words.
    #[must_use]
    pub fn expected(&self) -> String {
        match self {
            Self::OutOfRange { least, most, .. } => format!("a number from {least} to {most}"),
            Self::NotAbove { above, most, .. } => {
                format!("a number above {above} and at most {most}")
            }
            Self::NotBelow { other, limit, .. } => format!("a number below {other} ({limit})"),
        }
    }

    /// The ends of the range, where it depends on no other key.
    #[must_use]
    pub fn range(&self) -> Option<(f64, f64)> {
        match *self {
            Self::OutOfRange { least, most, .. } => Some((least, most)),
            Self::NotAbove { above, most, .. } => Some((above, most)),
            Self::NotBelow { .. } => None,
        }
    }

    /// The same with its keys renamed.
    #[must_use]
    pub fn renamed(mut self, name: impl Fn(&'static str) -> &'static str) -> Self {
        if let Self::NotBelow { other, .. } = &mut self {
            *other = name(other);
        }
        match &mut self {
            Self::OutOfRange { key, .. }
            | Self::NotAbove { key, .. }
            | Self::NotBelow { key, .. } => *key = name(key),
        }
        self
    }

    /// The same with its numbers, which are in seconds, in milliseconds.
    #[must_use]
    pub fn in_ms(mut self) -> Self {
        // A thousandth has no exact form: what was typed is shown.
        let scale = |number: &mut f64| *number = (*number * 1e9).round() / 1e6;
        match &mut self {
            Self::OutOfRange { value, least, most, .. } => [value, least, most].map(scale),
            Self::NotAbove { value, above, most, .. } => [value, above, most].map(scale),
            Self::NotBelow { value, limit, .. } => {
                scale(value);
                scale(limit);
                [(); 3]
            }
        };
        self
    }

    /// The error at its place in a scenario file: `table` is the dotted path of the law's table.
    #[must_use]
    pub fn in_table(&self, table: &str) -> Problem {
        Problem::new(format!("{table}.{}", self.key()), self.message(), self.expected())
    }
}

/// Accepts `least <= value <= most`; NaN is refused.
///
/// # Errors
/// [`SettingError::OutOfRange`].
pub fn within(key: &'static str, value: f64, least: f64, most: f64) -> Result<(), SettingError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(SettingError::OutOfRange { key, value, least, most })
    }
}

/// Accepts `above < value <= most`; NaN is refused.
///
/// # Errors
/// [`SettingError::NotAbove`].
pub fn above(key: &'static str, value: f64, above: f64, most: f64) -> Result<(), SettingError> {
    if value > above && value <= most {
        Ok(())
    } else {
        Err(SettingError::NotAbove { key, value, above, most })
    }
}

/// Accepts a value below another key's; NaN is refused.
///
/// # Errors
/// [`SettingError::NotBelow`].
pub fn below(
    key: &'static str,
    value: f64,
    other: &'static str,
    limit: f64,
) -> Result<(), SettingError> {
    if value < limit { Ok(()) } else { Err(SettingError::NotBelow { key, value, other, limit }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_is_not_a_number_is_refused_everywhere() {
        assert!(within("a", f64::NAN, 0.0, 1.0).is_err());
        assert!(above("a", f64::NAN, 0.0, 1.0).is_err());
        assert!(below("a", f64::NAN, "b", 1.0).is_err());
    }

    #[test]
    fn an_error_says_key_value_and_what_was_expected() {
        let error = above("lag_s", 0.0, 0.0, 2.0).expect_err("not above zero");
        assert_eq!(
            error.to_string(),
            "lag_s = 0 is out of range, expected a number above 0 and at most 2"
        );
        assert_eq!(error.in_table("controller.road").path, "controller.road.lag_s");
    }
}
