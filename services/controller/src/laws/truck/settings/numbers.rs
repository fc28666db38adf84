//! Tables of numbers: each key is written once, with its meaning, default and range.

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
            /// Shows every value with its range.
            pub(super) fn ranges(&self, see: &mut crate::settings::Ranges<'_>) {
                $(see.optional(
                    concat!($table, ".", stringify!($key)),
                    super::numbers::Number::number(self.$key),
                    $least,
                    $most,
                );)+
            }
        }
    };
}

pub(super) use numbers;
