//! Arrivals of two entities at the same time.

use serde::{Deserialize, Serialize};

use super::action::SpeedTarget;
use super::position::Position;

/// An entity arrives at its goal when another one, the master, arrives at its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Meeting {
    /// The other entity.
    pub master: usize,
    /// The goal of the other entity.
    pub master_goal: Position,
    /// The goal of the entity itself.
    pub goal: Position,
    /// A distance from its goal within which the other entity has arrived, m.
    pub master_tolerance_m: f64,
    /// A distance from its goal within which the entity has arrived, m.
    pub tolerance_m: f64,
    /// The speed of the entity at its goal. Without one it is free.
    pub final_speed: Option<FinalSpeed>,
}

/// The speed at the end of a meeting.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinalSpeed {
    pub speed: SpeedTarget,
    /// The last part of the way, on which the entity has this speed already.
    pub steady: Option<Steady>,
}

/// The length of the last part of a way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Steady {
    /// A distance before the goal, m.
    Distance(f64),
    /// A time before the arrival, s.
    Time(f64),
}
