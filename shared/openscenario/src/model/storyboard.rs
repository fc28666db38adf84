//! Stories, acts, maneuver groups, maneuvers, events.

use serde::{Deserialize, Serialize};

use super::action::Action;
use super::condition::Trigger;
use crate::words::word_enums;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Story {
    pub name: String,
    pub acts: Vec<Act>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Act {
    pub name: String,
    /// The trigger that starts it. Without one it starts with its story.
    pub start: Option<Trigger>,
    /// The trigger that stops it before its end.
    pub stop: Option<Trigger>,
    pub groups: Vec<ManeuverGroup>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ManeuverGroup {
    pub name: String,
    pub executions: u32,
    pub actors: Vec<usize>,
    pub maneuvers: Vec<Maneuver>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Maneuver {
    pub name: String,
    pub events: Vec<Event>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    pub name: String,
    /// Its effect on other events of the maneuver.
    pub priority: Priority,
    pub executions: u32,
    /// The trigger that starts it. Without one it starts with its maneuver.
    pub start: Option<Trigger>,
    pub actions: Vec<NamedAction>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedAction {
    pub name: String,
    pub action: Action,
}

word_enums! {
    /// The effect of a starting event on running events of its maneuver.
    #[derive(Default)]
    Priority {
        /// Ends them.
        Override: "overwrite" | "override",
        /// Does not start while one runs.
        Skip: "skip",
        /// Runs beside them.
        #[default]
        Parallel: "parallel",
    }
}
