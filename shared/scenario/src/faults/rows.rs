//! The macro that declares the kinds of faults.

/// Declares the kinds of faults, by families. A row is
/// `Variant = "name", on target, lasting length { /// Meaning. key: type, }`; target and length are expressions in the
/// keys. The reader, the written form, the JSON Schema, the reference and the options of `timegap inject` are made of
/// the rows.
macro_rules! kinds {
    ($(
        $(#[$about:meta])*
        $family:ident {
            $(
                $(#[$doc:meta])*
                $kind:ident = $name:literal $(, on $target:expr)? $(, lasting $length:expr)? => {
                    $($(#[$meaning:meta])* $key:ident: $type:ty,)*
                }
            )+
        }
    )+) => {
        $(
            $(#[$about])*
            #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
            #[serde(tag = "kind")]
            pub enum $family {
                $(
                    $(#[$doc])*
                    #[serde(rename = $name)]
                    $kind {
                        $($(#[$meaning])* $key: $type,)*
                    },
                )+
            }

            impl $family {
                pub const fn kind(&self) -> Kind {
                    match self {
                        $(Self::$kind { .. } => Kind::$kind,)+
                    }
                }

                /// Its target, if its own keys name one.
                #[allow(unused_variables, dead_code, reason = "a row names the keys that it needs")]
                fn target(&self) -> Option<Target> {
                    match self {
                        $(Self::$kind { $($key),* } => {
                            let target: Option<Target> = None;
                            $(let target = Some($target);)?
                            target
                        })+
                    }
                }

                #[allow(unused_variables, dead_code, reason = "a row names the keys that it needs")]
                fn length(&self) -> Option<Duration> {
                    match self {
                        $(Self::$kind { $($key),* } => {
                            let length: Option<Duration> = None;
                            $(let length = $length;)?
                            length
                        })+
                    }
                }
            }
        )+

        tables! {
            /// Kind of a fault: its name in files, on the command line and in results.
            #[derive(PartialOrd, Ord)]
            pub enum Kind {
                $($(
                    $(#[$doc])*
                    #[serde(rename = $name)]
                    $kind,
                )+)+
            }
        }
    };
}

pub(super) use kinds;
