//! The roads that come with the program.

use serde::{Deserialize, Serialize};

use crate::schema::Schema;

/// Sixty kilometres of synthetic hilly motorway, closed in height: `distance_m,height_m`.
pub const HILLS_60KM: &str = include_str!("../../roads/hills-60km.csv");

/// A road compiled into the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum BuiltinRoad {
    /// [`HILLS_60KM`].
    #[serde(rename = "hills-60km")]
    Hills60km,
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
