//! `[runtime]`: where and how the services run.

use serde::{Deserialize, Serialize};

use super::quantity::{Core, DelayMs, Priority, Probability};

/// Scheduling and placement. What the machine does not grant is reported, not fatal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Runtime {
    /// Time from the last service's readiness to the common start instant, ms.
    pub start_delay_ms: DelayMs,
    /// Scheduling policy of the services.
    pub scheduling: Scheduling,
    /// Locks all memory of the services.
    pub lock_memory: bool,
    /// Delay added between a command's computation and its actuation, ms.
    pub extra_delay_ms: DelayMs,
    /// Longest time added to that, drawn for each command from the plant's whole periods, ms.
    pub extra_jitter_ms: DelayMs,
    /// Probability that a control cycle misses: its command never reaches the actuators.
    pub miss_probability: Probability,
    /// Placement of each service.
    pub services: Services,
}

impl Default for Runtime {
    fn default() -> Self {
        Self {
            start_delay_ms: DelayMs::of(20),
            scheduling: Scheduling::Fifo,
            lock_memory: true,
            extra_delay_ms: DelayMs::of(0),
            extra_jitter_ms: DelayMs::of(0),
            miss_probability: Probability::of(0.0),
            services: Services::default(),
        }
    }
}

/// Scheduling policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheduling {
    /// SCHED_FIFO where granted.
    Fifo,
    /// The time-sharing default of the system.
    Other,
}

/// Placement of each service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename_all = "kebab-case")]
pub struct Services {
    /// The ego vehicle.
    pub plant: Placement,
    /// Traffic and radar.
    pub perception_sim: Placement,
    /// The control loop.
    pub controller: Placement,
    /// The roadside unit.
    pub v2x_sim: Placement,
}

/// Where one service runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Placement {
    /// CPU to be pinned to; absent: the controller on the last CPU, the others on the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub core: Option<Core>,
    /// Priority under SCHED_FIFO; absent: by rate, the shortest period highest, and among equal
    /// rates by the order of the chain (82 plant, 81 perception, 80 controller, 79 V2X).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub priority: Option<Priority>,
}

impl Services {
    /// Priority of the plant under SCHED_FIFO.
    #[must_use]
    pub fn plant_priority(&self) -> u8 {
        self.plant.priority.unwrap_or(Priority::of(82)).value()
    }

    /// Priority of perception under SCHED_FIFO.
    #[must_use]
    pub fn perception_sim_priority(&self) -> u8 {
        self.perception_sim.priority.unwrap_or(Priority::of(81)).value()
    }

    /// Priority of the controller under SCHED_FIFO.
    #[must_use]
    pub fn controller_priority(&self) -> u8 {
        self.controller.priority.unwrap_or(Priority::of(80)).value()
    }

    /// Priority of the roadside unit under SCHED_FIFO.
    #[must_use]
    pub fn v2x_sim_priority(&self) -> u8 {
        self.v2x_sim.priority.unwrap_or(Priority::of(79)).value()
    }
}
