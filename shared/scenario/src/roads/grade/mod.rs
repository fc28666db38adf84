//! The road that the ego drives on: how high it is, and how steep it is.
//!
//! Plain data that every simulator of the environment agrees on: the plant feels the grade, the
//! roadside unit announces it. A law gets it through `v2x/preview` alone.

mod builtin;
mod generator;
mod profile;

pub use builtin::{BuiltinRoad, HILLS_60KM};
pub use generator::{Alignment, generate};
pub use profile::{GradeProfile, MAX_GRADE, MAX_POINTS, MAX_SPACING_M, Point, ProfileError};
