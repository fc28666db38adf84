//! Heights of a road and its grades, over the distance along it.
//!
//! Plain data that every simulator of the environment agrees on: the plant feels the grade, the roadside unit announces
//! it.
//!
//! ```
//! use road::grade::{GradeProfile, Point};
//! let points = [(0.0, 0.0), (100.0, 3.0)].map(|(distance_m, height_m)| Point { distance_m, height_m });
//! let hill = GradeProfile::new(points.to_vec())?;
//! assert_eq!((hill.grade(50.0), hill.height_m(50.0), hill.grade(150.0)), (0.03, 1.5, 0.0));
//! # Ok::<(), road::grade::ProfileError>(())
//! ```

mod generator;
mod profile;

pub use generator::{Alignment, generate};
pub use profile::{GradeProfile, MAX_GRADE, MAX_POINTS, MAX_SPACING_M, Point, ProfileError};
