//! One service's life in the group.

use super::account::Account;
use super::checkpoint::{Checkpoint, state_path};
use super::faults::{Faults, SenderFaults};
use super::fence::Fences;
use super::gate::Gate;
use super::link::Link;
use super::members::Members;
use super::port::{Backlog, Outlet, Tally};
use super::schedule::Schedule;
use super::scheduling::{Granted, Request, apply, in_force};
use super::standby::{ActiveProcess, Standby, TakeOver};
use super::transport::{Carrier, Connect, Input, Seat, SharedMemory, Transport};
use super::{
    Carried, Clock, FromService, Group, Mode, Overrun, Publisher, Release, RuntimeError,
    Subscriber, Usage,
};
use crate::report::{Details, ServiceReport};
use crate::statistics::Latencies;
use messages::Service;
use messages::{EgoTruth, Header, Heartbeat, Message, Origins, ServiceState, Topic};
use scenario::Scenario;
use serde::de::DeserializeOwned;
use std::cell::RefCell;
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::OnceLock;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

static ALLOCATIONS: OnceLock<fn() -> u64> = OnceLock::new();

/// Lets services report how often their loop allocated, by a counter of the calling thread's
/// allocations: for programs whose global allocator counts.
pub fn count_allocations_by(counter: fn() -> u64) {
    // A second counter changes nothing.
    let _ = ALLOCATIONS.set(counter);
}

/// Run time between two heartbeats, ns.
const HEARTBEAT_NS: i64 = 100_000_000;

/// Longest that a restarted service waits for its inputs' last messages; a dead input has none.
const INPUT_PATIENCE: Duration = Duration::from_millis(15);

/// Exit status of a process whose standby took over.
const REPLACED: u8 = 3;

