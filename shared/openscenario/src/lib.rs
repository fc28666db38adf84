//! ASAM OpenSCENARIO XML 1.0 to 1.3: reader, storyboard and moving world of a longitudinal and lane subset.
//!
//! ```text
//! files --read--> Script --new--> World --step(time, ego)--> motions
//!         |                         |
//!         declared elements,        actions, conditions, storyboard
//!         parameters, catalogs, road
//! ```
//!
//! * [`read`] turns a scenario file, its catalogs and its road into a [`Script`]. It refuses a file with place,
//!   fault and what was expected.
//! * Each element of the standard is declared once, with its attributes, their types and units, and the elements
//!   inside it. The check of a file, its reader and the [`mod@reference`] come from this declaration.
//! * [`World`] moves a script: a pure function of its state, the time and the motion of the ego.
//! * [`variation`] gives the combinations of a parameter value distribution.
//!
//! A car cuts in 40 m ahead of an ego that keeps its speed:
//!
//! ```
//! use openscenario::{Assignment, Choices, Disk, World, read};
//! use std::path::Path;
//!
//! let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/openscenario");
//! let gap = Assignment { name: "Gap_m".to_owned(), value: "40".to_owned() };
//! let choices = Choices { assigned: vec![gap], ..Choices::default() };
//! let scenario = read::scenario(&examples.join("cut_in.xosc"), &Disk, &choices)?;
//! let mut world = World::new(scenario.script)?;
//! let (ego, cutter) = (world.script().ego, world.script().entity("Cutter").expect("a car"));
//! let mut motion = world.motion(ego);
//! for step in 0..2000 {
//!     world.observe(ego, motion);
//!     world.step(step * 10_000_000);
//!     motion.s_m += 0.01 * motion.speed_mps;
//! }
//! assert!((world.motion(cutter).t_m - motion.t_m).abs() < 1e-9, "they are in one lane");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN fails a check that is written so")]

mod declare;
mod error;
pub mod expression;
mod library;
pub mod model;
mod parameter;
pub mod read;
pub mod reference;
pub mod road;
mod scene;
mod scope;
mod subset;
pub mod variation;
mod words;
pub mod world;
pub mod xml;

pub use error::{Place, ReadError, Spot};
pub use expression::Value;
pub use library::{Disk, Source};
pub use model::Script;
pub use parameter::Assignment;
pub use read::Choices;
pub use scene::LaneHeadings;
pub use words::{Rule, instant_s};
pub use world::{Motion, World, WorldError};
