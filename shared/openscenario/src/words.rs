//! Words of a file that stand for the variants of an enumeration.

/// An enumeration whose variants have words.
pub(crate) trait Words: Copy + 'static {
    /// The words with their meanings, in the order in which errors list them.
    const WORDS: &'static [(&'static str, Self)];

    /// The first word of a variant.
    fn word(self) -> &'static str
    where
        Self: PartialEq,
    {
        Self::WORDS.iter().find(|(_, known)| *known == self).map_or("", |(word, _)| word)
    }
}

/// Declares enumerations, each variant with its words.
macro_rules! word_enums {
    ($($(#[$meta:meta])* $name:ident {
        $($(#[$about:meta])* $variant:ident: $($word:literal)|+,)+
    })*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name {
            $($(#[$about])* $variant,)+
        }

        impl $crate::words::Words for $name {
            const WORDS: &'static [(&'static str, Self)] = &[$($(($word, Self::$variant)),+),+];
        }
    )*};
}

pub(crate) use word_enums;
