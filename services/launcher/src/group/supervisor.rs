//! From the first spawn to the last wipe.

use super::drive::{Drive, DriveLog};
use super::events::{Event, follow_signals};
use super::processes::{Janitor, Process, describe};
use super::recording::{RecorderProcess, RecordingSummary};
use super::root::{RunRoot, check_room};
use crate::error::Error;
use shared::Service;
use shared::report::ServiceReport;
use shared::runtime::scheduling::Granted;
use shared::runtime::{
    FromService, Group, Mode, StartOrder, Timetable, ToService, monotonic_ns, shared_memory_bytes,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Time that services get to report after the run's scheduled end or an order to stop.
const REPORT_GRACE: Duration = Duration::from_secs(3);
/// Time that services get to go after they reported.
const EXIT_GRACE: Duration = Duration::from_secs(2);

/// What to launch, and how.
#[derive(Debug)]
pub struct Launch {
    /// Clock.
    pub mode: Mode,
    /// Periods and length of the run.
    pub timetable: Timetable,
    /// The effective scenario, TOML.
    pub scenario: String,
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
    /// A service ended before its time.
    Broken {
        /// The service.
        service: Service,
        /// How.
        how: String,
    },
}

/// What came out of a group.
#[derive(Debug)]
pub struct GroupOutcome {
    /// Why it ended.
    pub ended: Ended,
    /// What the services reported.
    pub reports: BTreeMap<Service, ServiceReport>,
    /// How the processes ended.
    pub exits: BTreeMap<Service, String>,
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
}

/// Launches a group and stays until nothing of it is left. `progress` is told the run time reached,
/// in ns.
///
/// # Errors
/// If the group does not become ready; nothing of it is left then either.
pub fn launch(launch: Launch, progress: &mut dyn FnMut(i64)) -> Result<GroupOutcome, Error> {
    check_room(shared_memory_bytes(&launch.timetable))?;
    let root = RunRoot::create()?;
    let mut janitor = Janitor::spawn(&root)?;
    let (sender, events) = channel();
    let signals = follow_signals(sender.clone())
        .map_err(|e| Error::Machine(format!("cannot handle signals: {e}")))?;
    let group = Group {
        root: root.path().to_owned(),
        prefix: root.prefix().to_owned(),
        mode: launch.mode,
        timetable: launch.timetable,
        patience_ns: 10_000_000_000,
        scenario: launch.scenario.clone(),
    };
    let mut supervisor = Supervisor {
        launch: &launch,
        group,
        events,
        processes: Vec::new(),
        recording: None,
        granted: BTreeMap::new(),
        reports: BTreeMap::new(),
        wrote: Vec::new(),
    };
    let outcome = supervisor.run(&root, &mut janitor, sender, progress);
    for process in &mut supervisor.processes {
        process.order(&ToService::Abort);
    }
    let exits = (supervisor.processes.iter_mut())
        .map(|process| (process.service(), describe(process.end(EXIT_GRACE))))
        .collect();
    drop(supervisor);
    signals.close();
    root.remove();
    janitor.dismiss();
    outcome.map(|outcome| GroupOutcome { exits, ..outcome })
}

/// A copy of the group file where the user looks for it, for as long as this lives.
struct LiveFile<'a>(&'a Path);

impl<'a> LiveFile<'a> {
    fn write(path: &'a Path, group: &Group) -> Self {
        let text = serde_json::to_string_pretty(group).expect("a group is plain data");
        if let Err(error) = std::fs::write(path, text) {
            tracing::warn!("cannot write {}: {error}", path.display());
        }
        Self(path)
    }
}

impl Drop for LiveFile<'_> {
    fn drop(&mut self) {
        // It may never have been written.
        let _ = std::fs::remove_file(self.0);
    }
}

struct Supervisor<'a> {
    launch: &'a Launch,
    group: Group,
    events: Receiver<Event>,
    processes: Vec<Process>,
    recording: Option<RecorderProcess>,
    granted: BTreeMap<String, Granted>,
    reports: BTreeMap<Service, ServiceReport>,
    wrote: Vec<(Service, String)>,
}

