//! Parts of messages that are checked and skipped.

use super::{Fields, Number};
use crate::PayloadError;
use std::ops::RangeInclusive;

/// A part in the standard's terms. Text is a list of characters, octets are a list of numbers.
#[derive(Debug)]
pub(in crate::codec) enum Part {
    /// A number, an enumeration, or a bit string of a fixed size.
    Whole(Number),
    /// A number whose bounds a later version may extend.
    ExtensibleNumber(Number),
    /// An enumeration that a later version may extend.
    ExtensibleEnumeration(Number),
    /// A bit string of this many bits; its length may differ in a later version.
    ExtensibleBits(u32),
    /// A list with the bounds of its count.
    List(Number, &'static Part),
    /// Fields in their order.
    Sequence(Form, &'static [Field]),
    /// One of several.
    Choice(Form, &'static [&'static Part]),
    /// Octets after their length, as in a regional extension.
    Open,
}

/// Whether a later version may add to a type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::codec) enum Form {
    Fixed,
    Extensible,
}

#[derive(Debug)]
pub(in crate::codec) struct Field {
    optional: bool,
    part: Part,
}

/// A field that is always present.
pub(in crate::codec) const fn required(part: Part) -> Field {
    Field { optional: false, part }
}

/// A field with a presence bit.
pub(in crate::codec) const fn optional(part: Part) -> Field {
    Field { optional: true, part }
}

/// Fields in their order.
pub(in crate::codec) const fn fixed(fields: &'static [Field]) -> Part {
    Part::Sequence(Form::Fixed, fields)
}

/// Fields in their order, to which a later version may add.
pub(in crate::codec) const fn extensible(fields: &'static [Field]) -> Part {
    Part::Sequence(Form::Extensible, fields)
}

/// A list with the bounds of its count.
pub(in crate::codec) const fn list(
    what: &'static str,
    count: RangeInclusive<i64>,
    entry: &'static Part,
) -> Part {
    Part::List(Number::new(what, *count.start(), *count.end()), entry)
}

/// An enumeration of `0` to `most` that a later version may extend.
pub(in crate::codec) const fn enumeration(what: &'static str, most: i64) -> Part {
    Part::ExtensibleEnumeration(Number::new(what, 0, most))
}

pub(in crate::codec) trait Skip: Fields {
    /// Checks and skips a part if its bit marked it as present.
    fn skip(&mut self, there: bool, part: &Part) -> Result<(), PayloadError> {
        if there { part.skip(self) } else { Ok(()) }
    }
}

impl<F: Fields> Skip for F {}

impl Part {
    pub(in crate::codec) const fn whole(what: &'static str, least: i64, most: i64) -> Self {
        Self::Whole(Number::new(what, least, most))
    }

    /// A bit string of a fixed size.
    pub(in crate::codec) const fn bits(what: &'static str, size: u32) -> Self {
        Self::whole(what, 0, (1 << size) - 1)
    }

    /// Checks and skips the part. It is written without content: empty, or with unknown numbers.
    pub(super) fn skip(&self, fields: &mut impl Fields) -> Result<(), PayloadError> {
        match self {
            Self::Whole(number) => fields.unread(*number),
            Self::ExtensibleNumber(number) => {
                if fields.bit(false)? {
                    fields.pass_open()
                } else {
                    fields.unread(*number)
                }
            }
            Self::ExtensibleEnumeration(number) => fields.enumeration(*number, number.most),
            Self::ExtensibleBits(size) => {
                let bits = if fields.bit(false)? { fields.length()? } else { (*size).into() };
                fields.pass(bits)
            }
            Self::List(count, entry) => {
                let count = fields.count(*count, count.least)?;
                (0..count).try_for_each(|_| entry.skip(fields))
            }
            Self::Sequence(form, parts) => skip_sequence(fields, *form, parts),
            Self::Choice(form, alternatives) => skip_choice(fields, *form, alternatives),
            Self::Open => fields.pass_open(),
        }
    }
}

fn skip_sequence(
    fields: &mut impl Fields,
    form: Form,
    parts: &[Field],
) -> Result<(), PayloadError> {
    let extended = form == Form::Extensible && fields.extended()?;
    let optional = parts.iter().filter(|field| field.optional).count();
    let bitmap = fields.whole(Number::new("optional parts", 0, (1 << optional) - 1), 0)?;
    let mut there = (0..optional).rev().map(|bit| bitmap >> bit & 1 == 1);
    for Field { optional, part } in parts {
        let there = !optional || there.next().unwrap_or(false);
        fields.skip(there, part)?;
    }
    if extended { fields.pass_additions() } else { Ok(()) }
}

fn skip_choice(
    fields: &mut impl Fields,
    form: Form,
    alternatives: &[&Part],
) -> Result<(), PayloadError> {
    if form == Form::Extensible && fields.extended()? {
        fields.pass_small()?;
        return fields.pass_open();
    }
    let number = Number::new("alternative", 0, alternatives.len() as i64 - 1);
    alternatives[fields.whole(number, 0)? as usize].skip(fields)
}
