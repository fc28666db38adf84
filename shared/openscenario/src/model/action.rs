//! What entities do.

use serde::{Deserialize, Serialize};

use super::position::Position;
use crate::expression::Value;

/// An action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Action {
    /// The speed follows a shape to its target.
    Speed {
        /// The target.
        target: SpeedTarget,
        /// How it is reached.
        transition: Transition,
    },
    /// A distance to another entity is reached, and kept if continuous.
    Distance(Distance),
    /// The lateral position follows a shape to another lane.
    LaneChange {
        /// The lane.
        target: LaneTarget,
        /// From its centre, m.
        offset_m: f64,
        /// How it is reached.
        transition: Transition,
    },
    /// The lateral position follows a shape to an offset.
    LaneOffset {
        /// The offset.
        target: OffsetTarget,
        /// The shape.
        shape: Shape,
        /// The largest lateral acceleration on the way, m/s²; absent: at once.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max_lateral_mps2: Option<f64>,
        /// Does not end by itself.
        continuous: bool,
    },
    /// The entity moves along a line.
    Trajectory(Trajectory),
    /// The entity is somewhere at once.
    Teleport(Position),
    /// The entity comes onto the road.
    Add {
        /// Which.
        entity: usize,
        /// Where.
        position: Position,
    },
    /// The entity leaves the road.
    Delete {
        /// Which.
        entity: usize,
    },
    /// A parameter or variable changes.
    Set {
        /// Which, among the script's values.
        value: usize,
        /// How.
        change: Change,
    },
    /// Nothing that the simulation would show: complete at once.
    Nothing,
}

/// A target speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum SpeedTarget {
    /// A speed, m/s.
    Absolute(f64),
    /// Another entity's speed plus this, m/s.
    Delta {
        /// The other.
        entity: usize,
        /// The difference, m/s.
        mps: f64,
        /// Kept up without end.
        continuous: bool,
    },
    /// Another entity's speed times this.
    Factor {
        /// The other.
        entity: usize,
        /// The factor.
        factor: f64,
        /// Kept up without end.
        continuous: bool,
    },
}

/// How a target is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Transition {
    /// The shape.
    pub shape: Shape,
    /// What its value is.
    pub dimension: Dimension,
    /// Time in s, largest rate in the target's unit per second, or distance in m.
    pub value: f64,
}

/// The shape of a transition from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// x
    Linear,
    /// 3 x² - 2 x³
    Cubic,
    /// (1 - cos pi x) / 2
    Sinusoidal,
    /// 1 from the start.
    Step,
}

/// What the value of a transition is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dimension {
    /// The time that it takes, s.
    Time,
    /// The largest rate on the way, per s.
    Rate,
    /// The distance that the entity covers meanwhile, m.
    Distance,
}

/// A distance to another entity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Distance {
    /// The other.
    pub entity: usize,
    /// How far.
    pub gap: Gap,
    /// Between the bodies rather than the origins.
    pub freespace: bool,
    /// On which side of the other.
    pub side: Side,
    /// Does not end by itself.
    pub continuous: bool,
    /// How the entity may drive to get there; absent: it is there at once.
    #[serde(default)]
    pub limits: Option<Limits>,
}

/// How far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Gap {
    /// m.
    Distance(f64),
    /// s, at the speed of the one behind.
    Time(f64),
}

/// On which side of another entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// On the side where it is now.
    Any,
    /// Behind it.
    Behind,
    /// Ahead of it.
    Ahead,
}

/// Bounds on driving.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// m/s².
    pub max_acceleration_mps2: f64,
    /// m/s², positive.
    pub max_deceleration_mps2: f64,
    /// m/s.
    pub max_speed_mps: f64,
}

/// Where a lane change ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum LaneTarget {
    /// A lane's id.
    Lane(i32),
    /// Lanes to the left of an entity's.
    Beside {
        /// The entity.
        entity: usize,
        /// Lanes to its left.
        lanes_left: i32,
    },
    /// A lateral position, m: for roads without lanes.
    Lateral(f64),
}

/// Where a lane offset ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum OffsetTarget {
    /// From the centre of the present lane, m.
    Lane(f64),
    /// From another entity's lateral position, m.
    Entity {
        /// The other.
        entity: usize,
        /// m.
        offset_m: f64,
    },
}

/// A line to move along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trajectory {
    /// Its corners.
    pub vertices: Vec<Vertex>,
    /// When they are passed; absent: the entity keeps its speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<Timing>,
    /// Where on the line it begins, m.
    #[serde(default)]
    pub initial_offset_m: f64,
}

/// A corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vertex {
    /// When, s.
    #[serde(default)]
    pub time_s: f64,
    /// Where.
    pub position: Position,
}

/// The clock of a trajectory: `scale * time + offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Counts from the start of the run rather than of the action.
    pub absolute: bool,
    /// Factor.
    pub scale: f64,
    /// s.
    pub offset_s: f64,
}

/// How a value changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Change {
    /// The new value.
    To(Value),
    /// Added.
    Add(f64),
    /// Multiplied.
    Multiply(f64),
}
