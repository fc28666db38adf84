//! From the first spawn to the last wipe.

use super::control;
use super::drive_log::DriveLog;
use super::events::{Event, Who, follow_signals};
use super::faults::Faults;
use super::launch::{GroupOutcome, Launch, Moment, for_services};
use super::life;
use super::live_file::LiveFile;
use super::member::Member;
use super::processes::Janitor;
use super::programs::programs;
use super::recording::{RecorderProcess, law_names};
use super::refusal::{check_processes, check_recorder};
use super::room::check_room;
use super::root::RunRoot;
use super::succession::Phase;
use crate::Error;
use messages::Service;
use runtime::report::ServiceReport;
use runtime::scheduling::{Granted, Priority};
use runtime::{
    Carrier, Group, Injected, Mode, Program, Timetable, ToService, enroll_listener, monotonic_ns,
    shared_memory_bytes,
};
use scenario::runtime::Scheduling;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// Time that services get to go after they reported.
pub(super) const EXIT_GRACE: Duration = Duration::from_secs(2);
/// Priority of the supervisor in realtime: below all services, above all other programs, so that a
/// busy machine does not hold a restart up.
const PRIORITY: u8 = 10;

/// Accounts of processes that are kept one by one.
const MOST_PAST: usize = 16;

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
    let is_replaced = launch.programs.contains_key(&Service::Controller);
    let group = Group {
        root: root.path().to_owned(),
        prefix: root.prefix().to_owned(),
        mode: launch.mode,
        timetable,
        standby,
        patience_ns: 10_000_000_000,
        scenario: for_services(&launch.scenario, is_replaced).to_toml(),
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
    pub(super) programs: BTreeMap<Service, Program>,
}

impl Supervisor<'_> {
    pub(super) fn run(
        &mut self,
        watch: &mut dyn FnMut(&Moment<'_>),
    ) -> Result<GroupOutcome, Error> {
        let spawned = Instant::now();
        self.group.write()?;
        for service in self.launch.scenario.services() {
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
        let log = DriveLog::listen(&self.group, i64::from(deadline_ms) * 1_000_000);
        let log = log.map_err(Error::from).and_then(|log| {
            self.wait_until_ready(spawned)?;
            Ok(log)
        });
        let mut log = log.map_err(|error| self.or_interrupted(error))?;
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
        self.faults.log.count_messages(statistics);
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
            faults: std::mem::take(&mut self.faults.log.records),
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
                life::complete(&mut whole, &self.group, &self.launch.scenario, log);
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

    /// Lets go of everything but the janitor; the threads that send events end.
    fn dissolve(self) -> Janitor {
        self.janitor
    }
}
