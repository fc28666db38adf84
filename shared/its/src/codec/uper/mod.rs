//! Unaligned PER (ITU-T X.691) for the three messages.
//!
//! | file | idea |
//! |---|---|
//! | `fields` | a number's name and bounds; the fields of a message, for both directions |
//! | `bits` | fields from bits and to bits |
//! | `part` | parts that are checked and skipped, as tables |
//!
//! A frame has at most 1,500 bytes. Every list has a bound, and the tables of `part` have no cycle. So a
//! message cannot demand memory or depth beyond that.

mod bits;
mod fields;
mod part;

#[cfg(all(test, feature = "oracle"))]
pub(super) mod dice;

pub(super) use bits::{Reader, Writer};
pub(super) use fields::{Fields, Number};
pub(super) use part::{Form, Part, Skip, enumeration, extensible, fixed, list, optional, required};
