//! `timegap string`: cars in one lane, each with its own stack. A disturbance travels from the first to the last.
//!
//! ```text
//! scenario ─► car 1 ─ true motion ─► car 2 ─ true motion ─► … ─► car N
//!               │                      │                           │
//!               └────── speeds and gap errors, as norms or as a sine's amplitude ──► gains
//! ```
//!
//! The first car drives the scenario as it stands. Each one after it drives the same scenario with one other vehicle:
//! the car before it, in its real motion. A string is stable if no car makes the disturbance larger. This is the sense
//! of Swaroop and Hedrick (1996), in the norms that are printed.

mod arguments;
mod cars;
mod drive;
mod limits;
mod measure;
mod motion;
mod page;
mod results;
mod scene;
#[cfg(test)]
mod theory_tests;
mod wave;

pub use arguments::StringArguments;
pub use cars::CarByCar;
pub use results::schema;

use std::process::ExitCode;

use frame::{Command, Entry};
use supervise::Error;

/// Above this a gain counts as amplification. The margin is for what a measurement over a finite time leaves.
pub const STABLE_GAIN: f64 = 1.005;

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<drive::Strings>();

pub fn run(command: &Command<StringArguments>) -> Result<ExitCode, Error> {
    frame::run::<drive::Strings>(command)
}
