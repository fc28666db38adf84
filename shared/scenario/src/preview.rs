//! `[v2x.preview]`: the map of the road ahead, and what is wrong with it.

use serde::{Deserialize, Serialize};

use super::quantity::{Distance, MapShift, Percent};
use super::schema::Schema;

/// Faults of the map. Without any it is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Preview {
    /// By how much everything on the map is too far ahead, m.
    pub shift_m: MapShift,
    /// Standard deviation of an error of each cell's grade, percentage points; the seed of the run
    /// makes it.
    pub noise_percent: Percent,
    /// End of the map, m; absent: it has no end.
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
