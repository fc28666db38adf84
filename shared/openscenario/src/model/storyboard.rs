//! Stories, acts, maneuver groups, maneuvers, events.

use serde::{Deserialize, Serialize};

use super::action::Action;
use super::condition::Trigger;

/// A story.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Story {
    /// Its name.
    pub name: String,
    /// Its acts.
    pub acts: Vec<Act>,
}

/// An act.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Act {
    /// Its name.
    pub name: String,
    /// What starts it; absent: its story.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Trigger>,
    /// What stops it before its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<Trigger>,
    /// Its groups.
    pub groups: Vec<ManeuverGroup>,
}

/// Maneuvers with their actors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManeuverGroup {
    /// Its name.
    pub name: String,
    /// How often it runs.
    pub executions: u32,
    /// Who does what is to be done.
    pub actors: Vec<usize>,
    /// Its maneuvers.
    pub maneuvers: Vec<Maneuver>,
}

/// Events that belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Maneuver {
    /// Its name.
    pub name: String,
    /// Its events.
    pub events: Vec<Event>,
}

/// Actions with what starts them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// Its name.
    pub name: String,
    /// What happens to other events of the maneuver.
    pub priority: Priority,
    /// How often it starts.
    pub executions: u32,
    /// What starts it; absent: its maneuver.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<Trigger>,
    /// What it does.
    pub actions: Vec<NamedAction>,
}

/// An action with its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedAction {
    /// Its name.
    pub name: String,
    /// What is done.
    pub action: Action,
}

/// What a starting event does to running ones of its maneuver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Priority {
    /// Ends them.
    Override,
    /// Does not start while one runs.
    Skip,
    /// Runs beside them.
    Parallel,
}
