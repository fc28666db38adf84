//! `timegap search`: scenes and faults that break a requirement, found before the road does.
//!
//! ```text
//! problem ─ method ─► points ─ reference avoids? ─► runs ─► values ─► method …
//!                                                      └─► failures ─► minimal cases ─► failure-1.toml
//! ```
//!
//! A [`problem::Problem`] is a scenario with variables and a requirement. A method ([`method`]) chooses points one
//! after the other; a [`mod@reference`] driver decides which are worth a run. Their value
//! ([`record`]) is made small: below 0 a run is a failure. The command is a study of `frame`: journals, parts and results are the frame's.
//!
//! docs/search.md has the files, the methods and what they found.

#![forbid(unsafe_code)]

mod arguments;
pub mod distinct;
mod faults;
pub mod method;
pub mod minimal;
mod pictures;
pub mod probability;
pub mod problem;
pub mod record;
pub mod reference;
mod results;
mod rows;
mod study;

pub use arguments::SearchArguments;
pub use results::schema;
pub use study::{STUDIES, first_violation, run};
