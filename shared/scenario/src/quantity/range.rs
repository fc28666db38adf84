//! Ranges as data and in words, and the macros that declare quantities.

use std::fmt;

/// The range of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<T> {
    /// The quantity's noun, with its article.
    pub what: &'static str,
    /// Smallest value.
    pub least: T,
    /// Largest value.
    pub most: T,
    /// Unit; empty for a number without one, and for one whose key alone names it.
    pub unit: &'static str,
    /// Remark, with the sign that separates it from the range.
    pub remark: &'static str,
}

/// A number outside the range of its quantity.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{value} is out of range, expected {range}")]
pub struct OutOfRange<T: End> {
    /// The number.
    pub value: T,
    /// The range.
    pub range: Range<T>,
}

/// A number that can end a range.
pub trait End: Copy + fmt::Display {
    /// Writes the number as a person does: powers of ten for very large and very small ones.
    ///
    /// # Errors
    /// Those of the formatter.
    fn write(self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl End for i64 {}

impl End for f64 {
    fn write(self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.abs() {
            size if size >= 1e6 || (size > 0.0 && size < 1e-3) => write!(f, "{self:e}"),
            _ => write!(f, "{self}"),
        }
    }
}

impl<T: End> fmt::Display for Range<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} from ", self.what)?;
        self.least.write(f)?;
        f.write_str(" to ")?;
        self.most.write(f)?;
        let space = if self.unit.is_empty() { "" } else { " " };
        write!(f, "{space}{}{}", self.unit, self.remark)
    }
}

impl<T: End> crate::refusal::Explained for OutOfRange<T> {
    fn message(&self) -> String {
        format!("{} is out of range", self.value)
    }

    fn expected(&self) -> String {
        self.range.to_string()
    }
}

/// Implements reading and the schema of a quantity with a `RANGE`, which is read as a `$number`.
macro_rules! read_as {
    ($name:ident, $number:ty, $is_whole:literal) => {
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                crate::refusal::convert::<$number, Self, D>(deserializer)
            }
        }

        impl crate::schema::Schema for $name {
            fn shape() -> crate::schema::Shape {
                let range = Some((Self::RANGE.least as f64, Self::RANGE.most as f64));
                crate::schema::Shape::Number { is_whole: $is_whole, range, unit: Self::RANGE.unit }
            }

            fn expected() -> Option<String> {
                Some(Self::RANGE.to_string())
            }
        }
    };
}

/// Declares newtypes over `f64` that are always finite and inside their range:
/// `Name: "what it is", least, most, "unit", "remark";`.
macro_rules! quantity {
    ($(
        $(#[$doc:meta])*
        $name:ident: $what:literal, $least:expr, $most:expr, $unit:literal $(, $remark:literal)?;
    )+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, serde::Serialize)]
        #[serde(into = "f64")]
        pub struct $name(f64);

        impl $name {
            /// Range of the values.
            pub const RANGE: Range<f64> = Range {
                what: $what,
                least: $least,
                most: $most,
                unit: $unit,
                remark: concat!($($remark)?),
            };

            /// Wraps a literal.
            ///
            /// # Panics
            /// When the value is outside the range of the type.
            #[must_use]
            pub const fn of(value: f64) -> Self {
                assert!(value >= $least, $what);
                assert!(value <= $most, $what);
                Self(value)
            }

            /// The number, in the unit that the key's name carries.
            #[must_use]
            #[inline]
            pub const fn value(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = OutOfRange<f64>;

            fn try_from(value: f64) -> Result<Self, OutOfRange<f64>> {
                let is_inside = ($least..=$most).contains(&value);
                is_inside.then_some(Self(value)).ok_or(OutOfRange { value, range: Self::RANGE })
            }
        }

        impl From<$name> for f64 {
            fn from(quantity: $name) -> f64 {
                quantity.0
            }
        }

        range::read_as!($name, f64, false);
    )+};
}

/// Declares newtypes over whole numbers inside a range:
/// `Name: type, "what it is", least, most, "unit", "remark";`.
macro_rules! whole {
    ($(
        $(#[$doc:meta])*
        $name:ident: $repr:ty, $what:literal, $least:expr, $most:expr, $unit:literal
        $(, $remark:literal)?;
    )+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
        #[serde(into = "i64")]
        pub struct $name($repr);

        impl $name {
            /// Range of the values.
            pub const RANGE: Range<i64> = Range {
                what: $what,
                least: $least,
                most: $most,
                unit: $unit,
                remark: concat!($($remark)?),
            };

            /// Wraps a literal.
            ///
            /// # Panics
            /// When the value is outside the range of the type.
            #[must_use]
            pub const fn of(value: $repr) -> Self {
                assert!(value as i64 >= $least, $what);
                assert!(value as i64 <= $most, $what);
                Self(value)
            }

            /// The number, in the unit that the key's name carries.
            #[must_use]
            #[inline]
            pub const fn value(self) -> $repr {
                self.0
            }
        }

        impl TryFrom<i64> for $name {
            type Error = OutOfRange<i64>;

            fn try_from(value: i64) -> Result<Self, OutOfRange<i64>> {
                let is_inside = ($least..=$most).contains(&value);
                let refused = OutOfRange { value, range: Self::RANGE };
                is_inside.then_some(Self(value as $repr)).ok_or(refused)
            }
        }

        impl From<$name> for i64 {
            fn from(number: $name) -> i64 {
                number.0 as i64
            }
        }

        range::read_as!($name, i64, true);
    )+};
}

pub(super) use {quantity, read_as, whole};
