//! From the first spawn to the last wipe.

mod injection;
mod readiness;
mod replacement;
pub mod roster;
mod watch;

use crate::events::{Who, follow_signals};
use crate::faults::Faults;
use crate::member::{Member, life};
use crate::recording::{Listener, law_names};
use crate::refusal::{check_processes, check_recorder};
use crate::root::RunRoot;
use crate::root::check_room;
use crate::start::attendant::BRIDGE;
use crate::start::live_file::LiveFile;
use crate::start::processes::{Launch, for_services};
use crate::start::programs;
use crate::{Error, control};
use drive::log::DriveLog;
use drive::report::ServiceReport;
use drive::{GroupOutcome, Moment};
use messages::Service;
use recorder::Start;
use roster::Roster;
use runtime::scheduling::Priority;
use runtime::{
    Carrier, Mode, Program, Timetable, enroll_listener, monotonic_ns, shared_memory_bytes,
};
use scenario::runtime::Scheduling;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// Time that services get to go after they reported.
const EXIT_GRACE: Duration = Duration::from_secs(2);
/// Priority of the supervisor in realtime: below all services and above all other programs. So a
/// busy machine does not delay a restart.
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
    let standby: Vec<Service> = launch.scenario.supervision.standby.iter().copied().collect();
    check_room(shared_memory_bytes(&timetable, &standby))?;
    let root = RunRoot::create()?;
    let (sender, events) = channel();
    let signals = follow_signals(sender.clone())?;
    control::listen(root.path(), sender.clone())?;
    let is_replaced = launch.programs.contains_key(&Service::Controller);
    let scenario = for_services(&launch.scenario, is_replaced).to_toml();
    let group = root.group(launch.mode, timetable, standby, scenario);
    let mut supervisor = Supervisor {
        launch: &launch,
        programs,
        roster: Roster::new(&root, group, (sender, events))?,
        faults: Faults::of(&launch.scenario),
        recording: None,
        bridge: None,
    };
    let outcome = supervisor.run(watch);
    let exits = supervisor.roster.end_all(EXIT_GRACE);
    // A run that did not start has them still: one that is about to begin would make the root anew.
    (supervisor.recording, supervisor.bridge) = (None, None);
    // The threads that send events end.
    let janitor = supervisor.roster.dissolve();
    signals.close();
    control::close(root.path());
    root.remove();
    janitor.dismiss();
    outcome.map(|outcome| GroupOutcome { exits: exits.into_iter().collect(), ..outcome })
}

/// A running group: what was asked for, its processes, and what happened to them.
struct Supervisor<'a> {
    launch: &'a Launch,
    programs: BTreeMap<Service, Program>,
    roster: Roster<'a>,
    faults: Faults,
    recording: Option<Listener>,
    bridge: Option<Listener>,
}

