//! Tables of numbers: each key is written once, with its meaning, default and range.

use crate::settings::{SettingError, within};

/// A value that may be absent.
pub(super) trait Number: Copy {
    /// The value, if there is one.
    fn number(self) -> Option<f64>;
}

impl Number for f64 {
    fn number(self) -> Option<f64> {
        Some(self)
    }
}

impl Number for u32 {
    fn number(self) -> Option<f64> {
        Some(f64::from(self))
    }
}

impl Number for Option<f64> {
    fn number(self) -> Option<f64> {
        self
    }
}

/// Accepts an absent number, and one within its range.
pub(super) fn check(
    key: &'static str,
    value: impl Number,
    least: f64,
    most: f64,
) -> Result<(), SettingError> {
    value.number().map_or(Ok(()), |value| within(key, value, least, most))
}

/// Declares the table `$table` of a law as a struct: `pub key: type = default, least to most;`.
macro_rules! numbers {
    (
        $table:literal,
        $(#[$about:meta])*
        pub struct $name:ident {
            $(
                $(#[$meaning:meta])*
                pub $key:ident: $type:ty = $default:expr, $least:literal to $most:literal;
            )+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize, scenario::schema::Schema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $($(#[$meaning])* pub $key: $type,)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)+ }
            }
        }

        impl $name {
            /// Checks every value.
            pub(super) fn check(&self) -> Result<(), crate::settings::SettingError> {
                $(super::numbers::check(
                    concat!($table, ".", stringify!($key)), self.$key, $least, $most,
                )?;)+
                Ok(())
            }
        }
    };
}

pub(super) use numbers;
