//! `[supervision]`: restarts and standbys of services that die or hang, in realtime.
//!
//! In simulated time a restart could not repeat exactly: there the end of a service ends the run.

use std::collections::BTreeSet;

use messages::Service;
use scenario_derive::tables;

use super::PerService;
use crate::quantity::{Count, DelayMs, Duration};

tables! {
    /// Restart policy and heartbeats.
    pub struct Supervision {
        /// Condition for a service to be started again.
        pub restart: Restart = OnFailure,
        /// Policies of single services, in place of `restart`.
        pub services: PerService<Option<Restart>> = default,
        /// Restarts of one service allowed in `window_s`; the next death leads to the safe state.
        pub budget: Count = 5,
        /// Window of the budget, s.
        pub window_s: Duration = 10.0,
        /// Wait before the second restart in a row, ms, doubled for each further one; the first restart
        /// does not wait. In a row are restarts within `window_s`.
        pub backoff_ms: DelayMs = 10,
        /// Longest wait before a restart, ms.
        pub max_backoff_ms: DelayMs = 1000,
        /// Time without a sign of life, beyond its own period, after which a service is killed and replaced, ms.
        pub heartbeat_timeout_ms: DelayMs = 250,
        /// Without a standby, the service's next process is started ahead. It has read the scenario and waits to open
        /// its ports. In realtime only.
        pub prepared: bool = true,
        /// Services with a standby. It is a second process that computes and sends nothing. It takes the service over
        /// when the active one ends or hangs. In realtime only.
        pub standby: BTreeSet<Service> = default,
        /// Time without a completed cycle, beyond its own period, after which a standby takes over, ms.
        pub standby_timeout_ms: DelayMs = 50,
    }

    /// Condition for a service to be started again.
    pub enum Restart {
        /// Never: its end ends the run.
        Never,
        /// After it died, hung or failed.
        OnFailure,
        /// Whenever it ends before the run does.
        Always,
    }
}

impl Supervision {
    /// Condition for `service` to be started again.
    pub fn restart_of(&self, service: Service) -> Restart {
        let own = *self.services.of(service);
        own.unwrap_or(self.restart)
    }

    /// Wait before a start that follows `row` others within the window.
    pub fn backoff(&self, row: usize) -> std::time::Duration {
        let doublings = u32::try_from(row).unwrap_or(u32::MAX).saturating_sub(1).min(30);
        let wait_ms = u64::from(self.backoff_ms.value()).saturating_mul(1 << doublings);
        let wait_ms = if row == 0 { 0 } else { wait_ms.min(self.max_backoff_ms.value().into()) };
        std::time::Duration::from_millis(wait_ms)
    }
}
