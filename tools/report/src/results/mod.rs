//! A result declared once: its type gives the JSON and its schema, its columns give every output for people.
//!
//! ```text
//! type (serde, schemars) ─► JSON, Schema ─► `timegap print schema results`
//!
//!                 ┌─► console (chosen by its width, cut in its length)
//! Column ─► Table ├─► page, Markdown (best of a column marked)
//!           Document ─► JSON, CSV, JUnit XML
//! ```
//!
//! A [`Column`] has a name: the dotted path of its value in the row's JSON. It also has unit, meaning and format. The
//! columns of a drive's figures stand in [`figures`](crate::figures). A [`Table`] is columns over rows. A [`Document`]
//! is verdict, what broke, tables and charts of one command; [`ResultOptions::deliver`] writes and prints it.
//! [`Schema::of`] describes the JSON of a type.

mod column;
mod console;
mod document;
mod head;
mod integration;
mod options;
mod page;
mod schema;
mod table;

pub use column::{
    Column, at, column, count, fact, flag, judged, micros, number, outcome, value, word,
};
pub use console::{folded, width};
pub use document::{Broken, Document, Part};
pub use head::{Format, Good, Head, duration};
pub use options::ResultOptions;
pub use schema::{Object, Schema, document as schema_document};
pub use table::{Fact, Table, csv_fields, csv_names, field};
