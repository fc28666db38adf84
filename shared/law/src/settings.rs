//! Reading and checking of the laws' settings: one wording of every refusal.

use parameters::Row;
use scenario::Problem;
use scenario::controller::Controller;
use scenario::schema::{self, Key, Schema, Shape};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A law's own table in a scenario file, as a type. Every key has a default.
pub trait Settings: parameters::Table + Default + DeserializeOwned + Schema + Serialize {
    /// Its numbers, in the order in which they are checked.
    fn numbers(&self) -> Vec<Number> {
        Number::of("", self)
    }

    /// Checks what depends on several keys.
    fn check_together(&self) -> Result<(), Problem> {
        Ok(())
    }

    fn check(&self) -> Result<(), Problem> {
        self.numbers().iter().try_for_each(Number::check)?;
        self.check_together()
    }
}

/// Declares tables of a scenario file with the rows of [`parameters!`](parameters::parameters!).
#[macro_export]
macro_rules! settings {
    ($($(#[$about:meta])* $seen:vis struct $table:ident { $($row:tt)* })+) => {$(
        ::parameters::parameters! {
            $(#[$about])*
            #[derive(::serde::Deserialize, ::serde::Serialize, ::scenario::schema::Schema)]
            #[serde(deny_unknown_fields, default)]
            $seen struct $table { $($row)* }
        }
    )+};
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
    pub fn check(&self) -> Result<(), Problem> {
        let Some(value) = self.value else { return Ok(()) };
        accept(self.row.accepts(value), &self.key, value, "out of range", self.expected())
    }

    /// Accepted values in words.
    fn expected(&self) -> String {
        let (least, most) = self.row.range;
        match self.row.excludes_least {
            true => format!("a number above {least} and at most {most}"),
            false => format!("a number from {least} to {most}"),
        }
    }
}

/// Reads and checks the table `controller.<table>` of a scenario.
///
/// # Errors
/// The place of the first wrong key or value.
pub fn read<T: Settings>(controller: &Controller, table: &str) -> Result<T, Problem> {
    let settings: T = controller.tables.read(table)?;
    settings.check().map_err(|error| in_table(error, &format!("controller.{table}")))?;
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
                    *expected = Some(number.expected());
                    *range = Some(number.row.range);
                }
            }
            _ => {}
        }
    }
}

/// The same problem below `table`, the dotted path of the law's table.
pub fn in_table(mut problem: Problem, table: &str) -> Problem {
    problem.path = format!("{table}.{}", problem.path);
    problem
}

/// Accepts `least <= value <= most`; NaN is refused.
pub fn within(key: &str, value: f64, least: f64, most: f64) -> Result<(), Problem> {
    let expected = format!("a number from {least} to {most}");
    accept((least..=most).contains(&value), key, value, "out of range", expected)
}

/// Accepts a value below another key's; NaN is refused.
pub fn below(key: &str, value: f64, other: &str, limit: f64) -> Result<(), Problem> {
    accept(value < limit, key, value, "too large", format!("a number below {other} ({limit})"))
}

/// The problem's path is relative to the law's table.
fn accept(
    holds: bool,
    key: &str,
    value: f64,
    fault: &str,
    expected: String,
) -> Result<(), Problem> {
    let message = || format!("{key} = {value} is {fault}");
    if holds { Ok(()) } else { Err(Problem::new(key, message(), expected)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Row =
        Row { name: "lag_s", unit: "s", range: (0.0, 2.0), excludes_least: true, origin: "" };

    fn lag(value: f64) -> Result<(), Problem> {
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
        assert_eq!(error.message, "lag_s = 0 is out of range");
        assert_eq!(error.expected, "a number above 0 and at most 2");
        assert_eq!(in_table(error, "controller.road").path, "controller.road.lag_s");
    }
}
