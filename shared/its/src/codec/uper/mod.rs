//! Unaligned PER (ITU-T X.691) for the three messages.
//!
//! | file | idea |
//! |---|---|
//! | `number` | a whole number's name and bounds, one declaration for both directions |
//! | `writer` | fields to bits |
//! | `source`, `reader` | fields from bits; the ways in which a type can be extended |
//! | `part` | parts that are checked and skipped, as tables |
//!
//! A frame has at most 1,500 bytes. Every list has a bound, and the tables of `part` have no cycle. So a
//! message cannot demand memory or depth beyond that.

mod number;
mod part;
mod reader;
mod source;
mod writer;

#[cfg(all(test, feature = "oracle"))]
pub(super) mod dice;

pub(super) use number::Number;
pub(super) use part::{Form, Part, Skip, optional, required};
pub(super) use reader::Reader;
pub(super) use source::Source;
pub(super) use writer::Writer;
