//! One service's life in the group.

mod cycle;
mod ports;
mod releases;
mod report;
mod start;

pub use cycle::{Cycle, count_allocations_by};

use crate::faults::Faults;
use crate::life::link::Link;
use crate::machine::scheduling::Granted;
use crate::ports::members::Members;
use crate::ports::{Backlog, Tally};
use crate::releases::schedule::Schedule;
use crate::statistics::Latencies;
use crate::survival::account::Account;
use crate::survival::checkpoint::{Checkpoint, state_path};
use crate::survival::fence::Fences;
use crate::survival::gate::Gate;
use crate::survival::kept::{Figures, RELEASE_JITTER};
use crate::survival::standby::Standby;
use crate::transport::{Carrier, Connect, Input, Seat, SharedMemory, Transport};
use crate::{Clock, Group, Mode, Publisher, RuntimeError, Subscriber, Usage};
use messages::{EgoTruth, Heartbeat, Service, Topic};
use scenario::Scenario;
use serde::de::DeserializeOwned;
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::Ordering;

/// A service that joined the group.
#[derive(Debug)]
pub struct Runtime {
    group: Group,
    service: Service,
    incarnation: u32,
    transport: Transport,
    clock: Rc<Clock>,
    link: Link,
    sent: Vec<(Topic, Rc<RefCell<Tally>>)>,
    received: Vec<(Topic, Rc<RefCell<Tally>>)>,
    ports: Vec<(Topic, Rc<dyn Connect>)>,
    heartbeat: Option<Publisher<Heartbeat>>,
    granted: Option<Granted>,
    /// The releases of a recorded run, where one is replayed.
    schedule: Option<Schedule>,
    scenario: Scenario,
    members: Rc<Members>,
    faults: Rc<Faults>,
    /// What the ego does, for faults that wait for it, of a service that has no other use for it.
    drive: Option<Box<Subscriber<EgoTruth>>>,
    /// Receiving ends that a restarted service waits for.
    inputs: Vec<Rc<dyn Input>>,
    step: u64,
    next_step: u64,
    cycles: u64,
    skipped: u64,
    jitter: Latencies,
    allocations_in_loop: Option<u64>,
    /// In realtime, where a process may die and the run goes on.
    account: Option<Account>,
    figures: Figures,
    fences: Option<Fences>,
    gate: Rc<Gate>,
    /// What the ports keep back while this process is a standby.
    backlogs: Vec<Rc<dyn Backlog>>,
    standby: Option<Standby>,
    /// Cycles and skipped releases of the time as a standby.
    silent: (u64, u64),
}

impl Runtime {
    /// Joins the group whose root is `root` as `service`.
    ///
    /// # Errors
    /// If the group file, the link or the run's shared memory is not usable.
    pub fn join(service: Service, root: &Path, incarnation: u32) -> Result<Self, RuntimeError> {
        Self::join_when(service, root, incarnation, |_| Ok(()))
    }

    /// The same for a process that was started ahead: it waits before it opens anything of the run.
    pub(super) fn join_when(
        service: Service,
        root: &Path,
        incarnation: u32,
        wait: impl FnOnce(&Link) -> Result<(), RuntimeError>,
    ) -> Result<Self, RuntimeError> {
        let link = Link::open()?;
        let group = Group::read(root)?;
        let scenario = Scenario::parse("scenario", &group.scenario)?;
        let schedule = Schedule::read(&group.root, service)?;
        wait(&link)?;
        let transport = Transport::SharedMemory(SharedMemory::join(&group, service.name())?);
        let members = Members::of(&group.root);
        let fences = Fences::of(&group)?;
        let gate = Rc::new(Gate::of(fences.clone(), service, incarnation));
        let figures = match group.mode {
            Mode::Realtime => Figures::open(&group, service)?,
            Mode::Lockstep => Figures::default(),
        };
        let mut this = Self::new(service, group, scenario, transport, members, link);
        (this.incarnation, this.schedule, this.fences) = (incarnation, schedule, fences);
        (this.gate, this.jitter) = (gate, figures.latencies(RELEASE_JITTER)?);
        this.figures = figures;
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
        Self::new(service, group, scenario, Transport::Memory(seat), Members::InProcess, link)
    }

    /// Follows a recorded run's releases, where there are any.
    pub(super) fn following(self, schedule: Option<Schedule>) -> Self {
        Self { schedule, ..self }
    }

    fn new(
        service: Service,
        group: Group,
        scenario: Scenario,
        transport: Transport,
        members: Members,
        link: Link,
    ) -> Self {
        link.end.set_before(group.timetable.last_step + 1);
        Self {
            members: Rc::new(members),
            faults: Rc::new(Faults::of(&scenario, link.inbox.clone())),
            scenario,
            inputs: Vec::new(),
            drive: None,
            clock: Rc::new(Clock::new(group.mode, group.timetable.step_ns)),
            group,
            service,
            incarnation: 0,
            transport,
            link,
            sent: Vec::new(),
            received: Vec::new(),
            ports: Vec::new(),
            heartbeat: None,
            granted: None,
            schedule: None,
            step: 0,
            next_step: 0,
            cycles: 0,
            skipped: 0,
            jitter: Latencies::default(),
            allocations_in_loop: None,
            account: None,
            figures: Figures::default(),
            fences: None,
            gate: Rc::new(Gate::open(service)),
            backlogs: Vec::new(),
            standby: None,
            silent: (0, 0),
        }
    }

    /// The effective scenario.
    #[must_use]
    pub fn scenario(&self) -> Scenario {
        self.scenario.clone()
    }

    /// True for a process that takes the place of one that died during the run.
    #[must_use]
    pub fn is_restarted(&self) -> bool {
        self.incarnation > 0
    }

    /// True while this process computes for the case that the active one of its service ends, and sends
    /// nothing.
    #[must_use]
    pub fn is_standby(&self) -> bool {
        self.gate.is_standby()
    }

    /// Where this service keeps state for the process that may take its place.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for it.
    pub fn checkpoint<T: DeserializeOwned>(&self) -> Result<Checkpoint<T>, RuntimeError> {
        Checkpoint::open(&state_path(&self.group.prefix, self.service))
    }

    /// Counts and histograms that go on over all processes of this service. A standby records nothing.
    #[must_use]
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// Goes on with the step after `step`, whatever time it is.
    pub fn resume_after(&mut self, step: u64) {
        self.next_step = step + 1;
    }

    /// True once the launcher asked for a stop in lane.
    #[must_use]
    pub fn is_to_stop(&self) -> bool {
        self.link.safe_stop.load(Ordering::Relaxed)
    }

    /// What carries this service's messages.
    pub(crate) fn carrier(&self) -> Carrier {
        match self.transport {
            Transport::SharedMemory(_) => Carrier::SharedMemory,
            Transport::Memory(_) => Carrier::Memory,
        }
    }

    /// The clock.
    #[must_use]
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// UTC of run time 0, ns since 1970: in simulated time the same in every run.
    #[must_use]
    pub fn utc_start_ns(&self) -> i64 {
        match self.group.mode {
            Mode::Realtime => crate::releases::clock::utc_ns() - self.clock.now_ns(),
            Mode::Lockstep => scenario::radio::SIMULATED_START_NS,
        }
    }

    /// What the calling thread used of the machine so far; nothing in simulated time, whose messages
    /// repeat to the byte.
    #[must_use]
    pub fn usage(&self) -> Usage {
        match self.group.mode {
            Mode::Realtime => Usage::of_this_thread(),
            Mode::Lockstep => Usage::default(),
        }
    }

    /// Releases left out so far.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        self.skipped
    }
}
