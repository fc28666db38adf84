//! The motion of an entity.

use serde::{Deserialize, Serialize};

/// Position, heading and speed of an entity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// True if it is on the road. If not, the other fields have no meaning.
    pub present: bool,
    /// Origin along the reference line, m.
    pub s_m: f64,
    /// Origin across it, positive to the left, m.
    pub t_m: f64,
    /// Heading from the reference line, rad.
    pub heading_rad: f64,
    /// Speed along the heading, m/s.
    pub speed_mps: f64,
    /// Speed across the road from a lateral action, m/s.
    pub lateral_mps: f64,
    /// Acceleration along the heading, m/s².
    pub acceleration_mps2: f64,
}

impl Motion {
    /// 1 for an entity that faces along the road, -1 for one that faces against it.
    pub fn direction(&self) -> f64 {
        if libm::cos(self.heading_rad) < 0.0 { -1.0 } else { 1.0 }
    }
}
