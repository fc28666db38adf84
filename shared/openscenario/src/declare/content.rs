//! Elements inside an element: how many, and which.

use std::marker::PhantomData;

use super::{Element, Form, Node};
use crate::error::{Place, ReadError, one_of};

/// Elements of which one stands in a place.
pub(crate) trait Choice {
    const ALTERNATIVES: &'static [(&'static str, &'static Form)];
    type Value;

    fn read_chosen(node: Node<'_>) -> Result<Self::Value, ReadError>;
}

impl<E: Element> Choice for E {
    const ALTERNATIVES: &'static [(&'static str, &'static Form)] = &[(E::NAME, E::FORM)];
    type Value = E::Value;

    fn read_chosen(node: Node<'_>) -> Result<E::Value, ReadError> {
        E::read(node)
    }
}

pub(crate) struct OneOf<T>(PhantomData<T>);

macro_rules! choices {
    ($(($first:ident $($other:ident)+))+) => {$(
        impl<$first: Element, $($other: Element<Value = $first::Value>),+> Choice
            for OneOf<($first, $($other),+)>
        {
            const ALTERNATIVES: &'static [(&'static str, &'static Form)] =
                &[($first::NAME, $first::FORM), $(($other::NAME, $other::FORM)),+];
            type Value = $first::Value;

            fn read_chosen(node: Node<'_>) -> Result<$first::Value, ReadError> {
                match node.name() {
                    $(name if name == $other::NAME => $other::read(node),)+
                    _ => $first::read(node),
                }
            }
        }
    )+};
}

choices! {
    (A B) (A B C) (A B C D) (A B C D E) (A B C D E F) (A B C D E F G) (A B C D E F G H) (A B C D E F G H I)
    (A B C D E F G H I J K L M N)
}

/// A choice with its place: its reader returns both.
pub(crate) struct Placed<C>(PhantomData<C>);

impl<C: Choice> Choice for Placed<C> {
    const ALTERNATIVES: &'static [(&'static str, &'static Form)] = C::ALTERNATIVES;
    type Value = (Place, C::Value);

    fn read_chosen(node: Node<'_>) -> Result<Self::Value, ReadError> {
        Ok((node.place(), C::read_chosen(node)?))
    }
}

/// Number of times that one of some elements stands in another.
#[derive(Debug)]
pub(crate) struct ChildForm {
    pub alternatives: &'static [(&'static str, &'static Form)],
    pub least: usize,
    pub most: usize,
}

impl ChildForm {
    const fn of<C: Choice>(least: usize, most: usize) -> Self {
        Self { alternatives: C::ALTERNATIVES, least, most }
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.alternatives.iter().map(|(name, _)| *name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.names().any(|known| known == name)
    }
}

/// A part of an element's content: a choice and how often it stands there.
pub(crate) trait Content {
    const FORM: ChildForm;
    type Value;

    fn read_inside(parent: Node<'_>) -> Result<Self::Value, ReadError>;
}

impl<C: Choice> Content for C {
    const FORM: ChildForm = ChildForm::of::<C>(1, 1);
    type Value = C::Value;

    fn read_inside(parent: Node<'_>) -> Result<C::Value, ReadError> {
        match all::<C>(parent).next() {
            Some(child) => child,
            None => {
                let names = C::ALTERNATIVES.iter().map(|(name, _)| *name);
                Err(parent.refuse(format!("`{}` lacks an element", parent.name()), one_of(names)))
            }
        }
    }
}

impl<C: Choice> Content for Option<C> {
    const FORM: ChildForm = ChildForm::of::<C>(0, 1);
    type Value = Option<C::Value>;

    fn read_inside(parent: Node<'_>) -> Result<Self::Value, ReadError> {
        all::<C>(parent).next().transpose()
    }
}

impl<C: Choice> Content for Vec<C> {
    const FORM: ChildForm = ChildForm::of::<C>(0, usize::MAX);
    type Value = Vec<C::Value>;

    fn read_inside(parent: Node<'_>) -> Result<Self::Value, ReadError> {
        all::<C>(parent).collect()
    }
}

pub(crate) struct AtLeastOne<C>(PhantomData<C>);

impl<C: Choice> Content for AtLeastOne<C> {
    const FORM: ChildForm = ChildForm::of::<C>(1, usize::MAX);
    type Value = Vec<C::Value>;

    fn read_inside(parent: Node<'_>) -> Result<Self::Value, ReadError> {
        all::<C>(parent).collect()
    }
}

/// The values of all elements of a choice, in the order of the file.
fn all<C: Choice>(parent: Node<'_>) -> impl Iterator<Item = Result<C::Value, ReadError>> {
    let chosen = |child: &Node<'_>| C::ALTERNATIVES.iter().any(|(name, _)| *name == child.name());
    parent.children().filter(chosen).map(C::read_chosen)
}
