//! The heights of roads, and the road that comes with the program. A law gets them through `v2x/preview` alone.

pub use ::road::grade::{
    Alignment, GradeProfile, MAX_GRADE, MAX_POINTS, MAX_SPACING_M, Point, ProfileError, generate,
};

use scenario_derive::tables;

/// Sixty kilometres of synthetic hilly motorway, closed in height: `distance_m,height_m`.
pub const HILLS_60KM: &str = include_str!("../../roads/hills-60km.csv");

tables! {
    /// A road compiled into the program.
    pub enum BuiltinRoad {
        /// [`HILLS_60KM`].
        #[serde(rename = "hills-60km")]
        Hills60km,
    }
}

impl BuiltinRoad {
    /// The road as a CSV text.
    #[must_use]
    pub const fn csv(self) -> &'static str {
        match self {
            Self::Hills60km => HILLS_60KM,
        }
    }
}
