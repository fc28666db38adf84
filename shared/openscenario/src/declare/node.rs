//! An element in its file, with all that its reader refers to.

use crate::error::{Place, ReadError};
use crate::scene::Scene;
use crate::scope::{Raw, Scope};
use crate::xml::Element;

/// An element that has been checked against its form.
#[derive(Clone, Copy)]
pub(crate) struct Node<'a> {
    pub file: &'a str,
    pub element: &'a Element,
    pub scope: &'a Scope,
    pub scene: &'a Scene<'a>,
}

impl<'a> Node<'a> {
    pub(crate) fn name(&self) -> &'a str {
        &self.element.name
    }

    pub(crate) fn place(&self) -> Place {
        Place { file: self.file.to_owned(), spot: self.element.spot }
    }

    pub(crate) fn refuse(
        &self,
        reason: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        ReadError::meaning(self.place(), reason, expected)
    }

    pub(crate) fn wrong(
        &self,
        attribute: &str,
        reason: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> ReadError {
        self.raw(attribute).wrong(reason, expected)
    }

    /// An attribute as it stands in the file; an absent one is empty and at its element's place.
    pub(crate) fn raw(&self, attribute: &str) -> Raw {
        let given = self.element.given(attribute);
        let spot = given.map_or(self.element.spot, |given| given.spot);
        Raw {
            text: given.map_or_else(String::new, |given| given.value.clone()),
            place: Place { file: self.file.to_owned(), spot },
            attribute: attribute.to_owned(),
            element: self.element.name.clone(),
        }
    }

    pub(crate) fn children(self) -> impl Iterator<Item = Self> {
        self.element.children.iter().map(move |element| Self { element, ..self })
    }
}