/// What a cycle says of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cycle {
    /// It goes on.
    Next,
    /// It is over.
    Last,
}

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
        let link = Link::open()?;
        let group = Group::read(root)?;
        let scenario = Scenario::parse("scenario", &group.scenario)
            .map_err(|e| RuntimeError::Setup(e.to_string()))?;
        let schedule = Schedule::read(&group.root, service)?;
        let transport = Transport::SharedMemory(SharedMemory::join(&group, service.name())?);
        let members = Members::of(&group.root);
        let fences = Fences::of(&group)?;
        let gate = Rc::new(Gate::of(fences.clone(), service, incarnation));
        let this = Self::new(service, group, scenario, transport, members, link);
        Ok(Self { incarnation, schedule, fences, gate, ..this })
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
            fences: None,
            gate: Rc::new(Gate::open(service)),
            backlogs: Vec::new(),
            standby: None,
            silent: (0, 0),
        }
    }

    /// What carries this service's messages.
    pub(crate) fn carrier(&self) -> Carrier {
        match self.transport {
            Transport::SharedMemory(_) => Carrier::SharedMemory,
            Transport::Memory(_) => Carrier::Memory,
        }
    }

    /// Opens the sending end of `T`'s topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn publisher<T: Carried>(&mut self) -> Result<Publisher<T>, RuntimeError> {
        let tally = Tally::of_sender(self.group.mode);
        self.sent.push((T::TOPIC, Rc::clone(&tally)));
        let awaited = match self.group.mode {
            Mode::Lockstep => !T::TOPIC.consumers().is_empty(),
            // The radar alone can release services.
            Mode::Realtime => matches!(T::TOPIC, Topic::RadarTracks | Topic::RadarDetections),
        };
        let port = T::sender(&self.transport, self.link.end.clone())?;
        self.ports.push((T::TOPIC, Rc::clone(&port) as Rc<dyn Connect>));
        let publisher = Publisher::new(Outlet {
            port,
            waker: awaited.then(|| self.transport.waker(T::TOPIC)),
            clock: Rc::clone(&self.clock),
            timetable: self.group.timetable,
            source: self.service,
            incarnation: self.incarnation,
            faults: Rc::clone(&self.faults),
            sender_faults: SenderFaults::new(),
            tally,
            gate: Rc::clone(&self.gate),
            held: None,
        });
        self.backlogs.push(publisher.backlog());
        Ok(publisher)
    }

    /// Opens the receiving end of `T`'s topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn subscriber<T: Carried>(&mut self) -> Result<Subscriber<T>, RuntimeError> {
        self.subscribe(self.group.mode == Mode::Lockstep)
    }

    /// Opens the receiving end of `T`'s topic so that its samples can release this service.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn releasing_subscriber<T: Carried>(&mut self) -> Result<Subscriber<T>, RuntimeError> {
        self.subscribe(true)
    }

    fn subscribe<T: Carried>(&mut self, waits: bool) -> Result<Subscriber<T>, RuntimeError> {
        let tally = Tally::of_receiver();
        self.received.push((T::TOPIC, Rc::clone(&tally)));
        let waiter = waits.then(|| self.transport.waiter(T::TOPIC));
        let port = T::receiver(&self.transport)?;
        self.ports.push((T::TOPIC, Rc::clone(&port) as Rc<dyn Connect>));
        self.inputs.push(Rc::clone(&port) as Rc<dyn Input>);
        let (members, faults) = (Rc::clone(&self.members), Rc::clone(&self.faults));
        let clock = Some(Rc::clone(&self.clock));
        let fences = self.fences.clone();
        Ok(Subscriber::new(port, waiter, members, fences, clock, faults, tally))
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

    /// Goes on with the step after `step`, whatever time it is.
    pub fn resume_after(&mut self, step: u64) {
        self.next_step = step + 1;
    }

    /// True once the launcher asked for a stop in lane.
    #[must_use]
    pub fn is_to_stop(&self) -> bool {
        self.link.safe_stop.load(Ordering::Relaxed)
    }

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
        self.granted = Some(granted.clone());
        self.link.say(FromService::Ready(granted.clone()))?;
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
        let own = (self.service, self.incarnation);
        let slot = &self.link.take_over;
        self.standby = Some(Standby::begin(&self.group, scenario, own, active, granted, slot)?);
        Ok(())
    }

    /// Sends what was computed as a standby, if the service was taken over meanwhile.
    fn finish_take_over(&mut self) -> Result<(), RuntimeError> {
        let Some(standby) = &self.standby else { return Ok(()) };
        if standby.stands_by() {
            return Ok(());
        }
        let Some((cause, noticed_ns)) = standby.taken_over() else {
            return Err(RuntimeError::Replaced);
        };
        self.gate.set_standby(false);
        // What is older than the present period the active process has sent.
        let present = self.group.timetable.latest_release(
            self.service,
            u64::try_from(self.clock.now_ns() / self.group.timetable.step_ns).unwrap_or(0),
        );
        let step = self.step;
        for backlog in self.backlogs.iter().filter(|_| step >= present) {
            backlog.send_held(step)?;
        }
        let sent_ns = super::monotonic_ns();
        self.standby = None;
        self.silent = (self.cycles, self.skipped);
        for (_, tally) in self.received.iter() {
            tally.borrow_mut().begin_anew();
        }
        self.jitter = Latencies::default();
        self.link.say(FromService::TookOver(TakeOver { cause, noticed_ns, sent_ns }))
    }

    fn connect(&self) -> Result<(), RuntimeError> {
        for (topic, port) in &self.ports {
            port.connect().map_err(|reason| RuntimeError::Topic { topic: *topic, reason })?;
        }
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

    /// Connects to processes that joined since the last time, and takes in new faults.
    fn look_around(&self) {
        if self.link.joined.swap(false, Ordering::Relaxed) {
            // A peer that died again at once; the next message tries anew.
            let _ = self.connect();
        }
        self.faults.refresh();
    }

    /// Waits for the next release on the timer; `None` at the end of the run.
    ///
    /// # Errors
    /// [`RuntimeError::Replaced`] if the service's standby has taken over, [`RuntimeError::Send`] if this
    /// process is it and cannot send.
    pub fn next_release(&mut self, overrun: Overrun) -> Result<Option<Release>, RuntimeError> {
        let idle_ns = self.clock.now_ns();
        if self.group.mode == Mode::Realtime {
            loop {
                self.look_around();
                self.finish_take_over()?;
                let scheduled = self.clock.scheduled_ns(self.next_step);
                if self.link.end.is_before(self.next_step) {
                    return Ok(None);
                }
                let late = self.clock.now_ns() - scheduled;
                if late < 0 {
                    match &self.standby {
                        Some(standby) => standby.wait(Duration::from_nanos(late.unsigned_abs())),
                        None => self.clock.sleep_until_run_time(scheduled),
                    }
                } else if overrun == Overrun::CatchUp || !self.skip_missed(late) {
                    break;
                }
            }
        }
        Ok(self.release(idle_ns))
    }

    /// Waits for the next release by a sample of `T`'s topic, which must be due whenever this
    /// service is. In realtime a sample that is `fallback_ns` late is not waited for any longer.
    ///
    /// # Errors
    /// If the topic breaks, and as [`Self::next_release`].
    pub fn next_release_by<T: Message>(
        &mut self,
        samples: &mut Subscriber<T>,
        fallback_ns: i64,
    ) -> Result<Option<Release>, RuntimeError> {
        let idle_ns = self.clock.now_ns();
        if self.group.mode == Mode::Realtime {
            loop {
                self.look_around();
                if self.link.end.is_before(self.next_step) {
                    return Ok(None);
                }
                let ticket = samples.ticket();
                self.finish_take_over()?;
                samples.drain(u64::MAX, |_| {})?;
                let late = self.clock.now_ns() - self.clock.scheduled_ns(self.next_step);
                if self.skip_missed(late) {
                    continue;
                }
                let first = self.is_restarted() && self.cycles == 0;
                if first || samples.reaches(self.next_step) || late >= fallback_ns {
                    break;
                }
                let wait = (fallback_ns - late).clamp(1_000, 50_000_000).unsigned_abs();
                samples.wait(ticket, Duration::from_nanos(wait))?;
            }
        }
        Ok(self.release(idle_ns))
    }

    /// Leaves out the releases that are over by more than a period; true if there were any.
    fn skip_missed(&mut self, late_ns: i64) -> bool {
        let period = self.group.timetable.period_ns(self.service);
        let missed = u64::try_from(late_ns / period).unwrap_or(0);
        self.skipped += missed;
        self.next_step += missed * self.group.timetable.stride(self.service);
        missed > 0
    }

    /// The service's next step on its own grid after `step`: a restarted service begins off it.
    fn step_after(&self, step: u64) -> u64 {
        self.group.timetable.latest_release(self.service, step)
            + self.group.timetable.stride(self.service)
    }

    fn release(&mut self, idle_ns: i64) -> Option<Release> {
        if self.link.end.is_before(self.next_step) {
            return None;
        }
        let recorded = match &mut self.schedule {
            Some(schedule) => Some(schedule.advance()?),
            None => None,
        };
        self.step = recorded.map_or(self.next_step, |release| release.step);
        self.next_step = self.step_after(self.step);
        self.clock.set_step(self.step);
        let scheduled_ns = self.clock.scheduled_ns(self.step);
        let start_ns = recorded.map_or_else(|| self.clock.now_ns(), |release| release.start_ns);
        if let Some(release) = recorded {
            self.clock.set_simulated(release.publish_ns);
        }
        // In lockstep the wait begins in an earlier step, and takes no time.
        let idle_ns = if self.group.mode == Mode::Realtime { idle_ns } else { start_ns };
        if self.group.mode == Mode::Realtime {
            self.jitter.record_ns(start_ns - scheduled_ns);
        }
        self.cycles += 1;
        if let Some(standby) = &mut self.standby {
            standby.look_at_active();
        }
        let time_s = scheduled_ns as f64 / 1e9;
        Some(Release { step: self.step, time_s, scheduled_ns, idle_ns, start_ns })
    }

    /// Takes the newest sample of `T`'s topic; in lockstep, waits for the one that is due.
    ///
    /// # Errors
    /// [`RuntimeError::Starved`] if a due sample never comes, [`RuntimeError::Stopped`] if the run
    /// ends meanwhile.
    pub fn update<T: Message>(&self, topic: &mut Subscriber<T>) -> Result<(), RuntimeError> {
        let patience = Duration::from_nanos(self.group.patience_ns.unsigned_abs());
        if let Some(schedule) = &self.schedule {
            let origin = schedule.input(T::TOPIC);
            return topic.await_sample(origin, self.step, &self.link.end, patience);
        }
        let source = T::TOPIC.source();
        match (self.group.mode, source) {
            (Mode::Lockstep, Some(source)) => {
                let due = self.group.timetable.latest_release(source, self.step);
                topic.await_step(due, self.step, &self.link.end, patience)?;
            }
            _ => topic.drain(u64::MAX, |_| {})?,
        }
        let now_ns = self.clock.now_ns();
        if let Some(source) = source {
            topic.note_silence(now_ns, self.group.timetable.period_ns(source));
        }
        if self.faults.in_use()
            && let Some(drive) = topic.newest().and_then(Message::drive)
        {
            self.faults.observe(&drive, now_ns);
        }
        Ok(())
    }

    /// Sends the heartbeat when it is due; called once at the end of every cycle.
    ///
    /// # Errors
    /// [`RuntimeError::Send`].
    pub fn end_cycle(&mut self, state: ServiceState) -> Result<(), RuntimeError> {
        if let Some(mut drive) = self.drive.take() {
            self.update(&mut drive)?;
            self.drive = Some(drive);
        }
        let scheduled_ns = self.clock.scheduled_ns(self.step);
        let period_ns = self.group.timetable.period_ns(self.service);
        let cycles = self.cycles;
        let heartbeat = self.heartbeat.as_mut().expect("`begin` opened the heartbeat");
        // Due once in every heartbeat period, or in every cycle if the service's own is longer.
        if scheduled_ns % HEARTBEAT_NS < period_ns {
            let header = Header::new(self.step, scheduled_ns, Origins::NONE);
            heartbeat.send_with(|message| {
                message.header = header;
                message.cycles = cycles;
                message.state = state as u64;
            })?;
        }
        if let Some(account) = &self.account {
            account.show_progress(cycles);
            if !self.gate.is_standby() {
                let (cycles, skipped) = self.counted();
                account.write(cycles, skipped, &self.sent, &self.received);
            }
        }
        Ok(())
    }

    /// Cycles and skipped releases that count: those of the active process.
    fn counted(&self) -> (u64, u64) {
        (self.cycles - self.silent.0, self.skipped - self.silent.1)
    }

    /// Ends the run for the whole group after the current step: for the plant's referee.
    ///
    /// # Errors
    /// [`RuntimeError::Link`].
    pub fn end_run(&mut self) -> Result<(), RuntimeError> {
        self.link.end.set_before(self.step + 1);
        self.link.say(FromService::Ended(self.step))
    }

    /// Reports to the launcher and keeps all ports open until it has heard all services, so that
    /// no last message is lost with its sender.
    ///
    /// # Errors
    /// [`RuntimeError::Link`].
    pub fn finish(self, details: Details) -> Result<(), RuntimeError> {
        let (cycles, skipped) = self.counted();
        let report = ServiceReport {
            allocations_in_loop: self.allocations_in_loop,
            service: self.service,
            cycles,
            skipped,
            release_jitter_us: self.jitter.percentiles_us(),
            sent: self.sent.iter().map(|(topic, tally)| tally.borrow().sent(*topic)).collect(),
            received: (self.received.iter())
                .map(|(topic, tally)| tally.borrow().received(*topic))
                .collect(),
            peak_rss_kib: (self.carrier() == Carrier::SharedMemory).then(peak_rss_kib),
            scheduling: self.granted.expect("`begin` comes before `finish`"),
            fault_statistics: self.faults.statistics(),
            details,
        };
        self.link.say(FromService::Report(Box::new(report)))?;
        self.link.wait_for_the_end();
        Ok(())
    }

    /// Runs cycles until one says that the run is over, or it is.
    ///
    /// # Errors
    /// What a cycle says, but for [`RuntimeError::Stopped`], which is an end like any other.
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
        self.allocations_in_loop = allocations().zip(before).map(|(after, before)| after - before);
        result
    }

    /// The clock.
    #[must_use]
    pub fn clock(&self) -> &Clock {
        &self.clock
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

/// Peak resident set of this process, KiB; 0 where the kernel does not tell.
fn peak_rss_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

/// Sends warnings to standard error; once in a process. Those of iceoryx2, which are about its own
/// objects, only where the environment sets `TIMEGAP_LOG`.
pub fn log_warnings() {
    let library = match std::env::var_os("TIMEGAP_LOG") {
        Some(_) => LevelFilter::WARN,
        None => LevelFilter::OFF,
    };
    let filter = Targets::new().with_default(LevelFilter::WARN).with_target("iceoryx2", library);
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .without_time()
        .with_ansi(false)
        .with_target(false);
    tracing_subscriber::registry().with(lines.with_filter(filter)).init();
}

/// A service process from its start to its exit status. `arguments` are the run's root and the
/// incarnation.
pub fn run_service(
    service: Service,
    arguments: &[String],
    run: impl FnOnce(Runtime) -> Result<(), RuntimeError>,
) -> ExitCode {
    let (root, incarnation) = match arguments {
        [root, incarnation] if incarnation.parse::<u32>().is_ok() => (root, incarnation),
        _ => {
            eprintln!("{service} is a service of timegap: start it with `timegap run`");
            return ExitCode::from(2);
        }
    };
    let incarnation = incarnation.parse().expect("checked above");
    log_warnings();
    match Runtime::join(service, Path::new(root), incarnation).and_then(run) {
        Ok(()) | Err(RuntimeError::Stopped) => ExitCode::SUCCESS,
        // No orderly end of the service: the launcher may see it before it hears of the take-over.
        Err(RuntimeError::Replaced) => ExitCode::from(REPLACED),
        Err(error) => {
            if std::env::var_os("TIMEGAP_LOG").is_some() {
                eprintln!("{error:?}");
            }
            let line = serde_json::to_string(&FromService::Failed(error.to_string()));
            println!("{}", line.expect("a string is plain data"));
            ExitCode::FAILURE
        }
    }
}
