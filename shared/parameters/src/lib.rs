//! Tables of model parameters: each number stands in one row with its unit, its range and its origin.
//!
//! [`parameters!`](crate::parameters!) turns the rows into a struct whose fields have the numbers as their defaults.
//! The documentation of a field gives all of its row. A value outside of its range does not compile:
//!
//! ```compile_fail
//! parameters::parameters! {
//!     /// The brakes of a car.
//!     pub struct Brakes {
//!         /// Largest deceleration.
//!         deceleration_mps2: f64 = 83.4, "m/s²", 5.0..=12.0, "Chosen.";
//!     }
//! }
//! ```
//!
//! The same rows are data ([`Table::ROWS`]). So a program can change each number in turn and measure its [`effect`]:
//!
//! ```
//! use parameters::{Table, parameters};
//!
//! parameters! {
//!     /// The brakes of a car.
//!     pub struct Brakes {
//!         /// Largest deceleration.
//!         deceleration_mps2: f64 = 8.34, "m/s²", 5.0..=12.0, "Source: UN R152, paragraph 5.2.1.4 (at least 5).";
//!         /// Scans in a row that confirm a target.
//!         scans: u32 = 3, "scans", 1.0..=10.0, "Chosen.";
//!     }
//! }
//!
//! let harder = Brakes { deceleration_mps2: 9.0, ..Brakes::DEFAULT };
//! assert!(harder.within_ranges());
//! assert_eq!(Brakes::ROWS[0].name, "deceleration_mps2");
//!
//! // One fifth more of each number, one at a time.
//! for row in 0..Brakes::ROWS.len() {
//!     let changed = Brakes::DEFAULT.scaled(row, 1.2);
//!     assert_ne!(changed, Brakes::DEFAULT);
//! }
//! assert_eq!(Brakes::DEFAULT.scaled(1, 1.2).scans, 4, "a count changes by one at least");
//! ```

pub mod effect;
mod varied;

pub use varied::Varied;

/// A row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Name of the field.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Least and greatest value that makes sense.
    pub range: (f64, f64),
    /// Source of the value, or how it was chosen and what a change of it does.
    pub origin: &'static str,
}

/// A struct whose fields are the numbers of a model.
pub trait Table: Copy {
    /// All rows, in the order of the fields.
    const ROWS: &'static [Row];

    /// The value in row `row`.
    fn value(&self, row: usize) -> f64;

    /// The table with `value` in row `row`; a count is rounded.
    #[must_use]
    fn with(self, row: usize, value: f64) -> Self;

    /// The table with the value in row `row` times `factor`, within its range. A count changes by one at least.
    #[must_use]
    fn scaled(self, row: usize, factor: f64) -> Self {
        let (value, (least, most)) = (self.value(row), Self::ROWS[row].range);
        let scaled = self.with(row, (value * factor).clamp(least, most));
        if scaled.value(row) != value {
            return scaled;
        }
        self.with(row, (value + (factor - 1.0).signum()).clamp(least, most))
    }

    /// True if each value is within the range of its row.
    #[must_use]
    fn within_ranges(&self) -> bool {
        Self::ROWS.iter().enumerate().all(|(row, Row { range: (least, most), .. })| {
            (*least..=*most).contains(&self.value(row))
        })
    }
}

/// A type that a number of a table can have.
pub trait Number: Copy {
    /// The number as a float.
    fn to_f64(self) -> f64;
    /// The nearest number of this type.
    fn from_f64(value: f64) -> Self;
}

impl Number for f64 {
    fn to_f64(self) -> f64 {
        self
    }

    fn from_f64(value: f64) -> Self {
        value
    }
}

impl Number for u32 {
    fn to_f64(self) -> f64 {
        self.into()
    }

    fn from_f64(value: f64) -> Self {
        value.round() as Self
    }
}

/// Declares a struct of parameters: see [the crate's example](crate). A row is
/// `name: type = value, "unit", least..=greatest, "origin";`, and the type is `f64` or `u32`.
#[macro_export]
macro_rules! parameters {
    (
        $(#[$about:meta])*
        $seen:vis struct $table:ident {
            $(
                $(#[$doc:meta])*
                $name:ident: $number:ty = $value:literal, $unit:literal, $least:literal..=$most:literal,
                $origin:literal;
            )+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $seen struct $table {
            $(
                $(#[$doc])*
                #[doc = concat!(
                    "\n`", stringify!($value), "` ", $unit, ", from ", stringify!($least), " to ",
                    stringify!($most), ". ", $origin
                )]
                pub $name: $number,
            )+
        }

        $(
            const _: () = assert!(
                $least as f64 <= $value as f64 && $value as f64 <= $most as f64,
                concat!(stringify!($name), " is out of its range"),
            );
        )+

        impl $table {
            /// The values of the table.
            pub const DEFAULT: Self = Self { $($name: $value,)+ };
        }

        impl Default for $table {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl $crate::Table for $table {
            const ROWS: &'static [$crate::Row] = &[$(
                $crate::Row {
                    name: stringify!($name),
                    unit: $unit,
                    range: ($least, $most),
                    origin: $origin,
                },
            )+];

            fn value(&self, row: usize) -> f64 {
                [$($crate::Number::to_f64(self.$name),)+][row]
            }

            fn with(mut self, row: usize, value: f64) -> Self {
                let mut place = 0;
                $(
                    if place == row {
                        self.$name = $crate::Number::from_f64(value);
                    }
                    place += 1;
                )+
                assert!(row < place, "the table has {place} rows");
                self
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    parameters! {
        /// A table.
        struct Pair {
            /// A length.
            length_m: f64 = 2.0, "m", 0.5..=2.2, "Chosen.";
            /// A count.
            scans: u32 = 2, "scans", 1.0..=9.0, "Chosen.";
        }
    }

    #[test]
    fn a_change_stays_within_the_range_and_touches_one_row() {
        let longer = Pair::DEFAULT.scaled(0, 1.2);
        assert_eq!((longer.length_m, longer.scans), (2.2, 2));
        assert_eq!(Pair::DEFAULT.scaled(0, 0.5).length_m, 1.0);
        assert_eq!([0.8, 1.2].map(|factor| Pair::DEFAULT.scaled(1, factor).scans), [1, 3]);
    }

    #[test]
    fn a_value_outside_of_its_range_is_found() {
        assert!(Pair::default().within_ranges());
        assert!(!Pair { length_m: 2.3, ..Pair::DEFAULT }.within_ranges());
        assert!(!Pair::DEFAULT.with(1, 0.0).within_ranges());
        assert!(!Pair::DEFAULT.with(0, f64::NAN).within_ranges());
    }
}
