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
//! assert!(Brakes::ROWS[0].name == "deceleration_mps2" && Brakes::ROWS[0].accepts(harder.value(0)));
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

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub name: &'static str,
    pub unit: &'static str,
    /// Least and greatest value that makes sense.
    pub range: (f64, f64),
    /// The value must be above the least one.
    pub excludes_least: bool,
    /// Source of the value, or how it was chosen and what a change of it does.
    pub origin: &'static str,
}

impl Row {
    /// True if a value is within the range; NaN is not.
    pub fn accepts(&self, value: f64) -> bool {
        let (least, most) = self.range;
        (least..=most).contains(&value) && !(self.excludes_least && value == least)
    }
}

/// A struct whose fields are the numbers of a model.
pub trait Table: Clone {
    /// All rows, in the order of the fields.
    const ROWS: &'static [Row];

    /// The value in row `row`, unless it is absent.
    fn number(&self, row: usize) -> Option<f64>;

    /// The table with `value` in row `row`; a count is rounded.
    fn with(&self, row: usize, value: f64) -> Self;

    /// The value in row `row`; NaN for an absent one.
    fn value(&self, row: usize) -> f64 {
        self.number(row).unwrap_or(f64::NAN)
    }

    /// The table with the value in row `row` times `factor`, within its range. A count changes by one at least.
    fn scaled(&self, row: usize, factor: f64) -> Self {
        let (value, (least, most)) = (self.value(row), Self::ROWS[row].range);
        let scaled = self.with(row, (value * factor).clamp(least, most));
        if scaled.value(row) != value {
            return scaled;
        }
        self.with(row, (value + (factor - 1.0).signum()).clamp(least, most))
    }
}

/// A type that a number of a table can have.
pub trait Number: Copy {
    /// The number as a float, unless it is absent.
    fn number(self) -> Option<f64>;
    /// The nearest number of this type.
    fn from_f64(value: f64) -> Self;
}

macro_rules! numbers {
    ($($type:ty: |$own:ident| $number:expr, |$value:ident| $nearest:expr;)+) => {$(
        impl Number for $type {
            fn number(self) -> Option<f64> {
                let $own = self;
                $number
            }

            fn from_f64($value: f64) -> Self {
                $nearest
            }
        }
    )+};
}

numbers! {
    f64: |own| Some(own), |value| value;
    u32: |own| Some(own.into()), |value| value.round() as Self;
    usize: |own| Some(own as f64), |value| value.round() as Self;
    Option<f64>: |own| own, |value| Some(value);
}

/// Declares a struct of parameters: see [the crate's example](crate). A row is
/// `name: type = value, "unit", least..=greatest, "origin";`. The type is `f64`, `u32`, `usize`, or `Option<f64>` with the value
/// `None`. `above least..=greatest` leaves the least value out. Fields that are no numbers follow as
/// `others { name: type = value; }`. Such a table has a `Default` and no constant, and is not `Copy` by itself.
#[macro_export]
macro_rules! parameters {
    (@constant $table:ident { $($values:tt)* }) => {
        impl Copy for $table {}

        impl $table {
            /// The values of the table.
            pub const DEFAULT: Self = Self { $($values)* };
        }
    };
    (@constant $table:ident { $($values:tt)* } $($other:ident)+) => {};
    (
        $(#[$about:meta])*
        $seen:vis struct $table:ident {
            $(
                $(#[$doc:meta])+
                $name:ident: $number:ty = $($value:literal)? $($absent:ident)?, $unit:literal,
                $($above:ident)? $least:literal..=$most:literal, $origin:literal;
            )+
            $(others {
                $($(#[$other_doc:meta])+ $other:ident: $kind:ty = $usual:expr;)+
            })?
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq)]
        $seen struct $table {
            $(
                $(#[$doc])+
                #[doc = concat!(
                    "\n`", $(stringify!($value),)? $(stringify!($absent),)? "` ", $unit, ", from ",
                    $(stringify!($above), " ",)? stringify!($least), " to ", stringify!($most), ". ", $origin
                )]
                pub $name: $number,
            )+
            $($($(#[$other_doc])+ pub $other: $kind,)+)?
        }

        $($(
            const _: () = assert!(
                $least as f64 <= $value as f64 && $value as f64 <= $most as f64,
                concat!(stringify!($name), " is out of its range"),
            );
        )?)+

        $crate::parameters!(@constant $table { $($name: $($value)? $($absent)?,)+ } $($($other)+)?);

        impl Default for $table {
            fn default() -> Self {
                Self { $($name: $($value)? $($absent)?,)+ $($($other: $usual,)+)? }
            }
        }

        impl $crate::Table for $table {
            const ROWS: &'static [$crate::Row] = &[$(
                $crate::Row {
                    name: stringify!($name),
                    unit: $unit,
                    range: ($least, $most),
                    excludes_least: !stringify!($($above)?).is_empty(),
                    origin: $origin,
                },
            )+];

            fn number(&self, row: usize) -> Option<f64> {
                [$($crate::Number::number(self.$name),)+][row]
            }

            fn with(&self, row: usize, value: f64) -> Self {
                let (mut table, mut place) = (self.clone(), 0);
                $(
                    if place == row {
                        table.$name = $crate::Number::from_f64(value);
                    }
                    place += 1;
                )+
                assert!(row < place, "the table has {place} rows");
                table
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn within_ranges<T: Table>(table: &T) -> bool {
        let mut rows = T::ROWS.iter().enumerate();
        rows.all(|(place, row)| table.number(place).is_none_or(|value| row.accepts(value)))
    }

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
        assert!(within_ranges(&Pair::default()));
        assert!(!within_ranges(&Pair { length_m: 2.3, ..Pair::DEFAULT }));
        assert!(!within_ranges(&Pair::DEFAULT.with(1, 0.0)));
        assert!(!within_ranges(&Pair::DEFAULT.with(0, f64::NAN)));
    }

    parameters! {
        /// A table with a number that may be absent, and with a word.
        struct Kept {
            /// A share.
            share: f64 = 0.5, "1", above 0.0..=1.0, "Chosen.";
            /// A length.
            length_m: Option<f64> = None, "m", 1.0..=2.0, "Chosen.";
            others {
                /// A word.
                word: String = "usual".to_owned();
            }
        }
    }

    #[test]
    fn a_number_may_be_absent_and_its_least_value_left_out() {
        let usual = Kept::default();
        assert_eq!((usual.number(1), usual.word.as_str()), (None, "usual"));
        assert!(within_ranges(&usual) && within_ranges(&usual.with(1, 1.0)));
        assert!(!within_ranges(&usual.with(0, 0.0)) && !within_ranges(&usual.with(1, 0.5)));
        assert!(Kept::ROWS[0].excludes_least && !Kept::ROWS[1].excludes_least);
    }
}
