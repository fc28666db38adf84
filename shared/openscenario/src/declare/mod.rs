//! The language in which the elements of the standard are declared.
//!
//! One declaration of an element is its check, its reader and its row of the reference:
//!
//! ```text
//! elements! { "Actions";
//!     /// delta or factor of the other's speed                   the reference's text
//!     RelativeTargetSpeed -> SpeedTarget                         the element, and what its reader returns
//!     ["entityRef" entity: EntityName, "value" mps: Number as "m/s"]   attributes: name, variable, type, unit
//!     {_: Option<Properties>}                                    elements inside, by type
//!     unused ["note?"]                                           attributes that are known and have no effect
//!     |node| { Ok(SpeedTarget::Delta { entity, mps }) }          the value, from the variables
//! }
//! ```
//!
//! Without a value it is that of the only variable, or `()` without one.
//!
//! Types give the number of occurrences: `T` once, `Option<T>` at most once, `Vec<T>` any number,
//! [`AtLeastOne<T>`](AtLeastOne). [`OneOf<(A, B)>`](OneOf) is a choice. [`check`] holds a file against these
//! declarations; then the readers find what they ask for, and report an error otherwise.

mod attribute;
mod check;
mod content;
mod node;

use crate::error::ReadError;
pub(crate) use attribute::{
    AtLeastZero, AttributeForm, Bound, Count, Duration, FromAttribute, Given, Later, Literal,
    Number, Positive, Scalar, Text, Truth, Whole, kind_of, scalars, words,
};
pub(crate) use check::{CATALOG_VERSIONS, SCENARIO_VERSIONS, check, check_head};
pub(crate) use content::{AtLeastOne, ChildForm, Choice, Content, OneOf, Placed};
pub(crate) use node::Node;

pub(crate) trait Element {
    const NAME: &'static str;
    const FORM: &'static Form;
    type Value;

    /// Reads it. The node has been checked against the form.
    fn read(node: Node<'_>) -> Result<Self::Value, ReadError>;
}

/// The allowed content of an element, as the check and the reference see it.
#[derive(Debug)]
pub(crate) struct Form {
    /// The heading of its row in the reference.
    pub part: &'static str,
    pub effect: &'static str,
    pub attributes: &'static [AttributeForm],
    /// Attributes that have no effect; a name ends in `?` where it may be absent. `*` stands for any content.
    pub unused: &'static [&'static str],
    pub children: &'static [ChildForm],
}

macro_rules! elements {
    ($part:literal; $(
        $(#[doc = $effect:literal])+
        $name:ident $(= $xml:literal)? $(| $alias:ident)* -> $value:ty
        [$($attribute:literal $given:tt : $kind:ty $(as $unit:literal)?),* $(,)?]
        {$($child:tt : $content:ty),* $(,)?}
        $(unused [$($unused:literal)*])?
        $(|$node:ident|)? $($body:block)?
    )*) => {$(
        $(#[doc = $effect])+
        pub(crate) struct $name;

        impl $crate::declare::Element for $name {
            const NAME: &'static str = $crate::declare::elements!(@first $($xml)? (stringify!($name)));
            const FORM: &'static $crate::declare::Form = &$crate::declare::Form {
                part: $part,
                effect: concat!($($effect),+),
                attributes: &[$($crate::declare::AttributeForm::of::<$kind>(
                    $attribute,
                    $crate::declare::elements!(@first $($unit)? ("")),
                )),*],
                unused: &[$($($unused),*)?],
                children: &[$(<$content as $crate::declare::Content>::FORM),*],
            };
            type Value = $value;

            #[allow(clippy::let_unit_value, reason = "parts without effect have the value `()`")]
            fn read(
                node: $crate::declare::Node<'_>,
            ) -> Result<$value, $crate::error::ReadError> {
                $(let $given = <$kind as $crate::declare::FromAttribute>::read(node, $attribute)?;)*
                $(let $child = <$content as $crate::declare::Content>::read_inside(node)?;)*
                $(let $node = node;)?
                let _ = node;
                $crate::declare::elements!(@value [$($given)* $($child)*] $($body)?)
            }
        }

        $(
            /// Another name of the same form.
            pub(crate) struct $alias;

            impl $crate::declare::Element for $alias {
                const NAME: &'static str = stringify!($alias);
                const FORM: &'static $crate::declare::Form =
                    <$name as $crate::declare::Element>::FORM;
                type Value = $value;

                fn read(
                    node: $crate::declare::Node<'_>,
                ) -> Result<$value, $crate::error::ReadError> {
                    <$name as $crate::declare::Element>::read(node)
                }
            }
        )*
    )*};
    (@value [$(_)*]) => { Ok(()) };
    (@value [$(_)* $only:ident $(_)*]) => { Ok($only) };
    (@value [$($variable:tt)*] $body:block) => { $body };
    (@first $given:literal ($default:expr)) => { $given };
    (@first ($default:expr)) => { $default };
}

pub(crate) use elements;
