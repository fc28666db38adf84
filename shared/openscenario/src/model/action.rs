//! Actions of entities and of the world.

use serde::{Deserialize, Serialize};

use super::position::Position;
use super::timed::{Bounds, Meeting, SignalCycle, SpeedProfile, SpeedTarget};
use crate::expression::Value;
use crate::words::word_enums;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// The speed follows a shape to its target.
    Speed {
        target: SpeedTarget,
        transition: Transition,
    },
    /// A distance to another entity is reached, and kept if continuous.
    Distance(Distance),
    /// The lateral position follows a shape to another lane.
    LaneChange {
        target: LaneTarget,
        /// Offset from its centre, m; positive to the left of the reference line.
        offset_m: f64,
        transition: Transition,
    },
    /// The lateral position follows a shape to an offset.
    LaneOffset {
        target: OffsetTarget,
        shape: Shape,
        /// Largest lateral acceleration on the way, m/s². Without it the entity is there at once.
        max_lateral_mps2: Option<f64>,
        /// Does not end by itself.
        continuous: bool,
    },
    Trajectory(Trajectory),
    Teleport(Position),
    /// From now on the entity drives along the row of roads of the first position.
    Route(Vec<Position>),
    Add {
        entity: usize,
        position: Position,
    },
    Delete {
        entity: usize,
    },
    Set {
        /// Its place among the script's values.
        value: usize,
        change: Change,
    },
    /// An action without effect in the simulation; it is complete at once.
    Nothing,
    Profile(SpeedProfile),
    Meet(Box<Meeting>),
    /// Traffic signals go through a cycle from now on.
    Cycle(SignalCycle),
    /// The cycle of a controller goes on from the beginning of a phase.
    Phase {
        /// The place of the present phase's name among the script's values.
        controller: usize,
        phase: usize,
    },
}

impl Action {
    /// The entity whose motion it depends on while it goes on.
    pub fn follows(&self) -> Option<usize> {
        match self {
            Self::Profile(profile) => profile.relative_to,
            Self::Meet(meeting) => Some(meeting.master),
            _ => None,
        }
    }
}

impl SpeedTarget {
    /// The entity whose speed it is seen from.
    pub fn entity(&self) -> Option<usize> {
        match self {
            Self::Absolute(_) => None,
            Self::Relative { entity, .. } => Some(*entity),
        }
    }

    /// True if Init sets it before the first step.
    pub(crate) fn is_at_once(&self, transition: &Transition) -> bool {
        !self.is_continuous() && transition.is_immediate()
    }

    pub fn is_continuous(&self) -> bool {
        matches!(self, Self::Relative { continuous: true, .. })
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transition {
    pub shape: Shape,
    pub dimension: Dimension,
    /// Time in s, largest rate in the target's unit per second, or distance in m.
    pub value: f64,
}

impl Transition {
    pub fn is_immediate(&self) -> bool {
        self.shape == Shape::Step || (self.dimension != Dimension::Rate && self.value == 0.0)
    }
}

word_enums! {
    /// The shape of a transition from 0 to 1.
    Shape {
        /// x
        Linear: "linear",
        /// 3 x² - 2 x³
        Cubic: "cubic",
        /// (1 - cos pi x) / 2
        Sinusoidal: "sinusoidal",
        /// 1 from the start on.
        Step: "step",
    }

    Dimension {
        /// The time that it takes, s.
        Time: "time",
        /// The largest rate on the way, per s.
        Rate: "rate",
        /// The distance that the entity covers meanwhile, m.
        Distance: "distance",
    }

    /// A side of another entity.
    Side {
        /// The side on which the entity is now.
        Any: "any",
        Behind: "trailingReferencedEntity",
        Ahead: "leadingReferencedEntity",
    }

    /// A side of another entity, as that one faces.
    LateralSide {
        /// The side on which the entity is now.
        Any: "any",
        Left: "leftToReferencedEntity",
        Right: "rightToReferencedEntity",
    }
}

/// A distance beside another entity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aside {
    pub entity: usize,
    /// Without one the distance at the start is kept, m.
    pub distance_m: Option<f64>,
    /// True if it counts between the bodies, not the origins.
    pub freespace: bool,
    pub side: LateralSide,
    /// Largest speed across the road on the way there, m/s; infinite if there is none.
    pub most_mps: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    pub entity: usize,
    pub gap: Gap,
    /// True if it counts between the bodies, not the origins.
    pub freespace: bool,
    pub side: Side,
    /// Does not end by itself.
    pub continuous: bool,
    /// Bounds on the way, with finite accelerations. Without them the entity is there at once.
    pub limits: Option<Bounds>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gap {
    /// A length, m.
    Distance(f64),
    /// A time, s, at the speed of the one behind.
    Time(f64),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LaneTarget {
    Lane(i32),
    /// A lane to the left of an entity's lane.
    Beside {
        entity: usize,
        lanes_left: i32,
    },
    /// A lateral position, m, for roads without lanes.
    Lateral(f64),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OffsetTarget {
    /// Offset from the centre of the present lane, m.
    Lane(f64),
    /// Offset from another entity's lateral position, m.
    Entity {
        entity: usize,
        /// Offset from its lateral position, m.
        offset_m: f64,
    },
    Aside(Aside),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    pub vertices: Vec<Vertex>,
    /// Times at which the corners are passed. Without them the entity keeps its speed.
    pub timing: Option<Timing>,
    /// Distance along the line at which the entity begins, m.
    pub initial_offset_m: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vertex {
    pub time_s: f64,
    pub position: Position,
}

/// The clock of a trajectory: `scale * time + offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// True if it counts from the start of the run, not of the action.
    pub absolute: bool,
    pub scale: f64,
    pub offset_s: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    To(Value),
    Add(f64),
    Multiply(f64),
}
