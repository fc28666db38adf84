//! `[runtime]`: where and how the services run.
//!
//! **Priorities** under `SCHED_FIFO` go by rate, the shortest period highest. Among equal rates they go by the order of
//! the chain, so that a sender finishes before its receiver begins. That is 82 plant, 81 perception, 80 emergency
//! brake, V2X and on-board unit, 79 controller.
//!
//! **Cores.** All services share one core unless the scenario says otherwise. It is the last one that the process may
//! use. That leaves the first, where most machines take their interrupts, to all other processes. The services of a
//! chain work one after the other, so a second core gives them no more time. Handing over to a sleeping core costs an
//! interrupt between processors and a core's way out of idleness. Handing over on the same core costs a context switch.
//! Reaction time without its designed waits, p50 over three interleaved runs each. The machine had two cores of an EPYC
//! under KVM, busy with other work; `timegap bench` shows the same on any machine:
//!
//! | periods (plant, radar, controller) | n of a run | all on last | all on first | controller on last, others on first |
//! | --- | --- | --- | --- | --- |
//! | 10, 50, 100 ms | 40 | 215 to 228 µs | 234 to 247 µs | 239 to 250 µs |
//! | 1, 10, 10 ms | 400 | 142 to 174 µs | 159 to 183 µs | 180 to 206 µs |
//!
//! A law that computes for a large part of its period is interrupted by plant and radar there. A core of its own may
//! serve it better (`runtime.services.controller.core = 0`).

use messages::Service;
use scenario_derive::tables;

use super::PerService;
use crate::quantity::{Core, DelayMs, Priority, Probability};

tables! {
    /// Scheduling and placement. A right that the machine does not grant is reported, not fatal.
    pub struct Runtime {
        /// Time from the last service's readiness to the common start instant, ms.
        pub start_delay_ms: DelayMs = 20,
        /// Scheduling policy of the services.
        pub scheduling: Scheduling = Fifo,
        /// Locks all memory of the services.
        pub lock_memory: bool = true,
        /// Delay added between a command's computation and its actuation, ms. A plant's period that is not
        /// written divides it.
        pub extra_delay_ms: DelayMs = 0,
        /// Longest time added to that, drawn for each command from the plant's whole periods, ms.
        pub extra_jitter_ms: DelayMs = 0,
        /// Probability that a control cycle misses: its command never reaches the actuators.
        pub miss_probability: Probability = 0.0,
        /// Placement of each service.
        pub services: PerService<Placement> = default,
    }

    /// Scheduling policy.
    pub enum Scheduling {
        /// SCHED_FIFO where granted.
        Fifo,
        /// The time-sharing default of the system.
        Other,
    }

    /// Placement of one service.
    #[derive(Copy, Eq)]
    pub struct Placement {
        /// CPU to be pinned to; absent: the last that the process may use.
        pub core: Option<Core>,
        /// Priority under SCHED_FIFO; absent: by rate, then by the order of the chain.
        pub priority: Option<Priority>,
    }
}

impl Runtime {
    /// Priority of `service` under SCHED_FIFO: its own, else by rate, then by the order of the chain.
    pub fn priority(&self, service: Service) -> u8 {
        let own = self.services.of(service).priority;
        own.map_or(service.descriptor().priority, Priority::value)
    }
}
