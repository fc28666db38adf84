//! From the open ports to the first release.

use super::Runtime;
use crate::machine::scheduling::{Granted, Request, above, apply, in_force};
use crate::survival::account::Account;
use crate::survival::end_word;
use crate::survival::standby::{ActiveProcess, Standby};
use crate::transport::Carrier;
use crate::{FromService, Mode, RuntimeError};
use messages::{Heartbeat, Topic};
use scenario::Scenario;
use std::time::{Duration, Instant};

/// Longest that a restarted service waits for its inputs' last messages; a dead input has none.
const INPUT_PATIENCE: Duration = Duration::from_millis(15);

impl Runtime {
    /// Tells the launcher that all ports are open, and waits for the common start.
    ///
    /// # Errors
    /// If the link breaks or the run ends before it began.
    pub fn begin(&mut self, scenario: &Scenario) -> Result<(), RuntimeError> {
        self.heartbeat = Some(self.publisher::<Heartbeat>()?);
        let hears_the_drive =
            (self.sent.iter().chain(&self.received)).any(|(topic, _)| *topic == Topic::EgoTruth);
        if self.faults.waits_for_the_drive() && !hears_the_drive && self.schedule.is_none() {
            self.drive = Some(Box::new(self.subscriber()?));
        }
        self.account = match (self.carrier(), self.group.mode) {
            (Carrier::SharedMemory, Mode::Realtime) => {
                Some(Account::open(&self.group, self.service, self.incarnation)?)
            }
            _ => None,
        };
        let granted = match (self.carrier(), self.group.mode) {
            // The thread is not this service's alone.
            (Carrier::Memory, _) => in_force(),
            (Carrier::SharedMemory, Mode::Realtime) => apply(&Request::of(scenario, self.service)),
            (Carrier::SharedMemory, Mode::Lockstep) => apply(&Request::NOTHING),
        };
        if granted.is_realtime() {
            self.link.raise_thread();
        }
        if self.account.is_some() && self.group.standby.contains(&self.service) {
            // Above the loops: it only ever ends.
            let priority = above(granted.priority(&Request::of(scenario, self.service)));
            end_word::announce(&self.group, (self.service, self.incarnation), priority)?;
        }
        self.granted = Some(granted.clone());
        self.link.send(FromService::Ready(granted.clone()))?;
        let order = self.link.wait_for_start()?;
        self.clock.start(order.start_ns);
        // All services' ports exist now.
        self.connect()?;
        match order.standby_for {
            Some(active) => self.stand_by(scenario, active, &granted)?,
            None if !self.gate.claim() => return Err(RuntimeError::Replaced),
            None => {}
        }
        if self.is_restarted() {
            self.catch_up();
        }
        Ok(())
    }

    fn stand_by(
        &mut self,
        scenario: &Scenario,
        active: ActiveProcess,
        granted: &Granted,
    ) -> Result<(), RuntimeError> {
        self.gate.set_standby(true);
        self.figures.set_recording(false);
        let own = (self.service, self.incarnation);
        let slot = &self.link.take_over;
        self.standby = Some(Standby::begin(&self.group, scenario, own, active, granted, slot)?);
        Ok(())
    }

    /// Joins a run that goes on: the first release is that of the present step, at once, as soon as
    /// every input has brought its last message, or shows that it has none.
    fn catch_up(&mut self) {
        let begun = Instant::now();
        while begun.elapsed() < INPUT_PATIENCE && !self.inputs.iter().all(|i| i.has_input()) {
            std::thread::sleep(Duration::from_micros(200));
        }
        self.next_step =
            u64::try_from(self.clock.now_ns() / self.group.timetable.step_ns).unwrap_or(0);
    }
}
