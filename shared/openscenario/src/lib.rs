//! ASAM OpenSCENARIO XML 1.0 to 1.3: a longitudinal and lane subset.
//!
//! ```text
//! files --read--> Script --new--> World --step(time, ego)--> motions
//!         |                         |
//!         subset, parameters,       actions, conditions, storyboard
//!         catalogs, road
//! ```
//!
//! * [`read`] turns a scenario file, its catalogs and its road into a [`model::Script`], or refuses it
//!   with file, line and what was expected. What it accepts is the table in [`subset`].
//! * [`world::World`] moves a script: a pure function of its state, the time and what its caller moves.
//! * [`variation`] gives the combinations of a parameter value distribution.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is no number fails a check that is written so"
)]

pub mod error;
pub mod expression;
pub mod library;
pub mod model;
mod node;
pub mod parameter;
pub mod read;
pub mod road;
pub mod subset;
pub mod variation;
pub mod world;
pub mod xml;

pub use error::ReadError;
pub use expression::Value;
pub use library::{Disk, Source};
pub use model::Script;
pub use parameter::Assignment;
pub use world::{Motion, World, WorldError};