impl Supervisor<'_> {
    fn run(
        &mut self,
        root: &RunRoot,
        janitor: &mut Janitor,
        sender: Sender<Event>,
        progress: &mut dyn FnMut(i64),
    ) -> Result<GroupOutcome, Error> {
        let spawned = Instant::now();
        self.group.write()?;
        for service in Service::ALL {
            // The first one leads the services' process group.
            let leader = self.processes.first().map_or(0, Process::pid);
            let program = self.launch.programs.get(&service);
            let process = Process::spawn((service, 0), program, root, leader, sender.clone())?;
            if leader == 0 {
                janitor.watch(process.pid());
            }
            self.processes.push(process);
        }
        let leader = self.processes.first().map_or(0, Process::pid);
        self.recording = (self.launch.recording.as_deref())
            .map(|path| RecorderProcess::spawn(path, root, leader));
        drop(sender);
        let mut log = DriveLog::listen(&self.group)?;
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
        let start_ns = monotonic_ns() + delay;
        if let Some(recording) = &mut self.recording {
            recording.begin(start_ns, std::mem::take(&mut self.granted));
        }
        self.order_all(&ToService::Start(StartOrder { start_ns }));
        let _live = self.launch.live_file.as_deref().map(|path| LiveFile::write(path, &self.group));
        let ended = self.follow_run(start_ns, &mut log, progress)?;
        let ran_ns = (monotonic_ns() - start_ns).max(0);
        Ok(GroupOutcome {
            ended,
            reports: std::mem::take(&mut self.reports),
            exits: BTreeMap::new(),
            drive: log.finish()?,
            ready_after,
            ran_for: Duration::from_nanos(ran_ns.unsigned_abs()),
            recording: self.recording.take().map(RecorderProcess::finish),
            wrote: std::mem::take(&mut self.wrote),
        })
    }

    fn wait_until_ready(&mut self, spawned: Instant) -> Result<(), Error> {
        let mut waiting: Vec<Service> = Service::ALL.to_vec();
        while let Some(&first) = waiting.first() {
            let left = self.launch.ready_timeout.saturating_sub(spawned.elapsed());
            match self.events.recv_timeout(left) {
                Ok(Event::Said(service, FromService::Ready(granted))) => {
                    waiting.retain(|s| *s != service);
                    self.granted.insert(service.name().into(), granted);
                }
                Ok(Event::Said(service, FromService::Failed(reason))) => {
                    return Err(Error::NotReady { service, what: format!("failed: {reason}") });
                }
                Ok(Event::Gone(service)) => {
                    let what = format!("ended before it was ready ({})", self.how(service));
                    return Err(Error::NotReady {
                        service,
                        what: what + &self.last_words(service),
                    });
                }
                Ok(Event::Signal) => return Err(Error::Interrupted),
                Ok(Event::Wrote(service, line)) => self.wrote.push((service, line)),
                Ok(Event::Said(..)) => {}
                Err(_) => {
                    let timeout = self.launch.ready_timeout.as_secs_f64();
                    let what = format!("was not ready within {timeout} s");
                    return Err(Error::NotReady { service: first, what });
                }
            }
        }
        Ok(())
    }

    /// Follows the run until all services reported or the run is broken.
    fn follow_run(
        &mut self,
        start_ns: i64,
        log: &mut DriveLog,
        progress: &mut dyn FnMut(i64),
    ) -> Result<Ended, Error> {
        let realtime = self.launch.mode == Mode::Realtime;
        // In lockstep the launcher's own buffer must not hold anybody up.
        let poll = Duration::from_millis(if realtime { 20 } else { 2 });
        let table = self.launch.timetable;
        let length_ns = table.step_ns * i64::try_from(table.last_step).expect("runs are finite");
        let mut deadline = realtime
            .then(|| Instant::now() + Duration::from_nanos(length_ns.unsigned_abs()))
            .map(|end| end + self.launch.start_delay + REPORT_GRACE);
        let mut ended = Ended::Orderly;
        while self.reports.len() < self.processes.len() {
            let event = self.events.recv_timeout(poll);
            log.drain()?;
            if self.recording.as_mut().is_some_and(RecorderProcess::has_died) {
                log.remove_dead();
            }
            if realtime {
                progress((monotonic_ns() - start_ns).clamp(0, length_ns));
            } else {
                progress(table.step_ns * i64::try_from(log.reached()).expect("runs are finite"));
            }
            let broken = match event {
                Ok(Event::Said(service, FromService::Report(report))) => {
                    self.reports.insert(service, *report);
                    None
                }
                Ok(Event::Said(_, FromService::Ended(step))) => {
                    self.order_all(&ToService::StopAfter(step));
                    deadline = Some(Instant::now() + REPORT_GRACE);
                    None
                }
                Ok(Event::Said(service, FromService::Failed(how))) => Some((service, how)),
                Ok(Event::Gone(service)) if !self.reports.contains_key(&service) => {
                    Some((service, self.how(service)))
                }
                Ok(Event::Signal) if ended == Ended::Orderly => {
                    ended = Ended::Interrupted;
                    self.order_all(&ToService::Abort);
                    deadline = Some(Instant::now() + REPORT_GRACE);
                    None
                }
                Ok(Event::Wrote(service, line)) => {
                    self.wrote.push((service, line));
                    None
                }
                Ok(Event::Said(..) | Event::Gone(_) | Event::Signal)
                | Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Ok(ended),
            };
            if let Some((service, how)) = broken
                && ended == Ended::Orderly
            {
                ended = Ended::Broken { service, how };
                self.order_all(&ToService::Abort);
                deadline = Some(Instant::now() + REPORT_GRACE);
            }
            if self.silent().is_none() {
                break;
            }
            if deadline.is_some_and(|deadline| Instant::now() > deadline) {
                if ended == Ended::Orderly
                    && let Some(service) = self.silent()
                {
                    ended = Ended::Broken { service, how: "does not answer".into() };
                }
                break;
            }
        }
        if ended == Ended::Orderly
            && let Some(service) = self.unreported()
        {
            ended = Ended::Broken { service, how: self.how(service) };
        }
        Ok(ended)
    }

    /// A living service that has not reported.
    fn silent(&mut self) -> Option<Service> {
        let reports = &self.reports;
        let processes = self.processes.iter_mut();
        processes
            .filter(|process| !reports.contains_key(&process.service()))
            .find_map(|process| process.poll().is_none().then_some(process.service()))
    }

    fn unreported(&self) -> Option<Service> {
        Service::ALL.into_iter().find(|service| !self.reports.contains_key(service))
    }

    fn order_all(&mut self, order: &ToService) {
        for process in &mut self.processes {
            process.order(order);
        }
    }

    /// How the process of `service` ended; its output has.
    fn how(&mut self, service: Service) -> String {
        let process = self.processes.iter_mut().find(|process| process.service() == service);
        process.map_or_else(String::new, |process| describe(process.end(EXIT_GRACE)))
    }

    fn last_words(&self, service: Service) -> String {
        let words: Vec<_> = self.wrote.iter().filter(|(who, _)| *who == service).collect();
        words.iter().rev().take(3).rev().map(|(_, line)| format!("\n  {line}")).collect()
    }
}
