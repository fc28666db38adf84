//! A road's plan from an OpenDRIVE file.

use std::path::{Path, PathBuf};

use openscenario::road::{Driven, DrivenLane, driven_lane};
use scenario_derive::tables;

use super::{Lanes, Start};
use crate::Problem;
use crate::quantity::{Coordinate, Distance, HeadingDeg, LaneCount, LaneId, Length};

tables! {
    /// A lane of a road of an OpenDRIVE file, with the roads that follow it by their links.
    pub struct OpendriveRoad {
        /// The file; a relative path starts at the scenario file's directory.
        pub file: PathBuf,
        /// Id of the road on which the ego begins.
        pub road: String,
        /// Id of the ego's lane; negative on the right of the reference line.
        pub lane: LaneId,
        /// Place of the ego's front bumper at the start along the road, m.
        pub s_m: Distance = 0.0,
        /// Content of the file when the scenario was opened: the line that the ego drives along.
        pub line: Option<Driven>,
        /// The storyboard's road: a translation sets it.
        pub of_storyboard: bool = sparse,
    }
}

impl OpendriveRoad {
    pub(crate) fn read(&self, path: &Path, text: &str) -> Result<DrivenLane, Problem> {
        let place = self.s_m.value();
        driven_lane(path, text, &self.road, self.lane.value(), place).map_err(|error| {
            let expected = "an OpenDRIVE file with a lane that can be driven";
            Problem::new("road.plan.opendrive", error.to_string(), expected)
        })
    }

    /// The middle of the ego's lane.
    pub(super) fn axis(&self) -> Result<road::Axis, Problem> {
        const PATH: &str = "road.plan.opendrive";
        let line = self.line.as_ref().ok_or_else(|| Problem::unread(PATH, "a scenario file"))?;
        line.axis().map(|(axis, _)| axis).map_err(|error| Problem::of_axis(PATH, &error))
    }
}

impl Start {
    /// A place of the plane, or the origin for one beyond the range of coordinates.
    pub fn of_pose(pose: &road::Pose) -> Self {
        let degrees = libm::remainder(pose.heading_rad, std::f64::consts::TAU).to_degrees();
        let read = || -> Option<Self> {
            Some(Self {
                x_m: Coordinate::try_from(pose.x_m).ok()?,
                y_m: Coordinate::try_from(pose.y_m).ok()?,
                heading_deg: HeadingDeg::try_from(degrees).ok()?,
            })
        };
        read().unwrap_or_default()
    }
}

impl Lanes {
    /// The lanes beside the ego's, all as wide as that, if their numbers are in range.
    pub fn beside([left, right]: [usize; 2], width_m: f64) -> Self {
        let count =
            |count: usize| i64::try_from(count).ok().and_then(|n| LaneCount::try_from(n).ok());
        let usual = Self::default();
        Self {
            left: count(left).unwrap_or(usual.left),
            right: count(right).unwrap_or(usual.right),
            width_m: Length::try_from(width_m).unwrap_or(usual.width_m),
            along: usual.along,
        }
    }
}
