//! From the first spawn to the last wipe.

use super::attached::StandbyCost;
use super::control;
use super::drive::{Drive, DriveLog};
use super::events::{Event, Who, follow_signals};
use super::exits::Exit;
use super::faults::{FaultRecord, Faults};
use super::life;
use super::live_file::LiveFile;
use super::member::{Heartbeats, Member};
use super::processes::Janitor;
use super::programs::{is_foreign, programs};
use super::recording::{RecorderProcess, RecordingSummary, law_names};
use super::refusal::{check_processes, check_recorder};
use super::room::check_room;
use super::root::RunRoot;
use super::succession::{self, Phase, Step};
use crate::Error;
use controller::law::Formulation;
use controller::laws;
use messages::Service;
use runtime::report::{Details, Outcome, PlantReport, ServiceReport};
use runtime::scheduling::{Granted, Priority};
use runtime::{
    Carrier, FromService, Group, Injected, Mode, Program, Timetable, ToService, enroll_listener,
    monotonic_ns, shared_memory_bytes,
};
use scenario::Scenario;
use scenario::runtime::Scheduling;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// Time that services get to go after they reported.
pub(super) const EXIT_GRACE: Duration = Duration::from_secs(2);
/// Priority of the supervisor in realtime: below all services, above all other programs, so that a
/// busy machine does not hold a restart up.
const PRIORITY: u8 = 10;

/// Accounts of processes that are kept one by one.
const MOST_PAST: usize = 16;

/// What to launch, and how.
#[derive(Debug)]
pub struct Launch {
    /// Clock.
    pub mode: Mode,
    /// The effective scenario.
    pub scenario: Scenario,
    /// Programs that take the place of built-in services.
    pub programs: BTreeMap<Service, PathBuf>,
    /// Time until all services must be ready.
    pub ready_timeout: Duration,
    /// Time between readiness and the common start instant.
    pub start_delay: Duration,
    /// File that tells others how to join the group, there while it drives.
    pub live_file: Option<PathBuf>,
    /// Where to record the run.
    pub recording: Option<PathBuf>,
}

/// Why a group ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All services reached the end that they were told.
    Orderly,
    /// Ctrl-C, SIGTERM or SIGHUP.
    Interrupted,
    /// A service ended before its time and was not replaced.
    Broken {
        /// The service.
        service: Service,
        /// How.
        how: String,
    },
    /// A service ended too often: the vehicle was ordered to stop in lane.
    GivenUp {
        /// The service.
        service: Service,
        /// How often it had been started again.
        restarts: u32,
    },
}

/// What came out of a group.
#[derive(Debug)]
pub struct GroupOutcome {
    /// What carried the messages.
    pub carrier: Carrier,
    /// Root of the run, which is gone.
    pub root: PathBuf,
    /// Why it ended.
    pub ended: Ended,
    /// What the services reported.
    pub reports: BTreeMap<Service, ServiceReport>,
    /// How the last process of each service ended.
    pub exits: BTreeMap<Service, Exit>,
    /// How often another process took each service's place.
    pub restarts: BTreeMap<Service, u32>,
    /// In how many of these the service's standby took over, of services that have one.
    pub take_overs: BTreeMap<Service, u32>,
    /// What each standby costs that was there at the end.
    pub standby_costs: BTreeMap<Service, StandbyCost>,
    /// Each service's signs of life, in realtime.
    pub heartbeats: BTreeMap<Service, Heartbeats>,
    /// What went wrong.
    pub faults: Vec<FaultRecord>,
    /// What the launcher heard of the drive.
    pub drive: Drive,
    /// From the first spawn until all services were ready.
    pub ready_after: Duration,
    /// From the start instant until all services had reported.
    pub ran_for: Duration,
    /// What became of the recording.
    pub recording: Option<RecordingSummary>,
    /// Lines that services wrote beside their messages: warnings, panics.
    pub wrote: Vec<(Service, String)>,
    /// The programs of the user's that took part, by the service that they are or compute for.
    pub programs: BTreeMap<Service, Program>,
}

impl GroupOutcome {
    /// What the numbers in the diagnostics stand for; none where a program in the controller's place sends
    /// numbers of its own.
    #[must_use]
    pub fn formulation(&self, scenario: &Scenario) -> Option<&'static Formulation> {
        let hosted = laws::program(scenario).is_ok_and(|program| program.is_some());
        let replaced = self.programs.contains_key(&Service::Controller) && !hosted;
        laws::formulation(scenario).filter(|_| !replaced)
    }
}

/// A run at a moment, for its views.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// Run time reached, ns.
    pub time_ns: i64,
    /// What was heard so far.
    pub drive: &'a DriveLog,
    /// What went wrong so far.
    pub faults: &'a [FaultRecord],
}

