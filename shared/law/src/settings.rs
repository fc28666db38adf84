//! Reading and checking of the laws' settings: one error type, one wording.

use parameters::Row;
use scenario::Problem;
use scenario::controller::Controller;
use scenario::schema::{self, Key, Schema, Shape};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt;
use thiserror::Error;

/// A law's own table in a scenario file, as a type. Every key has a default.
pub trait Settings: parameters::Table + Default + DeserializeOwned + Schema + Serialize {
    /// Its numbers, in the order in which they are checked.
    fn numbers(&self) -> Vec<Number> {
        Number::of("", self)
    }

    /// Checks what depends on several keys.
    fn check_together(&self) -> Result<(), SettingError> {
        Ok(())
    }

    /// Checks every value.
    fn check(&self) -> Result<(), SettingError> {
        self.numbers().iter().try_for_each(Number::check)?;
        self.check_together()
    }
}

/// A number of a law's table.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its key in the law's table; the keys of a table below are dotted.
    key: String,
    value: Option<f64>,
    row: &'static Row,
}

impl Number {
    /// The numbers of `table`, whose keys begin with `prefix`.
    pub fn of<T: parameters::Table>(prefix: &str, table: &T) -> Vec<Self> {
        let number = |(place, row): (usize, &'static Row)| Self {
            key: format!("{prefix}{}", row.name),
            value: table.number(place),
            row,
        };
        T::ROWS.iter().enumerate().map(number).collect()
    }

    /// Checks that a value that is there is within its range.
    pub fn check(&self) -> Result<(), SettingError> {
        match self.value {
            Some(value) if !self.row.accepts(value) => Err(self.refusal(value)),
            _ => Ok(()),
        }
    }

    /// The refusal of `value`, which has the range in words.
    fn refusal(&self, value: f64) -> SettingError {
        let (least, most) = self.row.range;
        let expected = match self.row.excludes_least {
            true => Expected::Above(least, most),
            false => Expected::Within(least, most),
        };
        SettingError { key: self.key.clone(), value, expected }
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
    pub const fn of<T: Settings>(name: &'static str) -> Self {
        Self {
            name,
            keys: || {
                let mut keys = schema::keys_of::<T>();
                put_ranges(&mut keys, "", &T::default().numbers());
                keys
            },
            check: |controller, name| read::<T>(controller, name).map(drop),
        }
    }
}

/// Puts the ranges of `numbers` beside the keys of the table at this path.
fn put_ranges(keys: &mut [Key], path: &str, numbers: &[Number]) {
    for Key { name, shape, expected, .. } in keys {
        let path = format!("{path}{name}");
        match shape {
            Shape::Table(below) => put_ranges(below, &format!("{path}."), numbers),
            Shape::Number { range, .. } => {
                if let Some(number) = numbers.iter().find(|number| number.key == path) {
                    *expected = Some(number.refusal(f64::NAN).expected());
                    *range = Some(number.row.range);
                }
            }
            _ => {}
        }
    }
}

/// A setting that a law refuses.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}, expected {expected}", self.message())]
pub struct SettingError {
    /// The key, relative to the law's table.
    key: String,
    value: f64,
    expected: Expected,
}

/// Accepted values.
#[derive(Clone, Debug, PartialEq)]
enum Expected {
    Within(f64, f64),
    /// The least value is not accepted.
    Above(f64, f64),
    /// Below the value of another key.
    Below(String, f64),
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Within(least, most) => write!(f, "a number from {least} to {most}"),
            Self::Above(least, most) => write!(f, "a number above {least} and at most {most}"),
            Self::Below(other, limit) => write!(f, "a number below {other} ({limit})"),
        }
    }
}

impl SettingError {
    pub fn key(&self) -> &str {
        &self.key
    }

    pub fn message(&self) -> String {
        let fault = match self.expected {
            Expected::Within(..) | Expected::Above(..) => "out of range",
            Expected::Below(..) => "too large",
        };
        format!("{} = {} is {fault}", self.key, self.value)
    }

    /// Accepted values in words.
    pub fn expected(&self) -> String {
        self.expected.to_string()
    }

    /// The same of the key `key`, with its numbers, which are in seconds, in milliseconds.
    pub fn in_ms(mut self, key: &str) -> Self {
        key.clone_into(&mut self.key);
        // A thousandth has no exact form: what was typed is shown.
        let scale = |number: &mut f64| *number = (*number * 1e9).round() / 1e6;
        scale(&mut self.value);
        match &mut self.expected {
            Expected::Within(least, most) | Expected::Above(least, most) => {
                [least, most].into_iter().for_each(scale);
            }
            Expected::Below(_, limit) => scale(limit),
        }
        self
    }

    /// The error at its place in a scenario file: `table` is the dotted path of the law's table.
    pub fn in_table(&self, table: &str) -> Problem {
        Problem::new(format!("{table}.{}", self.key), self.message(), self.expected())
    }
}

/// Accepts `least <= value <= most`; NaN is refused.
pub fn within(key: &str, value: f64, least: f64, most: f64) -> Result<(), SettingError> {
    let refused = Expected::Within(least, most);
    accept((least..=most).contains(&value), key, value, refused)
}

/// Accepts a value below another key's; NaN is refused.
pub fn below(key: &str, value: f64, other: &str, limit: f64) -> Result<(), SettingError> {
    accept(value < limit, key, value, Expected::Below(other.to_owned(), limit))
}

fn accept(holds: bool, key: &str, value: f64, expected: Expected) -> Result<(), SettingError> {
    if holds { Ok(()) } else { Err(SettingError { key: key.to_owned(), value, expected }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Row =
        Row { name: "lag_s", unit: "s", range: (0.0, 2.0), excludes_least: true, origin: "" };

    fn lag(value: f64) -> Result<(), SettingError> {
        Number { key: LAG.name.to_owned(), value: Some(value), row: &LAG }.check()
    }

    #[test]
    fn a_value_that_is_not_a_number_is_refused_everywhere() {
        assert!(within("a", f64::NAN, 0.0, 1.0).is_err());
        assert!(lag(f64::NAN).is_err());
        assert!(below("a", f64::NAN, "b", 1.0).is_err());
    }

    #[test]
    fn an_error_says_key_value_and_what_was_expected() {
        let error = lag(0.0).expect_err("not above zero");
        assert_eq!(
            error.to_string(),
            "lag_s = 0 is out of range, expected a number above 0 and at most 2"
        );
        assert_eq!(error.in_table("controller.road").path, "controller.road.lag_s");
    }
}
