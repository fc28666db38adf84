//! Ranges as data and in words, and the macro that declares quantities.

use std::fmt;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<T> {
    /// The quantity's noun, with its article.
    pub what: &'static str,
    pub least: T,
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
    pub value: T,
    pub range: Range<T>,
}

/// A number that can end a range.
pub trait End: Copy + fmt::Display {
    /// Writes the number as a person does: powers of ten for very large and very small ones.
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

/// Declares newtypes over numbers that are always inside their range, and so finite:
/// `Name: type, "what it is", least, most, "unit", "remark";`. A file holds a `$number`.
macro_rules! quantities {
    ($number:ty, $text:literal, $is_whole:literal, $traits:tt: $(
        $(#[$doc:meta])*
        $name:ident: $repr:ty, $what:literal, $least:expr, $most:expr, $unit:literal
        $(, $remark:literal)?;
    )+) => {$(
        quantities! {
            @type $traits $text,
            #[doc = concat!("Holds ", $what, ": ", $unit, "\n")]
            $(#[$doc])*
            $name: $repr
        }

        impl $name {
            pub const RANGE: Range<$number> = Range {
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
            pub const fn of(value: $repr) -> Self {
                assert!(value as $number >= $least, $what);
                assert!(value as $number <= $most, $what);
                Self(value)
            }

            /// The number, in the unit that the key's name carries.
            #[inline]
            pub const fn value(self) -> $repr {
                self.0
            }
        }

        impl TryFrom<$number> for $name {
            type Error = OutOfRange<$number>;

            fn try_from(value: $number) -> Result<Self, OutOfRange<$number>> {
                let is_inside = ($least..=$most).contains(&value);
                let refused = OutOfRange { value, range: Self::RANGE };
                is_inside.then_some(Self(value as $repr)).ok_or(refused)
            }
        }

        impl From<$name> for $number {
            fn from(quantity: $name) -> $number {
                quantity.0 as $number
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
    )+};
    (@type ($($trait:ident),*) $text:literal, $(#[$doc:meta])* $name:ident: $repr:ty) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, serde::Serialize, serde::Deserialize)]
        #[derive($($trait),*)]
        #[serde(try_from = $text, into = $text)]
        pub struct $name($repr);
    };
}

pub(super) use quantities;
