//! Reading of scenario files.
//!
//! ```text
//! text ─► values ─► overrides laid over ─► form checked ─► types ─► completed, checked
//!        (document)     (overrides)        (form)                   (load, open, crate::check)
//!                                               │
//!                              Problem: a path ─► place in the text (document) ─► ScenarioError (error)
//! ```

mod document;
mod error;
mod foreign;
mod form;
mod law_tables;
mod load;
mod open;
mod overrides;
mod reads;
mod setting;

pub(crate) mod csv;
pub(crate) mod problem;
pub(crate) mod text_file;

pub use document::MAX_TEXT_BYTES;
pub use error::{Refusal, ScenarioError};
pub use law_tables::LawTables;
pub use open::Source;
pub use overrides::Overrides;
pub use problem::Problem;
pub use reads::Reads;
pub use setting::{Setting, option_value};

pub(crate) use document::{Document, KEPT};
pub(crate) use foreign::Foreign;
pub(crate) use form::{check_form, plain};
#[cfg(test)]
pub(crate) use open::Place;
pub(crate) use problem::refuse;
