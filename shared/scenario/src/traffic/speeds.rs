//! Tables of speeds over time.

use serde::{Deserialize, Serialize};

use crate::quantity::{Speed, Time};
use crate::schema::Schema;

/// A point of a speed table: `[time_s, speed_mps]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(expecting = "a point [time_s, speed_mps]")]
pub struct SpeedPoint(pub Time, pub Speed);
