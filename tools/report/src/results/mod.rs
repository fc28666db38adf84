//! A result declared once: its columns give every output.
//!
//! ```text
//!                 ┌─► console (transposed or narrowed to its width)
//! Column ─► Table ├─► page, Markdown (best of a column marked)
//!           Document ─► JSON, CSV, JUnit XML
//!       └─► Schema ─► `timegap list --schema results`
//! ```
//!
//! A [`Column`] has a name: the dotted path of its value in the row's JSON. It also has unit, meaning and format. A
//! [`Table`] is columns over rows. A [`Document`] is verdict, tables and charts of one command;
//! [`ResultOptions::deliver`] writes and prints it. [`Schema`] describes the JSON.

mod column;
mod console;
mod document;
mod head;
mod junit;
mod markdown;
mod options;
mod page;
mod schema;
mod table;

pub use column::{
    Column, at, column, count, fact, flag, judged, micros, nested, number, outcome, value, word,
};
pub use console::{folded, width};
pub use document::{Attachment, Contents, Document, Fill, Part};
pub use head::{Format, Good, Head, Kind};
pub use options::{ExportError, ResultOptions};
pub use schema::{Schema, check, document as schema_document};
pub use table::{Table, csv_head, csv_line, field};
