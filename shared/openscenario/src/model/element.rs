//! The parts of a storyboard and their states.

use crate::words::word_enums;

word_enums! {
    /// The parts of a storyboard.
    ElementKind {
        Story: "story",
        Act: "act",
        ManeuverGroup: "maneuverGroup",
        Maneuver: "maneuver",
        Event: "event",
        Action: "action",
    }

    /// A state, or a transition between states, which lasts one step.
    ElementState {
        Standby: "standbyState",
        Running: "runningState",
        Complete: "completeState",
        StartTransition: "startTransition",
        EndTransition: "endTransition",
        StopTransition: "stopTransition",
        /// Was triggered and did not run.
        SkipTransition: "skipTransition",
    }
}
