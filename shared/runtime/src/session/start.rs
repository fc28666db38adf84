//! The begin and the end of a service: from the open ports to the first release, and the report.

use super::Runtime;
use crate::counts::account::OwnAccount;
use crate::machine::scheduling::{Policy, Request, above, apply, in_force};
use crate::report::{Payload, ServiceReport};
use crate::survival::end_word;
use crate::survival::standby::Standby;
use crate::transport::Carrier;
use crate::{FromService, Mode, RuntimeError};
use messages::Topic;
use scenario::Scenario;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Longest time for which a restarted service waits for its inputs' last messages. A dead input does not send any.
const INPUT_PATIENCE: Duration = Duration::from_millis(15);

impl Runtime {
    /// Reports to the launcher that all ports are open, and waits for the common start.
    ///
    /// # Errors
    /// If the link breaks or the run ends before it began.
    pub fn begin(&mut self, scenario: &Scenario) -> Result<(), RuntimeError> {
        self.life.heartbeat = Some(self.publisher()?);
        let waits = self.injection.faults.waits_for_the_drive();
        if waits && !self.ports.has(Topic::EgoTruth) && self.cycles.schedule.is_none() {
            // The service has no other use for the ego's ground truth.
            self.injection.drive = Some(Box::new(self.subscriber()?));
        }
        let (carrier, mode) = (self.carrier(), self.group.mode);
        let granted = match (carrier, mode) {
            // The thread is not this service's alone.
            (Carrier::Memory, _) => in_force(),
            (Carrier::SharedMemory, Mode::Realtime) => apply(&Request::of(scenario, self.service)),
            (Carrier::SharedMemory, Mode::Lockstep) => apply(&Request::NOTHING),
        };
        if granted.granted != Policy::Other.to_string() {
            self.life.link.raise_thread();
        }
        if let (Some(peers), Mode::Realtime) = (self.ports.transport.peers(), mode) {
            self.survival.figures.begin(self.incarnation);
            let account = OwnAccount::begin(&self.group, self.service, self.incarnation)?;
            self.survival.account = Some(account);
            if self.group.standby.contains(&self.service) {
                // Above the loops: it only ever ends.
                let priority = above(granted.priority(&Request::of(scenario, self.service)));
                let own = (self.service, self.incarnation);
                end_word::announce(&peers.words, own, priority)?;
            }
        }
        self.life.granted = Some(granted.clone());
        self.life.link.send(FromService::Ready(granted.clone()))?;
        let order = self.life.link.wait_for_start()?;
        self.cycles.clock.start(order.start_ns);
        // All services' ports exist now.
        self.ports.connect()?;
        match order.standby_for {
            Some(active) => {
                // Silent before the threads of the standby begin: it sends and records nothing.
                self.survival.gate.set_standby(true);
                self.survival.figures.set_recording(false);
                let words = &self.ports.transport.peers().expect("a standby is a process").words;
                let own = (self.service, self.incarnation);
                let standby = Standby::begin(&self.group, words, scenario, own, active, &granted)?;
                self.survival.standby = Some(standby);
            }
            None if !self.survival.gate.claim() => return Err(RuntimeError::Replaced),
            None => {}
        }
        if self.is_restarted() {
            self.catch_up();
        }
        Ok(())
    }

    /// Joins a run that goes on: the first release is the present step's, at once. It waits until every input
    /// has brought its last message or shows that it is empty.
    fn catch_up(&mut self) {
        let begun = Instant::now();
        while begun.elapsed() < INPUT_PATIENCE && !self.ports.have_input() {
            std::thread::sleep(Duration::from_micros(200));
        }
        self.cycles.next_step = self.cycles.present_step();
    }

    /// Reports to the launcher, with the service's own `figures`, and keeps all ports open until all services have
    /// reported. So no last message is lost with its sender.
    pub fn finish(self, figures: impl Serialize) -> Result<(), RuntimeError> {
        let (cycles, skipped) = self.survival.counted(self.cycles.run, self.cycles.skipped);
        let (sent, received) = self.ports.reports();
        let mut fault_statistics = Vec::new();
        self.injection.faults.statistics(&mut fault_statistics);
        let report = ServiceReport {
            allocations_in_loop: self.life.allocations_in_loop,
            service: self.service,
            cycles,
            skipped,
            release_jitter_us: self.cycles.jitter.percentiles_us(),
            sent,
            received,
            peak_rss_kib: (self.carrier() == Carrier::SharedMemory).then(peak_rss_kib),
            scheduling: self.life.granted.expect("`begin` comes before `finish`"),
            fault_statistics,
            details: Payload::of(&figures),
        };
        self.life.link.send(FromService::Report(Box::new(report)))?;
        self.life.link.wait_for_the_end();
        Ok(())
    }
}

/// Peak resident set of this process, KiB; 0 if the kernel does not give it.
fn peak_rss_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}
