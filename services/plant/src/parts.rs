//! The parts of one reaction time, from the stamps of the message that ends it.

use messages::{Brake, Command, Header};

/// Instant and lateness of the plant's act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Actuated {
    /// Scheduled release of the plant's cycle, ns of run time.
    pub scheduled_ns: i64,
    /// Its real start, ns of run time.
    pub start_ns: i64,
    /// The actuation, ns of run time.
    pub now_ns: i64,
}

/// The stamps of a command that a chain is rebuilt from.
#[derive(Clone, Copy, Debug)]
pub struct Stamps {
    /// Header of the command.
    pub header: Header,
    /// Scheduled release of the radar's cycle that published its sample, ns of run time.
    pub radar_release_ns: i64,
    /// Start of its service's wait for the release, ns of run time.
    pub idle_ns: i64,
    /// Time when the cycle began to work on its inputs, ns of run time.
    pub start_ns: i64,
}

impl From<&Command> for Stamps {
    fn from(command: &Command) -> Self {
        let Command { header, radar_release_ns, idle_ns, start_ns, .. } = *command;
        Self { header, radar_release_ns, idle_ns, start_ns }
    }
}

impl From<&Brake> for Stamps {
    fn from(brake: &Brake) -> Self {
        let Brake { header, radar_release_ns, idle_ns, start_ns, .. } = *brake;
        Self { header, radar_release_ns, idle_ns, start_ns }
    }
}

/// The parts of one reaction time, ns, in order of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// Radar acquisition to the sample's publication.
    pub radar_publish_ns: i64,
    /// The sample is there, the controller is busy or not yet due.
    pub controller_queue_ns: i64,
    /// The controller comes out of its wait with the sample.
    pub radar_transport_ns: i64,
    /// Start of the control cycle to the command's publication.
    pub controller_compute_ns: i64,
    /// The command waits for the plant's scheduled release.
    pub command_wait_ns: i64,
    /// The plant comes out of its wait.
    pub command_transport_ns: i64,
    /// The plant works until the actuation.
    pub actuate_ns: i64,
}

impl Parts {
    /// The parts of the chain that ends with `command` at `actuated`.
    #[must_use]
    pub fn of(command: &Stamps, actuated: &Actuated) -> Self {
        let radar = command.header.origins.radar;
        let mut reached = radar.acquisition_ns;
        // Time never goes back: a stage that was over before the last one ended took none.
        let mut until = |stamp_ns: i64| {
            let part = (stamp_ns - reached).max(0);
            reached += part;
            part
        };
        Self {
            radar_publish_ns: until(radar.publish_ns),
            controller_queue_ns: until(command.idle_ns.max(command.header.acquisition_ns)),
            radar_transport_ns: until(command.start_ns),
            controller_compute_ns: until(command.header.publish_ns),
            command_wait_ns: until(actuated.scheduled_ns),
            command_transport_ns: until(actuated.start_ns),
            actuate_ns: until(actuated.now_ns),
        }
    }

    /// Radar acquisition to the start of the control cycle, ns.
    #[must_use]
    pub fn radar_to_controller_ns(&self) -> i64 {
        self.radar_publish_ns + self.controller_queue_ns + self.radar_transport_ns
    }

    /// Publication of the command to the actuation, ns.
    #[must_use]
    pub fn controller_to_plant_ns(&self) -> i64 {
        self.command_wait_ns + self.command_transport_ns + self.actuate_ns
    }

    /// Their sum: the reaction time.
    #[must_use]
    pub fn sum_ns(&self) -> i64 {
        self.radar_to_controller_ns() + self.controller_compute_ns + self.controller_to_plant_ns()
    }

    /// The waits among them that are designed, ns.
    #[must_use]
    pub fn designed_wait_ns(&self, command: &Stamps) -> i64 {
        let radar = command.header.origins.radar;
        let latency = (command.radar_release_ns - radar.acquisition_ns).max(0);
        let timer = (command.header.acquisition_ns - radar.publish_ns).max(0);
        latency.min(self.radar_publish_ns)
            + timer.min(self.controller_queue_ns)
            + self.command_wait_ns
    }
}