/// The scenario as the services read it: with the gap that the law aims at, so that the referee can
/// measure against it without knowing any law.
pub(super) fn for_services(scenario: &Scenario) -> Scenario {
    let mut scenario = scenario.clone();
    scenario.referee.desired_gap = laws::desired_gap(&scenario);
    scenario
}

/// Launches a group and stays until nothing of it is left. `watch` is called some ten times a second
/// and more.
///
/// # Errors
/// If the group does not become ready; nothing of it is left then either.
pub fn launch(launch: Launch, watch: &mut dyn FnMut(&Moment<'_>)) -> Result<GroupOutcome, Error> {
    check_processes(launch.mode, &launch.scenario, &launch.programs)?;
    check_recorder(&launch.scenario, launch.recording.is_some())?;
    let programs = programs(&launch.programs, &launch.scenario)?;
    let timetable = Timetable::of(&launch.scenario);
    let standby = launch.scenario.supervision.standby.services();
    check_room(shared_memory_bytes(&timetable, &standby))?;
    let root = RunRoot::create()?;
    let janitor = Janitor::spawn(&root)?;
    let (sender, events) = channel();
    let signals = follow_signals(sender.clone())?;
    control::listen(root.path(), sender.clone())?;
    let group = Group {
        root: root.path().to_owned(),
        prefix: root.prefix().to_owned(),
        mode: launch.mode,
        timetable,
        standby,
        patience_ns: 10_000_000_000,
        scenario: for_services(&launch.scenario).to_toml(),
    };
    let mut supervisor = Supervisor {
        faults: Faults::of(&launch.scenario),
        launch: &launch,
        root: &root,
        janitor,
        group,
        sender,
        events,
        members: Vec::new(),
        start_ns: 0,
        injected: Vec::new(),
        recording: None,
        granted: BTreeMap::new(),
        wrote: Vec::new(),
        programs,
    };
    let outcome = supervisor.run(watch);
    let mut exits = BTreeMap::new();
    supervisor.order_all(&ToService::Abort);
    for member in &mut supervisor.members {
        exits.insert(member.service(), member.end(EXIT_GRACE));
    }
    let janitor = supervisor.dissolve();
    signals.close();
    control::close(root.path());
    root.remove();
    janitor.dismiss();
    outcome.map(|outcome| GroupOutcome { exits, ..outcome })
}

/// Adds what only the processes themselves could have told, of those that could not.
fn complete(whole: &mut ServiceReport, group: &Group, scenario: &Scenario, log: &DriveLog) {
    whole.release_jitter_us =
        life::release_jitter_us(group, whole.service).or(whole.release_jitter_us);
    match (whole.service, &whole.details) {
        (Service::Controller, details) => {
            let last = match details {
                Details::Controller(last) => Some(&**last),
                _ => None,
            };
            let report = life::of_controller(group, scenario, log, last);
            // A program of the user's keeps no account; its cycles were heard.
            whole.cycles = whole.cycles.max(log.history().count);
            whole.details = Details::Controller(Box::new(report));
        }
        (Service::Plant, Details::None) => {
            let report = plant::last_known(group).unwrap_or_else(|| PlantReport {
                duration_s: log.reached_s(),
                control: log.figures(),
                ..PlantReport::empty(Outcome::Aborted)
            });
            whole.details = Details::Plant(Box::new(report));
        }
        (Service::Aebs, _) => {
            let report = aebs::last_known(group, scenario, whole.skipped);
            whole.details = Details::Aebs(Box::new(report));
        }
        (Service::Obu, Details::None) => {
            if let Some(report) = obu::last_known(group) {
                whole.details = Details::Obu(Box::new(report));
            }
        }
        _ => {}
    }
}

/// The group while it lives.
pub(super) struct Supervisor<'a> {
    pub(super) launch: &'a Launch,
    pub(super) root: &'a RunRoot,
    pub(super) janitor: Janitor,
    pub(super) group: Group,
    pub(super) sender: Sender<Event>,
    pub(super) events: Receiver<Event>,
    pub(super) members: Vec<Member>,
    /// Run time 0, `CLOCK_MONOTONIC` ns.
    pub(super) start_ns: i64,
    pub(super) faults: Faults,
    /// Message faults that came during the run, for those who join later.
    pub(super) injected: Vec<Injected>,
    pub(super) recording: Option<RecorderProcess>,
    pub(super) granted: BTreeMap<String, Granted>,
    pub(super) wrote: Vec<(Service, String)>,
    programs: BTreeMap<Service, Program>,
}

