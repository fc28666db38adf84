//! The parts of a storyboard and their states.

use serde::{Deserialize, Serialize};

/// The parts of a storyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElementKind {
    /// A story.
    Story,
    /// An act.
    Act,
    /// A maneuver group.
    ManeuverGroup,
    /// A maneuver.
    Maneuver,
    /// An event.
    Event,
    /// An action.
    Action,
}

/// A state, or a transition between states, which lasts one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElementState {
    /// Waits for its trigger.
    Standby,
    /// Runs.
    Running,
    /// Is over.
    Complete,
    /// Begins to run.
    StartTransition,
    /// Ends by itself.
    EndTransition,
    /// Is ended from outside.
    StopTransition,
    /// Was triggered and did not run.
    SkipTransition,
}
