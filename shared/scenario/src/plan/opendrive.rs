//! A road's plan from an OpenDRIVE file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::problem::Problem;
use crate::quantity::{Distance, LaneId};
use crate::schema::Schema;

/// A lane of a road of an OpenDRIVE file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct OpendriveRoad {
    /// The file; a relative path starts at the scenario file's directory.
    pub file: PathBuf,
    /// Id of the road on which the ego begins.
    pub road: String,
    /// Id of the ego's lane; negative on the right of the reference line.
    pub lane: LaneId,
    /// Place of the ego's front bumper at the start along the road, m.
    #[serde(default = "beginning")]
    pub s_m: Distance,
}

impl OpendriveRoad {
    /// The lane's middle as pieces.
    pub(super) fn geometry(&self) -> Result<Vec<road::Piece>, Problem> {
        Err(Problem::new(
            "road.plan.opendrive",
            "OpenDRIVE files are not read as plans yet",
            "road.plan.pieces or road.plan.generated",
        ))
    }
}

fn beginning() -> Distance {
    Distance::of(0.0)
}