impl Supervisor<'_> {
    fn run(&mut self, watch: &mut dyn FnMut(&Moment<'_>)) -> Result<GroupOutcome, Error> {
        let spawned = Instant::now();
        self.group.write()?;
        for &service in self.launch.scenario.services() {
            // The first one leads the services' process group.
            let leader = self.leader();
            let program = self.launch.programs.get(&service).cloned();
            let sender = self.sender.clone();
            let policy = &self.launch.scenario.supervision;
            let who = (service, policy.standby.contains(service));
            let member = Member::start(who, program, policy, self.root, leader, &sender)?;
            if leader == 0 {
                self.janitor.watch(member.group());
            }
            self.members.push(member);
        }
        self.recording = (self.launch.recording.as_deref())
            .map(|path| RecorderProcess::spawn(path, self.root, self.leader()));
        let deadline_ms = self.launch.scenario.controller.deadline().value();
        enroll_listener(self.root.path(), std::process::id())?;
        let mut log = DriveLog::listen(&self.group, i64::from(deadline_ms) * 1_000_000)?;
        self.wait_until_ready(spawned)?;
        let ready_after = spawned.elapsed();
        // A receiver that has not looked yet is not connected, and a full buffer of one that is not
        // connected loses messages instead of holding their sender up.
        log.drain()?;
        if let Some(recording) = &mut self.recording {
            recording.connect();
        }

        let delay =
            i64::try_from(self.launch.start_delay.as_nanos()).expect("start delays are short");
        self.start_ns = monotonic_ns() + delay;
        if let Some(recording) = &mut self.recording {
            let law = law_names(&self.launch.scenario);
            recording.begin(self.start_ns, self.granted.clone(), &self.programs, law);
        }
        self.begin_all();
        let live_file = self.launch.live_file.as_deref();
        let scenario = &self.launch.scenario;
        let _live =
            live_file.map(|path| LiveFile::write(path, &self.group, scenario, self.start_ns));
        let fifo = self.launch.scenario.runtime.scheduling == Scheduling::Fifo;
        let priority =
            (self.launch.mode == Mode::Realtime && fifo).then(|| Priority::raise(PRIORITY));
        if priority.is_some() {
            // Those of processes that are started later inherit it.
            let processes = self.members.iter_mut().flat_map(Member::processes);
            processes.for_each(|process| process.raise_follower(PRIORITY));
        }
        let ended = self.follow_run(&mut log, watch)?;
        drop(priority);
        let ran_ns = (monotonic_ns() - self.start_ns).max(0);
        let reports = self.reports(&log);
        let statistics =
            reports.values().flat_map(|report| report.fault_statistics.iter().copied());
        self.faults.count_messages(statistics);
        Ok(GroupOutcome {
            carrier: Carrier::SharedMemory,
            root: self.root.path().to_owned(),
            ended,
            reports,
            exits: BTreeMap::new(),
            restarts: (self.members.iter())
                .map(|member| (member.service(), member.succession().replacements()))
                .collect(),
            take_overs: (self.members.iter())
                .filter(|member| self.group.standby.contains(&member.service()))
                .map(|member| (member.service(), member.succession().take_overs()))
                .collect(),
            standby_costs: (self.members.iter())
                .filter_map(|member| Some((member.service(), member.standby_cost(ran_ns)?)))
                .collect(),
            heartbeats: (self.members.iter())
                .filter(|_| self.launch.mode == Mode::Realtime)
                .map(|member| (member.service(), member.heartbeats))
                .collect(),
            faults: std::mem::take(&mut self.faults.records),
            drive: log.finish()?,
            ready_after,
            ran_for: Duration::from_nanos(ran_ns.unsigned_abs()),
            recording: self.recording.take().map(RecorderProcess::finish),
            wrote: std::mem::take(&mut self.wrote),
            programs: self.programs.clone(),
        })
    }

    /// What all processes of each service told, or left.
    fn reports(&mut self, log: &DriveLog) -> BTreeMap<Service, ServiceReport> {
        let mut reports = BTreeMap::new();
        for member in &mut self.members {
            let mut lives = std::mem::take(&mut member.past);
            let was_restarted = !lives.is_empty() || member.report.is_none();
            lives.extend(member.report.take());
            let service = member.service();
            let Some(mut whole) = life::whole(lives) else { continue };
            if was_restarted {
                complete(&mut whole, &self.group, &self.launch.scenario, log);
            }
            reports.insert(service, whole);
        }
        reports
    }

    /// Keeps what a process that is gone had counted, unless it told that itself.
    pub(super) fn keep_account(&mut self, who: Who, has_told: bool) {
        let Some(granted) = self.granted.get(who.service.name()).cloned() else { return };
        let left = life::left_by(&self.group, who.service, who.incarnation, granted);
        if !has_told {
            let past = &mut self.member(who.service).past;
            past.push(left);
            // A long run with many deaths does not keep each.
            if past.len() > MOST_PAST {
                *past = life::whole(std::mem::take(past)).into_iter().collect();
            }
        }
    }

    /// Gives all processes, which are ready, the common start.
    fn begin_all(&mut self) {
        for &service in self.launch.scenario.services() {
            let member = self.member(service);
            let mut steps = member.on(succession::Event::Ready(0), 0);
            steps.extend(member.on(succession::Event::Ready(1), 0));
            for step in steps {
                match step {
                    Step::Activate(incarnation) => self.begin(service, incarnation, None, 0),
                    Step::StandBy { incarnation, active } => {
                        self.begin(service, incarnation, Some(active), 0);
                    }
                    _ => unreachable!("nothing has ended yet"),
                }
            }
        }
    }

    fn wait_until_ready(&mut self, spawned: Instant) -> Result<(), Error> {
        let processes = |&service: &Service| {
            let of = self.group.standby.contains(&service);
            (0..=u32::from(of)).map(move |incarnation| Who { service, incarnation })
        };
        let mut waiting: Vec<Who> =
            self.launch.scenario.services().iter().flat_map(processes).collect();
        while let Some(first) = waiting.first().map(|who| who.service) {
            let left = self.launch.ready_timeout.saturating_sub(spawned.elapsed());
            if left.is_zero() {
                let timeout = self.launch.ready_timeout.as_secs_f64();
                return Err(self.not_ready(first, format!("was not ready within {timeout} s")));
            }
            match self.events.recv_timeout(left) {
                Ok(Event::Said(who, FromService::Ready(granted))) => {
                    waiting.retain(|waiting| *waiting != who);
                    self.granted.insert(who.service.name().into(), granted);
                }
                Ok(Event::Said(who, FromService::Failed(reason))) => {
                    return Err(self.not_ready(who.service, format!("failed: {reason}")));
                }
                Ok(Event::Flooded(who)) => {
                    let what = "wrote endless text instead of messages: it is no service".into();
                    return Err(self.not_ready(who.service, what));
                }
                Ok(Event::Gone(Who { service, incarnation })) => {
                    let process = self.member(service).attached(incarnation);
                    let process = process.expect("it has just been started");
                    let exit = process.exit(EXIT_GRACE, Exit::OutputClosed);
                    let what = format!("ended before it was ready ({exit})");
                    let what = what + &self.last_words(service);
                    return Err(self.not_ready(service, what));
                }
                Ok(Event::Signal) => return Err(Error::Interrupted),
                Ok(Event::Wrote(who, line)) => self.wrote.push((who.service, line)),
                Ok(Event::Inject(_, reply)) => {
                    let message = "the run has not begun".into();
                    // The client may be gone.
                    let _ = reply.send(control::Answer { ok: false, message });
                }
                // The timeout is looked at above.
                Ok(Event::Said(..) | Event::Knock) | Err(_) => {}
            }
        }
        Ok(())
    }

    fn not_ready(&mut self, service: Service, what: String) -> Error {
        let foreign = is_foreign(&self.programs, service);
        Error::NotReady { service, what, foreign }
    }

    pub(super) fn member(&mut self, service: Service) -> &mut Member {
        let member = self.members.iter_mut().find(|member| member.service() == service);
        member.expect("all services have been started")
    }

    pub(super) fn order_all(&mut self, order: &ToService) {
        for member in &mut self.members {
            member.order(order);
        }
    }

    /// Starts process `incarnation` of `service`.
    pub(super) fn start_next(&mut self, service: Service, incarnation: u32) -> Result<(), Error> {
        let leader = self.living_group();
        let (root, sender) = (self.root, self.sender.clone());
        let member = self.member(service);
        member.spawn(incarnation, root, leader, &sender)?;
        if leader == 0 {
            let group = member.group();
            self.janitor.watch(group);
        }
        Ok(())
    }

    /// The services' process group; 0 when there is none.
    pub(super) fn leader(&self) -> i32 {
        self.members.first().map_or(0, Member::group)
    }

    /// The process group of the processes that live; 0 when there is none.
    pub(super) fn living_group(&mut self) -> i32 {
        let living = self.members.iter_mut().find_map(|member| {
            (member.phase() != Phase::GivenUp && member.lives()).then(|| member.group())
        });
        living.unwrap_or(0)
    }

    fn last_words(&self, service: Service) -> String {
        let words: Vec<_> = self.wrote.iter().filter(|(who, _)| *who == service).collect();
        words.iter().rev().take(3).rev().map(|(_, line)| format!("\n  {line}")).collect()
    }

    /// Lets go of everything but the janitor; the threads that send events end.
    fn dissolve(self) -> Janitor {
        self.janitor
    }
}
