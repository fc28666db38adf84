//! `[v2x.preview]`: the maps of the road ahead, of grades and of curves, and what is wrong with them.

use serde::{Deserialize, Serialize};

use super::quantity::{Distance, MapShift, Percent};
use super::schema::Schema;

/// Faults of the maps. Without any they are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Preview {
    /// Distance by which everything on the maps is too far ahead, m.
    pub shift_m: MapShift,
    /// Standard deviation of an error of each cell, made from the run's seed. A grade's is in percentage points, a
    /// curvature's in percent of it.
    pub noise_percent: Percent,
    /// End of the maps, m; absent: they have no end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ends_at_m: Option<Distance>,
}

impl Preview {
    /// True if the map is exact.
    #[must_use]
    pub fn is_right(&self) -> bool {
        *self == Self::default()
    }
}

impl Default for MapShift {
    fn default() -> Self {
        Self::of(0.0)
    }
}

impl Default for Percent {
    fn default() -> Self {
        Self::of(0.0)
    }
}
