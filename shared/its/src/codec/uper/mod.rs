//! Unaligned PER (ITU-T X.691) for the three messages.
//!
//! | file | idea |
//! |---|---|
//! | `writer` | fields to bits |
//! | `source` | a number's name and bounds, for both directions; the ways in which a type can be extended |
//! | `reader` | fields from bits |
//! | `part` | parts that are checked and skipped, as tables |
//!
//! A frame has at most 1,500 bytes. Every list has a bound, and the tables of `part` have no cycle. So a
//! message cannot demand memory or depth beyond that.

mod part;
mod reader;
mod source;
mod writer;

#[cfg(all(test, feature = "oracle"))]
pub(super) mod dice;

pub(super) use part::{Form, Part, Skip, enumeration, extensible, fixed, list, optional, required};
pub(super) use reader::Reader;
pub(super) use source::{Number, Source};
pub(super) use writer::Writer;
