//! The parts of one reaction time, from the stamps of the command that ends it.

use messages::Command;
use runtime::chain::part;

/// Instant and lateness of the plant's act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Actuated {
    /// Scheduled release of the plant's cycle, ns of run time.
    pub(crate) scheduled_ns: i64,
    pub(crate) start_ns: i64,
    pub(crate) now_ns: i64,
}

pub(crate) const PARTS: usize = 7;

/// The parts of one reaction time, ns, in the order of [`crate::report::Parts`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Chain(pub(crate) [i64; PARTS]);

impl Chain {
    /// The parts of the chain that ends with `command` at `actuated`.
    pub(crate) fn of(command: &Command, actuated: &Actuated) -> Self {
        let radar = command.header.origins.radar;
        let ends = [
            // The sample is published.
            radar.publish_ns,
            // The controller waits with the sample there: before, it is busy or not yet due.
            command.idle_ns.max(command.header.acquisition_ns),
            // The controller comes out of its wait.
            command.start_ns,
            // The command is published.
            command.header.publish_ns,
            // The plant's release is due; the plant comes out of its wait, and works until the actuation.
            actuated.scheduled_ns,
            actuated.start_ns,
            actuated.now_ns,
        ];
        let mut reached = radar.acquisition_ns;
        Self(ends.map(|stamp_ns| part(&mut reached, stamp_ns)))
    }

    pub(crate) fn sum_ns(&self) -> i64 {
        self.0.iter().sum()
    }

    /// The waits among them that are designed, ns.
    pub(crate) fn designed_wait_ns(&self, command: &Command) -> i64 {
        let [radar_publish_ns, controller_queue_ns, _, _, command_wait_ns, ..] = self.0;
        let radar = command.header.origins.radar;
        let latency = (command.radar_release_ns - radar.acquisition_ns).max(0);
        let timer = (command.header.acquisition_ns - radar.publish_ns).max(0);
        latency.min(radar_publish_ns) + timer.min(controller_queue_ns) + command_wait_ns
    }
}
