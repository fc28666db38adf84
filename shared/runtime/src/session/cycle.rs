//! Work of every service in each cycle.

use super::Runtime;
use crate::machine::scheduling::become_ordinary;
use crate::transport::Carrier;
use crate::{FromService, Mode, RuntimeError, Subscriber};
use messages::{Header, Message, Origins, ServiceState};
use std::sync::OnceLock;
use std::time::Duration;

static ALLOCATIONS: OnceLock<fn() -> u64> = OnceLock::new();

/// Lets services report how often their loop allocated, by a counter of the calling thread's
/// allocations. It serves programs whose global allocator counts.
pub fn count_allocations_by(counter: fn() -> u64) {
    // A second counter changes nothing.
    let _ = ALLOCATIONS.set(counter);
}

/// Run time between two heartbeats, ns.
const HEARTBEAT_NS: i64 = 100_000_000;

/// Result of a cycle for the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    Next,
    Last,
}

impl Runtime {
    /// Runs cycles until one says that the run is over, or it is.
    ///
    /// # Errors
    /// The result of a cycle, except [`RuntimeError::Stopped`], which is an end like any other.
    pub fn run_cycles(
        &mut self,
        mut cycle: impl FnMut(&mut Self) -> Result<Cycle, RuntimeError>,
    ) -> Result<(), RuntimeError> {
        let allocations = || ALLOCATIONS.get().map(|count| count());
        let before = allocations();
        let result = loop {
            match cycle(self) {
                Ok(Cycle::Next) => {}
                Ok(Cycle::Last) | Err(RuntimeError::Stopped) => break Ok(()),
                Err(error) => break Err(error),
            }
        };
        if self.carrier() == Carrier::SharedMemory && self.group.mode == Mode::Realtime {
            // Others may still have their last cycle to run while this service writes its report.
            become_ordinary();
        }
        self.life.allocations_in_loop =
            allocations().zip(before).map(|(after, before)| after - before);
        result
    }

    /// Takes the newest sample of `T`'s topic; in lockstep, waits for the one that is due.
    ///
    /// # Errors
    /// [`RuntimeError::Starved`] if a due sample never comes, [`RuntimeError::Stopped`] if the run
    /// ends meanwhile.
    pub fn update<T: Message>(&self, topic: &mut Subscriber<T>) -> Result<(), RuntimeError> {
        let patience = Duration::from_nanos(self.group.patience_ns.unsigned_abs());
        let (step, end) = (self.cycles.step, &self.life.link.orders.end);
        if let Some(origin) = self.cycles.recorded_input(T::TOPIC) {
            return topic.await_sample(origin, step, end, patience);
        }
        match (self.group.mode, topic.stride()) {
            (Mode::Lockstep, Some(stride)) => {
                topic.await_step(step - step % stride, step, end, patience)?;
            }
            _ => topic.drain(|_| {})?,
        }
        topic.settle(self.clock().now_ns());
        Ok(())
    }

    /// Sends the heartbeat when it is due; called once at the end of every cycle.
    pub fn end_cycle(&mut self, state: ServiceState) -> Result<(), RuntimeError> {
        if let Some(mut drive) = self.injection.drive.take() {
            self.update(&mut drive)?;
            self.injection.drive = Some(drive);
        }
        let (scheduled_ns, cycles) = (self.cycles.scheduled_ns(), self.cycles.run);
        // Due once in every heartbeat period, or in every cycle if the service's own is longer.
        if scheduled_ns % HEARTBEAT_NS < self.cycles.period_ns() {
            let header = Header::new(self.cycles.step, scheduled_ns, Origins::NONE);
            let heartbeat = self.life.heartbeat.as_mut();
            heartbeat.expect("`begin` opened the heartbeat").send_with(|message| {
                message.header = header;
                message.cycles = cycles;
                message.state = state as u64;
            })?;
        }
        let counted = self.survival.counted(cycles, self.skipped());
        let speaks = !self.is_standby();
        self.survival.figures.show_progress(cycles);
        if let Some(account) = self.survival.account.as_mut().filter(|_| speaks) {
            account.write(counted, &self.ports, &self.injection.faults)?;
        }
        Ok(())
    }

    /// Ends the run for the whole group after the current step: for the plant's referee.
    pub fn end_run(&mut self) -> Result<(), RuntimeError> {
        let step = self.cycles.step;
        self.life.link.orders.end.set_before(step + 1);
        self.life.link.send(FromService::Ended(step))
    }
}
