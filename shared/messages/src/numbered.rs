//! Enums whose numbers stand in messages and whose names stand in results: each variant is one row.

/// Declares an enum: `Variant = number "name",`. Numbers count from the first row's upwards.
#[macro_export]
macro_rules! numbered {
    (
        $(#[$about:meta])*
        pub enum $type:ident {
            $($(#[$doc:meta])* $variant:ident = $number:literal $name:literal,)+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $type {
            $($(#[$doc])* $variant = $number,)+
        }

        impl $type {
            /// All values, in the order of their numbers.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$variant),+];

            /// Each number with its name.
            pub const NAMES: &'static [(u32, &'static str)] = &[$(($number, $name)),+];

            /// Name in results.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }

            /// Value with this number; `None` without one.
            pub const fn by_number(number: u32) -> Option<Self> {
                match number {
                    $($number => Some(Self::$variant),)+
                    _ => None,
                }
            }
        }
    };
}
