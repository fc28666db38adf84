//! Positions on the road.

use serde::{Deserialize, Serialize};

/// A position in the road's coordinates, by itself or seen from an entity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// The point.
    pub from: From,
    /// The heading.
    #[serde(default)]
    pub heading: Heading,
}

/// A point, in the frame that it is given in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum From {
    /// A point of the road.
    Road {
        /// Along the reference line, m.
        s_m: f64,
        /// Across it, positive to the left, m.
        t_m: f64,
    },
    /// Along and across the road from an entity.
    EntityOnRoad {
        /// The entity.
        entity: usize,
        /// Along the reference line, m.
        ds_m: f64,
        /// Across it, m.
        dt_m: f64,
    },
    /// From an entity, in the plane whose x axis is the direction of the reference line at its start.
    EntityInPlane {
        /// The entity.
        entity: usize,
        /// Along x, m.
        dx_m: f64,
        /// Along y, m.
        dy_m: f64,
    },
    /// In an entity's own axes.
    Entity {
        /// The entity.
        entity: usize,
        /// Ahead of it, m.
        ahead_m: f64,
        /// To its left, m.
        left_m: f64,
    },
    /// On a lane beside an entity's lane.
    EntityLane {
        /// The entity.
        entity: usize,
        /// Number of lanes to its left.
        lanes_left: i32,
        /// Along the road in its direction, m.
        ds_m: f64,
        /// Offset from the lane's centre, positive to the left of the reference line, m.
        offset_m: f64,
    },
}

/// A heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Heading {
    /// Angle from the direction of the reference line, rad.
    Road(f64),
    /// Angle from the direction of the reference line at its start, rad.
    Plane(f64),
    /// Angle from the other entity's heading, rad.
    Entity(f64),
}

impl Default for Heading {
    fn default() -> Self {
        Self::Road(0.0)
    }
}
