//! The attributes of serde that say what a key is called and what holds when it is left out.

use syn::{Attribute, Error, Lit, LitStr, Path, Token};

/// The settings of a type, a field or a variant in serde's attributes.
#[derive(Default)]
pub(crate) struct Serde {
    /// The function that gives the default, or none for the type's own.
    pub(crate) default: Option<Option<Path>>,
    pub(crate) rename: Option<String>,
    /// Separator between the words of a variant's name, in small letters; none: the name as it is declared.
    pub(crate) separator: Option<char>,
    /// The form that a list of fields must have, in words.
    pub(crate) expecting: Option<String>,
    /// True for a field that is not read.
    pub(crate) skip: bool,
}

impl Serde {
    pub(crate) fn of(attributes: &[Attribute]) -> Result<Self, Error> {
        let mut found = Self::default();
        for attribute in attributes.iter().filter(|attribute| is_serde(attribute)) {
            attribute.parse_nested_meta(|meta| {
                let name = meta.path.get_ident().map(ToString::to_string).unwrap_or_default();
                if !meta.input.peek(Token![=]) {
                    match name.as_str() {
                        "default" => found.default = Some(None),
                        "skip" | "skip_deserializing" => found.skip = true,
                        _ => {}
                    }
                    return Ok(());
                }
                let value: Lit = meta.value()?.parse()?;
                let Lit::Str(value) = value else { return Ok(()) };
                match name.as_str() {
                    "default" => found.default = Some(Some(value.parse()?)),
                    "expecting" => found.expecting = Some(value.value()),
                    "rename" => found.rename = Some(value.value()),
                    "rename_all" => found.separator = Some(separator(&value)?),
                    _ => {}
                }
                Ok(())
            })?;
        }
        Ok(found)
    }

    /// The name of a variant, which is declared in camel case.
    pub(crate) fn spelled(&self, name: &str) -> String {
        let Some(separator) = self.separator else { return name.to_owned() };
        let mut written = String::new();
        for (place, letter) in name.char_indices() {
            if place > 0 && letter.is_ascii_uppercase() {
                written.push(separator);
            }
            written.push(letter.to_ascii_lowercase());
        }
        written
    }
}

fn separator(case: &LitStr) -> Result<char, Error> {
    match case.value().as_str() {
        "kebab-case" => Ok('-'),
        "snake_case" => Ok('_'),
        _ => Err(Error::new_spanned(case, "expected `kebab-case` or `snake_case`")),
    }
}

pub(crate) fn is_serde(attribute: &Attribute) -> bool {
    attribute.path().is_ident("serde")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_written_as_serde_writes_them() {
        let spelled = |separator, name| Serde { separator, ..Serde::default() }.spelled(name);
        assert_eq!(spelled(Some('-'), "RestartStorm"), "restart-storm");
        assert_eq!(spelled(Some('_'), "GapBelowM"), "gap_below_m");
        assert_eq!(spelled(None, "Fine"), "Fine");
    }
}
