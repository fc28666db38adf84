//! The road: its lanes and its length, from an OpenDRIVE file.
//!
//! Everything moves in the road's own coordinates: `s` along the reference line, `t` across it, positive
//! to the left. The reader takes one road with one lane section of constant widths. It unrolls a curved
//! reference line: the curvature has no effect, and the reader refuses coordinates of the plane (world positions,
//! absolute headings).

mod opendrive;

use serde::{Deserialize, Serialize};

use crate::error::one_of;
pub use opendrive::read;

/// Width of the lanes of an assumed road, m.
pub const ASSUMED_LANE_WIDTH_M: f64 = 3.5;
/// Lanes on each side of an assumed road.
const ASSUMED_LANES: i32 = 8;

/// A road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Road {
    /// Its id in the file.
    pub id: String,
    /// Its length, m; a road without one has no end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Start and heading of its reference line, if it is straight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub straight: Option<Line>,
    /// Its steepest slope, up or down, as height over distance; it has no effect.
    #[serde(default, skip_serializing_if = "is_level")]
    pub steepest_slope: f64,
    /// Traffic keeps to the left: lanes with positive ids lead along the reference line.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub left_hand: bool,
    /// Its lanes from right to left, without the centre lane.
    pub lanes: Vec<Lane>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the form that serde asks for")]
fn is_level(slope: &f64) -> bool {
    *slope == 0.0
}

/// A straight reference line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Start, m.
    pub x_m: f64,
    /// Start, m.
    pub y_m: f64,
    /// Heading, rad.
    pub heading_rad: f64,
}

impl Line {
    /// A vector of the plane in the road's coordinates, along and across, m.
    pub(crate) fn turned(&self, dx_m: f64, dy_m: f64) -> (f64, f64) {
        let (sin, cos) = (libm::sin(self.heading_rad), libm::cos(self.heading_rad));
        (cos * dx_m + sin * dy_m, cos * dy_m - sin * dx_m)
    }
}

/// A lane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lane {
    /// Id: negative to the right of the reference line.
    pub id: i32,
    /// Centre, m from the reference line, positive to the left.
    pub center_m: f64,
    /// Width, m.
    pub width_m: f64,
}

impl Road {
    /// A straight road without end, with eight lanes of 3.5 m on each side. It stands in for a missing road file.
    ///
    /// ```
    /// let road = openscenario::road::Road::assumed();
    /// assert_eq!(road.lane(-2).map(|lane| lane.center_m), Some(-5.25));
    /// ```
    #[must_use]
    pub fn assumed() -> Self {
        let lane = |id: i32| Lane {
            id,
            center_m: f64::from(id.signum()) * (f64::from(id.abs()) - 0.5) * ASSUMED_LANE_WIDTH_M,
            width_m: ASSUMED_LANE_WIDTH_M,
        };
        let ids = (-ASSUMED_LANES..=ASSUMED_LANES).filter(|id| *id != 0);
        let straight = Line { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
        Self {
            id: "0".to_owned(),
            length_m: None,
            straight: Some(straight),
            steepest_slope: 0.0,
            left_hand: false,
            lanes: ids.map(lane).collect(),
        }
    }

    /// The lane of an id.
    #[must_use]
    pub fn lane(&self, id: i32) -> Option<&Lane> {
        self.lanes.iter().find(|lane| lane.id == id)
    }

    /// The ids of its lanes, for errors.
    pub(crate) fn lane_names(&self) -> String {
        let names: Vec<String> = self.lanes.iter().map(|lane| lane.id.to_string()).collect();
        one_of(names.iter().map(String::as_str))
    }

    /// The direction in which traffic drives on a lane: 1 along the reference line, -1 against it.
    #[must_use]
    pub fn direction(&self, lane: &Lane) -> f64 {
        if (lane.id < 0) == self.left_hand { -1.0 } else { 1.0 }
    }

    /// The place in `lanes` of the lane nearest to a lateral position, m.
    #[must_use]
    pub fn index_at(&self, t_m: f64) -> usize {
        let distance = |lane: &Lane| ((t_m - lane.center_m).abs() - 0.5 * lane.width_m).max(0.0);
        let mut best = 0;
        for (i, lane) in self.lanes.iter().enumerate() {
            if distance(lane) < distance(&self.lanes[best]) {
                best = i;
            }
        }
        best
    }

    /// The lane some lanes to the left (in the direction of `s`) of the one at a lateral position.
    #[must_use]
    pub fn lane_beside(&self, t_m: f64, lanes_left: i32) -> Option<&Lane> {
        let index = i64::try_from(self.index_at(t_m)).ok()? + i64::from(lanes_left);
        self.lanes.get(usize::try_from(index).ok()?)
    }

    /// Whether a lateral position, m, is on one of the lanes.
    #[must_use]
    pub fn holds(&self, t_m: f64) -> bool {
        self.lanes.iter().any(|lane| (t_m - lane.center_m).abs() <= 0.5 * lane.width_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assumed_road_has_lanes_of_both_signs() {
        let road = Road::assumed();
        assert_eq!(road.lane(-4).map(|lane| lane.center_m), Some(-12.25));
        assert_eq!(road.lane(1).map(|lane| lane.center_m), Some(1.75));
        assert_eq!(road.lane_beside(-1.75, 1).map(|lane| lane.id), Some(1));
    }
}
