//! The parameters that an element can refer to, and the values of its attributes.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::error::{Place, ReadError, meant};
use crate::expression::{Fault, Value, evaluate};

/// The parameters that an element can refer to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scope(BTreeMap<String, Value>);

impl Scope {
    pub(crate) fn value(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// This scope with more parameters, which hide its own of the same names.
    pub(crate) fn extended(&self, more: BTreeMap<String, Value>) -> Self {
        let mut values = self.0.clone();
        values.extend(more);
        Self(values)
    }
}

/// The text of an attribute, with where it stands.
#[derive(Clone, Debug)]
pub(crate) struct Raw {
    pub text: String,
    pub place: Place,
    pub attribute: String,
    pub element: String,
}

impl Raw {
    pub(crate) fn wrong(
        &self,
        reason: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> ReadError {
        let names = (self.attribute.as_str(), self.element.as_str());
        ReadError::attribute(self.place.clone(), names, reason, expected)
    }

    /// The value: a literal, `$name` or `${expression}`.
    pub(crate) fn resolve(&self, scope: &Scope) -> Result<Value, ReadError> {
        self.resolve_by(&mut |name| match scope.value(name) {
            Some(value) => Ok(value.clone()),
            None => {
                let expected = match scope.iter().next() {
                    None => "no parameter here".to_owned(),
                    Some(_) => meant(name, scope.iter().map(|(name, _)| name)),
                };
                Err(undeclared(&self.place, name, expected))
            }
        })
    }

    /// The same with parameters from `parameter`.
    pub(crate) fn resolve_by(
        &self,
        parameter: &mut dyn FnMut(&str) -> Result<Value, ReadError>,
    ) -> Result<Value, ReadError> {
        let trimmed = self.text.trim();
        if let Some(expression) = trimmed.strip_prefix("${") {
            let Some(expression) = expression.strip_suffix('}') else {
                return Err(
                    self.wrong(format!("`{}` is not closed", excerpt(trimmed)), "`}` at the end")
                );
            };
            return evaluate(expression, parameter).map_err(|wrong| match wrong {
                Fault::Expression(reason, expected) => {
                    let reason = format!("in `{}`: {}", excerpt(trimmed), excerpt(&reason));
                    self.wrong(reason, expected)
                }
                Fault::Parameter(error) => error,
            });
        }
        match trimmed.strip_prefix('$') {
            Some(name) => parameter(name),
            None => Ok(Value::literal(&self.text)),
        }
    }
}

pub(crate) fn undeclared(place: &Place, name: &str, expected: String) -> ReadError {
    let (place, parameter) = (place.clone(), name.to_owned());
    ReadError::Parameter { place, parameter, reason: "is not declared".to_owned(), expected }
}

/// Most characters of an expression that an error shows.
const MOST_SHOWN: usize = 200;

/// The beginning of a text, which is enough to find it.
fn excerpt(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_shows_the_beginning_of_a_long_expression() {
        assert_eq!(excerpt("${1 + 2}"), "${1 + 2}");
        let long = excerpt(&"(".repeat(100_000)).into_owned();
        assert!(long.ends_with('…') && long.chars().count() == MOST_SHOWN + 1, "{long}");
    }
}
