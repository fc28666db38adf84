//! An element in its file and scope: typed access to attributes, with errors that say where.

use crate::error::{Place, ReadError, one_of};
use crate::expression::Value;
use crate::parameter::{AttributeFault, Scope};
use crate::xml::Element;

/// Largest magnitude of a number, in any unit: beyond it nothing that moves stays finite.
const MAX_NUMBER: f64 = 1e9;

/// An element that has been held against the subset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<'a> {
    pub(crate) file: &'a str,
    pub(crate) element: &'a Element,
    pub(crate) scope: &'a Scope,
}

impl<'a> Node<'a> {
    pub(crate) fn name(&self) -> &'a str {
        &self.element.name
    }

    pub(crate) fn place(&self) -> Place {
        Place { file: self.file.to_owned(), line: self.element.line }
    }

    /// The error that this element cannot be simulated.
    pub(crate) fn refuse(
        &self,
        reason: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        ReadError::Meaning { place: self.place(), reason: reason.into(), expected: expected.into() }
    }

    pub(crate) fn fault(&self, attribute: &'a str) -> AttributeFault<'a> {
        AttributeFault { file: self.file, element: self.element, attribute }
    }

    fn at(&self, element: &'a Element) -> Self {
        Self { element, ..*self }
    }

    /// The child of that name, which the subset demands.
    pub(crate) fn child(&self, name: &str) -> Result<Self, ReadError> {
        self.child_if(name).ok_or_else(|| ReadError::Element {
            place: self.place(),
            element: name.to_owned(),
            parent: self.element.name.clone(),
            fault: "is missing",
            expected: "one".to_owned(),
        })
    }

    pub(crate) fn child_if(&self, name: &str) -> Option<Self> {
        self.element.child(name).map(|child| self.at(child))
    }

    pub(crate) fn children(&self) -> impl Iterator<Item = Self> + use<'a> {
        let here = *self;
        here.element.children.iter().map(move |child| here.at(child))
    }

    pub(crate) fn named(&self, name: &'a str) -> impl Iterator<Item = Self> + use<'a> {
        self.children().filter(move |child| child.name() == name)
    }

    /// The first child of one of these names, which the subset demands.
    pub(crate) fn chosen(&self, names: &[&str]) -> Result<Self, ReadError> {
        self.children().find(|child| names.contains(&child.name())).ok_or_else(|| {
            self.refuse(format!("`{}` is empty", self.element.name), one_of(names.iter().copied()))
        })
    }

    pub(crate) fn value(&self, attribute: &'a str) -> Result<Option<Value>, ReadError> {
        let Some(text) = self.element.attribute(attribute) else { return Ok(None) };
        if !text.trim_start().starts_with('$') {
            return Ok(Some(Value::literal(text)));
        }
        self.scope.resolve(text, &self.fault(attribute)).map(Some)
    }

    pub(crate) fn text_if(&self, attribute: &'a str) -> Result<Option<String>, ReadError> {
        match self.element.attribute(attribute) {
            Some(text) if !text.trim_start().starts_with('$') => Ok(Some(text.to_owned())),
            _ => Ok(self.value(attribute)?.map(|value| value.text())),
        }
    }

    pub(crate) fn text(&self, attribute: &'a str) -> Result<String, ReadError> {
        self.text_if(attribute)?.ok_or_else(|| self.fault(attribute).error("is missing", "a value"))
    }

    pub(crate) fn number_if(&self, attribute: &'a str) -> Result<Option<f64>, ReadError> {
        let Some(value) = self.value(attribute)? else { return Ok(None) };
        match value.number() {
            Some(number) => Ok(Some(number)),
            None => {
                let reason = format!("`{}` is not a number", value.text());
                Err(self.fault(attribute).error(reason, "a number"))
            }
        }
    }

    /// A finite number of a plausible magnitude.
    pub(crate) fn number(&self, attribute: &'a str) -> Result<f64, ReadError> {
        let number = self
            .number_if(attribute)?
            .ok_or_else(|| self.fault(attribute).error("is missing", "a number"))?;
        match number.abs() <= MAX_NUMBER {
            true => Ok(number),
            false => {
                let expected = format!("a number from -{MAX_NUMBER:e} to {MAX_NUMBER:e}");
                Err(self.fault(attribute).error(format!("{number} is out of range"), expected))
            }
        }
    }

    pub(crate) fn number_or(&self, attribute: &'a str, default: f64) -> Result<f64, ReadError> {
        match self.element.attribute(attribute) {
            Some(_) => self.number(attribute),
            None => Ok(default),
        }
    }

    /// A number that is 0 or more.
    pub(crate) fn magnitude(&self, attribute: &'a str) -> Result<f64, ReadError> {
        match self.number(attribute)? {
            number if number >= 0.0 => Ok(number),
            number => {
                Err(self.fault(attribute).error(format!("{number} is negative"), "0 or more"))
            }
        }
    }

    pub(crate) fn integer(&self, attribute: &'a str) -> Result<i32, ReadError> {
        let number = self.number(attribute)?;
        if libm::trunc(number) != number || number.abs() > 1e6 {
            let reason = format!("{number} is not a whole number");
            return Err(self.fault(attribute).error(reason, "a whole number"));
        }
        Ok(number as i32)
    }

    pub(crate) fn boolean(&self, attribute: &'a str) -> Result<bool, ReadError> {
        match self.value(attribute)? {
            Some(Value::Boolean(value)) => Ok(value),
            Some(Value::Number(number)) if number == 0.0 || number == 1.0 => Ok(number == 1.0),
            Some(other) => {
                let reason = format!("`{}` is not a truth value", other.text());
                Err(self.fault(attribute).error(reason, "true or false"))
            }
            None => Err(self.fault(attribute).error("is missing", "true or false")),
        }
    }

    /// One of some words.
    pub(crate) fn word<T: Copy>(
        &self,
        attribute: &'a str,
        words: &[(&str, T)],
    ) -> Result<T, ReadError> {
        let text = self.text(attribute)?;
        words.iter().find(|(word, _)| *word == text).map(|(_, value)| *value).ok_or_else(|| {
            self.fault(attribute).error(
                format!("`{text}` is not supported"),
                one_of(words.iter().map(|(word, _)| *word)),
            )
        })
    }

    pub(crate) fn word_if<T: Copy>(
        &self,
        attribute: &'a str,
        words: &[(&str, T)],
    ) -> Result<Option<T>, ReadError> {
        match self.element.attribute(attribute) {
            Some(_) => self.word(attribute, words).map(Some),
            None => Ok(None),
        }
    }
}
