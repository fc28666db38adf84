//! Cycles of traffic signals.

use serde::{Deserialize, Serialize};

/// The cycle of a controller of traffic signals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalCycle {
    /// The place of the present phase's name among the script's values.
    pub controller: usize,
    /// The first phase begins then, ns since the start of the run.
    pub begins_ns: i64,
    /// Its phases, one after the other without end.
    pub phases: Vec<SignalPhase>,
}

/// A phase of traffic signals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalPhase {
    pub name: String,
    pub duration_ns: u64,
    /// States of signals: the place of the signal among the script's values, and its state.
    pub states: Vec<(usize, String)>,
}

impl SignalCycle {
    /// The duration of all phases, ns.
    #[must_use]
    pub fn duration_ns(&self) -> u64 {
        self.until(self.phases.len())
    }

    /// The phase at a time after the first phase's beginning.
    #[must_use]
    pub fn phase_at(&self, since_ns: u64) -> Option<usize> {
        let mut rest_ns = since_ns.checked_rem(self.duration_ns())?;
        self.phases.iter().position(|phase| {
            let is_now = rest_ns < phase.duration_ns;
            rest_ns = rest_ns.saturating_sub(phase.duration_ns);
            is_now
        })
    }

    /// The time from the beginning of the first phase to that of another one, ns.
    #[must_use]
    pub fn until(&self, phase: usize) -> u64 {
        let before = self.phases.iter().take(phase);
        before.fold(0, |sum, phase| sum.saturating_add(phase.duration_ns))
    }
}
