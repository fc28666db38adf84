//! One service's life in the group.

mod cycle;
mod ports;
mod releases;
mod start;

pub use cycle::{Cycle, count_allocations_by};

use crate::counts::figures::{Figures, RELEASE_JITTER};
use crate::faults::Faults;
use crate::life::link::Link;
use crate::machine::scheduling::Granted;
use crate::ports::Ports;
use crate::releases::cycles::Cycles;
use crate::releases::schedule::Schedule;
use crate::survival::Survival;
use crate::survival::checkpoint::{Checkpoint, state_path};
use crate::transport::{Carrier, Seat, SharedMemory, Transport, Turns};
use crate::{Clock, Group, Mode, Publisher, RuntimeError, Subscriber, Usage};
use messages::{EgoTruth, Heartbeat, Service};
use rustix::time::{ClockId, clock_gettime};
use scenario::Scenario;
use serde::de::DeserializeOwned;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::Ordering;

/// A service that joined the group.
///
/// | part | what it owns |
/// | --- | --- |
/// | `ports` | the ends of topics, their counts |
/// | `cycles` | clock, timetable, present step |
/// | `survival` | what outlives the process: counts, epoch, standby |
/// | `injection` | faults of messages |
/// | `life` | link to the launcher, what the kernel granted, heartbeat |
#[derive(Debug)]
pub struct Runtime {
    service: Service,
    incarnation: u32,
    group: Group,
    scenario: Scenario,
    ports: Ports,
    cycles: Cycles,
    survival: Survival,
    injection: Injection,
    life: Life,
}

#[derive(Debug)]
struct Injection {
    faults: Rc<Faults>,
    /// The ego's drive, for faults that wait for a phase of it, in a service without another use for it.
    drive: Option<Box<Subscriber<EgoTruth>>>,
}

/// State of a service from its beginning to its end.
#[derive(Debug)]
struct Life {
    link: Link,
    granted: Option<Granted>,
    heartbeat: Option<Publisher<Heartbeat>>,
    allocations_in_loop: Option<u64>,
}

impl Runtime {
    /// Joins the group whose root is `root` as `service`. A process that was started ahead waits before it opens
    /// anything of the run.
    pub(super) fn join(
        service: Service,
        root: &Path,
        incarnation: u32,
        wait: impl FnOnce(&Link) -> Result<(), RuntimeError>,
    ) -> Result<Self, RuntimeError> {
        let link = Link::open()?;
        let group = Group::read(root)?;
        let scenario = group.scenario()?;
        let schedule = Schedule::read(&group.root, service)?;
        wait(&link)?;
        let transport = Transport::SharedMemory(SharedMemory::join(&group, service.name())?);
        let figures = match group.mode {
            Mode::Realtime => Figures::open(&group, service)?,
            Mode::Lockstep => Figures::default(),
        };
        let jitter = figures.latencies(RELEASE_JITTER)?;
        let survival = Survival::new(figures, transport.peers().cloned(), service, incarnation);
        let ports = Ports::new(transport);
        let mut this = Self::of(service, incarnation, group, scenario, ports, survival, link);
        this.cycles.schedule = schedule;
        this.cycles.jitter = jitter;
        Ok(this)
    }

    /// Joins the group whose services take turns in this thread.
    pub(super) fn join_in_process(
        service: Service,
        group: Group,
        scenario: Scenario,
        seat: Seat,
        link: Link,
    ) -> Self {
        let survival = Survival::new(Figures::default(), None, service, 0);
        let ports = Ports::new(Transport::Memory(seat));
        Self::of(service, 0, group, scenario, ports, survival, link)
    }

    fn of(
        service: Service,
        incarnation: u32,
        group: Group,
        scenario: Scenario,
        ports: Ports,
        survival: Survival,
        mut link: Link,
    ) -> Self {
        link.orders.end.set_before(group.timetable.last_step + 1);
        let faults = Rc::new(Faults::of(&scenario, link.injected.take()));
        Self {
            service,
            incarnation,
            cycles: Cycles::new(group.mode, group.timetable, service),
            group,
            scenario,
            ports,
            survival,
            injection: Injection { faults, drive: None },
            life: Life { link, granted: None, heartbeat: None, allocations_in_loop: None },
        }
    }

    pub fn scenario(&self) -> Scenario {
        self.scenario.clone()
    }

    /// True for a process that takes the place of one that died during the run.
    pub fn is_restarted(&self) -> bool {
        self.incarnation > 0
    }

    /// True while this process is a standby: it computes, and sends nothing.
    pub fn is_standby(&self) -> bool {
        self.survival.gate.is_standby()
    }

    /// State that this service keeps for the process that may take its place.
    pub fn checkpoint<T: DeserializeOwned>(&self) -> Result<Checkpoint<T>, RuntimeError> {
        Checkpoint::open(&state_path(&self.group.prefix, self.service))
    }

    /// Counts and histograms that go on over all processes of this service. A standby records nothing.
    pub fn figures(&self) -> &Figures {
        &self.survival.figures
    }

    /// Goes on with the step after `step`, whatever time it is.
    pub fn resume_after(&mut self, step: u64) {
        self.cycles.next_step = step + 1;
    }

    /// True once the launcher asked for a stop in lane.
    pub fn is_to_stop(&self) -> bool {
        self.life.link.orders.safe_stop.load(Ordering::Relaxed)
    }

    /// This service's turns in a run in one process; none in a process of its own.
    pub fn turns(&self) -> Option<Turns> {
        match &self.ports.transport {
            Transport::Memory(seat) => seat.turns(),
            Transport::SharedMemory(_) => None,
        }
    }

    pub(crate) fn carrier(&self) -> Carrier {
        self.ports.transport.carrier()
    }

    pub fn clock(&self) -> &Clock {
        &self.cycles.clock
    }

    /// UTC of run time 0, ns since 1970: in simulated time the same in every run.
    pub fn utc_start_ns(&self) -> i64 {
        match self.group.mode {
            Mode::Realtime => {
                let utc = clock_gettime(ClockId::Realtime);
                utc.tv_sec * 1_000_000_000 + utc.tv_nsec - self.clock().now_ns()
            }
            Mode::Lockstep => scenario::radio::SIMULATED_START_NS,
        }
    }

    /// Use of the machine by the calling thread so far; nothing in simulated time, whose messages
    /// repeat to the byte.
    pub fn usage(&self) -> Usage {
        match self.group.mode {
            Mode::Realtime => Usage::of_this_thread(),
            Mode::Lockstep => Usage::default(),
        }
    }

    pub fn skipped(&self) -> u64 {
        self.cycles.skipped
    }
}
