//! From the open ports to the first release.

use super::Runtime;
use crate::machine::scheduling::{Granted, Request, above, apply, in_force};
use crate::survival::end_word;
use crate::survival::standby::{ActiveProcess, Standby};
use crate::transport::Carrier;
use crate::{FromService, Mode, RuntimeError};
use messages::Topic;
use scenario::Scenario;
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
        self.watch_the_drive()?;
        let (carrier, mode) = (self.carrier(), self.group.mode);
        let granted = match (carrier, mode) {
            // The thread is not this service's alone.
            (Carrier::Memory, _) => in_force(),
            (Carrier::SharedMemory, Mode::Realtime) => apply(&Request::of(scenario, self.service)),
            (Carrier::SharedMemory, Mode::Lockstep) => apply(&Request::NOTHING),
        };
        if granted.is_realtime() {
            self.life.link.raise_thread();
        }
        if carrier == Carrier::SharedMemory && mode == Mode::Realtime {
            self.survival.counts.begin_account(self.incarnation)?;
            if self.group.standby.contains(&self.service) {
                // Above the loops: it only ever ends.
                let priority = above(granted.priority(&Request::of(scenario, self.service)));
                end_word::announce(&self.group, (self.service, self.incarnation), priority)?;
            }
        }
        self.life.granted = Some(granted.clone());
        self.life.link.send(FromService::Ready(granted.clone()))?;
        let order = self.life.link.wait_for_start()?;
        self.cycles.clock.start(order.start_ns);
        // All services' ports exist now.
        self.ports.connect()?;
        match order.standby_for {
            Some(active) => self.stand_by(scenario, active, &granted)?,
            None if !self.survival.gate.claim() => return Err(RuntimeError::Replaced),
            None => {}
        }
        if self.is_restarted() {
            self.catch_up();
        }
        Ok(())
    }

    /// Opens the ego's ground truth for faults that wait for it, if the service has no other use for it.
    fn watch_the_drive(&mut self) -> Result<(), RuntimeError> {
        let waits = self.injection.faults.waits_for_the_drive();
        if waits && !self.ports.has(Topic::EgoTruth) && !self.cycles.is_replay() {
            self.injection.drive = Some(Box::new(self.subscriber()?));
        }
        Ok(())
    }

    fn stand_by(
        &mut self,
        scenario: &Scenario,
        active: ActiveProcess,
        granted: &Granted,
    ) -> Result<(), RuntimeError> {
        let own = (self.service, self.incarnation);
        let slot = &self.life.link.take_over;
        // Silent before the threads of the standby begin.
        self.survival.be_silent();
        let standby = Standby::begin(&self.group, scenario, own, active, granted, slot)?;
        self.survival.standby = Some(standby);
        Ok(())
    }

    /// Joins a run that goes on: the first release is the present step's, at once. It waits until every input
    /// has brought its last message or shows that it is empty.
    fn catch_up(&mut self) {
        let begun = Instant::now();
        while begun.elapsed() < INPUT_PATIENCE && !self.ports.have_input() {
            std::thread::sleep(Duration::from_micros(200));
        }
        self.cycles.resume_at(self.cycles.present_step());
    }
}
