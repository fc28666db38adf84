//! Traffic signals that go through their cycles.

use serde::{Deserialize, Serialize};

use crate::Value;
use crate::model::timed::SignalCycle;
use crate::world::World;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Cycle {
    cycle: SignalCycle,
    phase: Option<usize>,
}

impl World {
    pub(super) fn begin_cycle(&mut self, cycle: &SignalCycle) {
        self.state.cycles.push(Cycle { cycle: cycle.clone(), phase: None });
    }

    /// Moves the cycle of a controller to the beginning of a phase.
    pub(super) fn begin_phase(&mut self, controller: usize, phase: usize) {
        let now_ns = self.state.time_ns;
        for Cycle { cycle, phase: present } in &mut self.state.cycles {
            if cycle.controller == controller {
                cycle.begins_ns = signed(now_ns) - signed(cycle.until(phase));
                *present = None;
            }
        }
        self.signals();
    }

    /// Sets the states of the phases that begin.
    pub(super) fn signals(&mut self) {
        let now_ns = self.state.time_ns;
        for Cycle { cycle, phase } in &mut self.state.cycles {
            let since_ns = u64::try_from(signed(now_ns).saturating_sub(cycle.begins_ns));
            let present = since_ns.ok().and_then(|since_ns| cycle.phase_at(since_ns));
            let Some(index) = present.filter(|_| *phase != present) else { continue };
            let begun = &cycle.phases[index];
            self.state.values[cycle.controller] = Value::Text(begun.name.clone());
            for (signal, state) in &begun.states {
                self.state.values[*signal] = Value::Text(state.clone());
            }
            *phase = present;
        }
    }
}

fn signed(time_ns: u64) -> i64 {
    i64::try_from(time_ns).unwrap_or(i64::MAX)
}
