//! The attributes of serde that say what a key is called and what holds when it is left out.

use syn::{Attribute, Error, Lit, LitStr, Path, Token, Type};

/// The settings of a type, a field or a variant in serde's attributes.
#[derive(Default)]
pub(crate) struct Serde {
    pub(crate) default: Option<Fallback>,
    pub(crate) rename: Option<String>,
    pub(crate) rename_all: Case,
    /// The form that a list of fields must have, in words.
    pub(crate) expecting: Option<String>,
    /// The type that is read in place of this one.
    pub(crate) from: Option<Type>,
    /// True for a field that is not read.
    pub(crate) skip: bool,
}

/// The source of a default.
pub(crate) enum Fallback {
    /// From the type's own `Default`.
    Trait,
    /// From a function.
    Function(Path),
}

/// Spelling of names.
#[derive(Clone, Copy, Default)]
pub(crate) enum Case {
    #[default]
    AsDeclared,
    Kebab,
    Snake,
}

impl Serde {
    pub(crate) fn of(attributes: &[Attribute]) -> Result<Self, Error> {
        let mut found = Self::default();
        for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("serde")) {
            attribute.parse_nested_meta(|meta| {
                let name = meta.path.get_ident().map(ToString::to_string).unwrap_or_default();
                if !meta.input.peek(Token![=]) {
                    match name.as_str() {
                        "default" => found.default = Some(Fallback::Trait),
                        "skip" | "skip_deserializing" => found.skip = true,
                        _ => {}
                    }
                    return Ok(());
                }
                let value: Lit = meta.value()?.parse()?;
                let Lit::Str(value) = value else { return Ok(()) };
                match name.as_str() {
                    "default" => {
                        found.default = Some(Fallback::Function(value.parse::<Path>()?));
                    }
                    "expecting" => found.expecting = Some(value.value()),
                    "rename" => found.rename = Some(value.value()),
                    "rename_all" => found.rename_all = Case::of(&value)?,
                    "from" | "try_from" => found.from = Some(value.parse()?),
                    _ => {}
                }
                Ok(())
            })?;
        }
        Ok(found)
    }
}

impl Case {
    fn of(name: &LitStr) -> Result<Self, Error> {
        match name.value().as_str() {
            "kebab-case" => Ok(Self::Kebab),
            "snake_case" => Ok(Self::Snake),
            _ => Err(Error::new_spanned(name, "expected `kebab-case` or `snake_case`")),
        }
    }

    /// The name of a field, which is declared in snake case.
    pub(crate) fn of_field(self, name: &str) -> String {
        match self {
            Self::AsDeclared | Self::Snake => name.to_owned(),
            Self::Kebab => name.replace('_', "-"),
        }
    }

    /// The name of a variant, which is declared in camel case.
    pub(crate) fn of_variant(self, name: &str) -> String {
        let between = match self {
            Self::AsDeclared => return name.to_owned(),
            Self::Kebab => '-',
            Self::Snake => '_',
        };
        let mut written = String::new();
        for (place, letter) in name.char_indices() {
            if place > 0 && letter.is_ascii_uppercase() {
                written.push(between);
            }
            written.push(letter.to_ascii_lowercase());
        }
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_written_as_serde_writes_them() {
        assert_eq!(Case::Kebab.of_variant("RestartStorm"), "restart-storm");
        assert_eq!(Case::Snake.of_variant("GapBelowM"), "gap_below_m");
        assert_eq!(Case::Kebab.of_field("perception_sim"), "perception-sim");
        assert_eq!(Case::AsDeclared.of_variant("Fine"), "Fine");
    }
}