impl Supervisor<'_> {
    fn run(&mut self, watch: &mut dyn FnMut(&Moment<'_>)) -> Result<GroupOutcome, Error> {
        let spawned = Instant::now();
        self.roster.group.write()?;
        let policy = &self.launch.scenario.supervision;
        for service in self.launch.scenario.services() {
            let program = self.launch.programs.get(&service).cloned();
            let standby = policy.standby.contains(&service);
            self.roster.start(service, program, (policy, policy.restart_of(service), standby))?;
        }
        let (root, leader) = (self.roster.root, self.roster.leader());
        let listener = |name| move |target: OsString| Listener::spawn(name, target, root, leader);
        let Launch { recording, bridge, .. } = self.launch;
        self.recording = recording.clone().map(OsString::from).map(listener("recorder"));
        self.bridge = bridge.clone().map(listener(BRIDGE));
        let deadline_ms = self.launch.scenario.controller.deadline().value();
        enroll_listener(root.prefix(), std::process::id())?;
        let deadline_ns = i64::from(deadline_ms) * 1_000_000;
        let log = DriveLog::listen(&self.roster.group, &self.launch.scenario, deadline_ns);
        let log = log.map_err(Error::from).and_then(|log| {
            self.wait_until_ready(spawned)?;
            Ok(log)
        });
        let mut log = log.map_err(|error| self.or_interrupted(error))?;
        let ready_after = spawned.elapsed();
        // A receiver connects at its first look. Before that, a full buffer loses messages instead of holding their
        // sender up.
        log.drain()?;
        self.recording.iter_mut().chain(&mut self.bridge).try_for_each(Listener::connect)?;

        let delay =
            i64::try_from(self.launch.start_delay.as_nanos()).expect("start delays are short");
        let start_ns = monotonic_ns() + delay;
        let programs = self.programs.iter();
        let start = Start {
            start_ns,
            scheduling: self.roster.granted.clone(),
            programs: programs.map(|(of, program)| (of.name().into(), program.clone())).collect(),
            law: law_names(&self.launch.scenario),
        };
        self.recording.iter_mut().chain(&mut self.bridge).for_each(|one| one.begin(&start));
        self.roster.begin_all(start_ns);
        let live_file = self.launch.live_file.as_deref();
        let scenario = &self.launch.scenario;
        let _live =
            live_file.map(|path| LiveFile::write(path, &self.roster.group, scenario, start_ns));
        let fifo = self.launch.scenario.runtime.scheduling == Scheduling::Fifo;
        let priority =
            (self.launch.mode == Mode::Realtime && fifo).then(|| Priority::raise(PRIORITY));
        if priority.is_some() {
            // Those of processes that are started later inherit it.
            let processes = self.roster.iter_mut().flat_map(Member::processes);
            processes.for_each(|process| process.raise_followers(PRIORITY));
        }
        let ended = self.follow_run(&mut log, watch)?;
        drop(priority);
        if let Some(bridge) = self.bridge.take() {
            bridge.dismiss();
        }
        let ran_ns = self.roster.now_ns().max(0);
        let reports = self.reports(&log);
        let statistics =
            reports.values().flat_map(|report| report.fault_statistics.iter().copied());
        self.faults.log.count_messages(statistics);
        Ok(GroupOutcome {
            carrier: Carrier::SharedMemory,
            root: self.roster.root.path().to_owned(),
            ended,
            reports,
            exits: BTreeMap::new(),
            restarts: (self.roster.iter())
                .map(|member| (member.role, member.succession.replacements()))
                .collect(),
            take_overs: (self.roster.iter())
                .filter(|member| self.roster.group.standby.contains(&member.role))
                .map(|member| (member.role, member.succession.take_overs()))
                .collect(),
            standby_costs: (self.roster.iter())
                .filter_map(|member| Some((member.role, member.standby_cost(ran_ns)?)))
                .collect(),
            heartbeats: (self.roster.iter())
                .filter(|_| self.launch.mode == Mode::Realtime)
                .map(|member| (member.role, member.heartbeats))
                .collect(),
            faults: std::mem::take(&mut self.faults.log.records),
            drive: log.finish()?,
            ready_after,
            ran_for: Duration::from_nanos(ran_ns.unsigned_abs()),
            recording: self.recording.take().map(Listener::finish),
            wrote: std::mem::take(&mut self.roster.wrote),
            programs: self.programs.clone(),
        })
    }

    /// Reports of all processes of each service, or their remains.
    fn reports(&mut self, log: &DriveLog) -> BTreeMap<Service, ServiceReport> {
        let mut reports = BTreeMap::new();
        for service in self.launch.scenario.services() {
            let member = self.roster.of(service);
            let mut lives = std::mem::take(&mut member.past);
            let was_restarted = !lives.is_empty() || member.report.is_none();
            lives.extend(member.report.take());
            let Some(mut whole) = life::whole(lives) else { continue };
            if was_restarted {
                life::complete(&mut whole, &self.roster.group, &self.launch.scenario, log);
            }
            reports.insert(service, whole);
        }
        reports
    }

    /// Keeps the counts of a process that is gone, unless it reported them itself.
    fn keep_account(&mut self, who: Who, has_told: bool) {
        let Some(granted) = self.roster.granted.get(who.role.name()).cloned() else { return };
        let left = life::left_by(&self.roster.group, who.role, who.incarnation, granted);
        if !has_told {
            let past = &mut self.roster.of(who.role).past;
            past.push(left);
            // A long run with many deaths does not keep each.
            if past.len() > MOST_PAST {
                *past = life::whole(std::mem::take(past)).into_iter().collect();
            }
        }
    }
}
