//! Positions on the road.

use serde::{Deserialize, Serialize};

/// A position in the road's coordinates, by itself or seen from an entity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Position {
    pub from: From,
    pub heading: Heading,
}

/// A point, in the frame that it is given in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum From {
    Road {
        /// Its place among the script's roads.
        #[serde(default)]
        row: usize,
        /// Along the reference line, m.
        s_m: f64,
        /// Across it, positive to the left, m.
        t_m: f64,
    },
    Entity {
        entity: usize,
        offset: Offset,
    },
}

/// A place seen from an entity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Offset {
    /// Along and across the reference line, m.
    Road { ds_m: f64, dt_m: f64 },
    /// In the plane whose x axis is the direction of the reference line at its start, m.
    Plane { dx_m: f64, dy_m: f64 },
    /// In the entity's own axes, m.
    Own { ahead_m: f64, left_m: f64 },
    /// On a lane beside the entity's lane.
    Lane {
        lanes_left: i32,
        /// Along the road in its direction, m.
        ds_m: f64,
        /// Offset from the lane's centre, positive to the left of the reference line, m.
        offset_m: f64,
    },
}

impl Position {
    /// The entity that it is seen from.
    pub fn entity(&self) -> Option<usize> {
        match self.from {
            From::Road { .. } => None,
            From::Entity { entity, .. } => Some(entity),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Heading {
    /// Angle from the direction of the reference line, rad.
    Road(f64),
    /// Angle from the direction of the reference line at its start, rad.
    Plane(f64),
    /// Angle from the other entity's heading, rad.
    Entity(f64),
}
