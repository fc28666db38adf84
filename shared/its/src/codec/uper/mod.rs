//! Unaligned PER (ITU-T X.691) for the three messages.
//!
//! | file | idea |
//! |---|---|
//! | `fields` | a number's name and bounds; the fields of a message, for both directions |
//! | `reader` | fields from bits |
//! | `writer` | fields to bits |
//! | `part` | parts that are checked and skipped, as tables |
//!
//! A frame has at most 1,500 bytes. Every list has a bound, and the tables of `part` have no cycle. So a
//! message cannot demand memory or depth beyond that.

mod fields;
mod part;
mod reader;
mod writer;

#[cfg(all(test, feature = "oracle"))]
pub(super) mod dice;

pub(super) use fields::{Fields, Number};
pub(super) use part::{Form, Part, Skip, enumeration, extensible, fixed, list, optional, required};
pub(super) use reader::Reader;
pub(super) use writer::Writer;
