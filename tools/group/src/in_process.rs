//! A lockstep run in the calling thread: the services take turns, and memory carries their messages.
//!
//! The results are those of a group of processes, to the byte; what is left out is the machine between
//! the services: processes, shared memory, files. Faults of processes need processes.

use super::drive_log::DriveLog;
use super::exits::Exit;
use super::faults::Faults;
use super::launch::{Ended, GroupOutcome, Moment, for_services};
use super::programs::{is_foreign, programs};
use super::refusal::check_in_process;
use crate::Error;
use crate::report::{ServiceReport, read};
use messages::Service;
pub use perception_sim::Ahead;
use runtime::{Carrier, Entry, FromService, InProcess, Sealing};
use scenario::Scenario;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Work of `service` in its process, or in its turns.
#[must_use]
pub fn entry(service: Service) -> Entry {
    macro_rules! run_of {
        ($([$service:ident $krate:ident $about:literal])+) => {
            match service {
                $(Service::$service => $krate::run,)+
            }
        };
    }
    messages::each_service!(run_of)
}

/// Runs `scenario` in simulated time, in this thread.
///
/// # Errors
/// A [`Refusal`](crate::Refusal) of faults of processes, [`Error::NotReady`] if a service cannot begin.
pub fn run(scenario: &Scenario) -> Result<GroupOutcome, Error> {
    run_watched(scenario, &|| false, &mut |_| {})
}

/// The same while `watch` sees it go, until `interrupted` says that it is to end.
///
/// # Errors
/// As [`run`].
pub fn run_watched(
    scenario: &Scenario,
    interrupted: &dyn Fn() -> bool,
    watch: &mut dyn FnMut(&Moment<'_>),
) -> Result<GroupOutcome, Error> {
    run_behind(scenario, Sealing::Sealed, Box::new(|_, _| {}), interrupted, watch)
}

/// The same of a run whose messages nothing compares with another run's: their CRCs and digests are not computed,
/// and the summary has no digests. All else is the same.
///
/// # Errors
/// As [`run`].
pub fn run_unsealed(
    scenario: &Scenario,
    interrupted: &dyn Fn() -> bool,
) -> Result<GroupOutcome, Error> {
    run_behind(scenario, Sealing::Unsealed, Box::new(|_, _| {}), interrupted, &mut |_| {})
}

/// Either of them behind a vehicle, the scenario's first, whose table of speeds `ahead` makes longer during
/// the run. The run is to the byte the one with the whole table.
///
/// # Errors
/// As [`run`].
pub fn run_behind(
    scenario: &Scenario,
    sealing: Sealing,
    ahead: Ahead,
    interrupted: &dyn Fn() -> bool,
    watch: &mut dyn FnMut(&Moment<'_>),
) -> Result<GroupOutcome, Error> {
    check_in_process(scenario)?;
    let programs = programs(&BTreeMap::new(), scenario)?;
    let begun = Instant::now();
    let mut run = InProcess::new(scenario, sealing);
    let mut log = DriveLog::in_process(&run)?;
    let told = for_services(scenario, false);
    let mut perception = Some(|runtime| perception_sim::run_behind(runtime, ahead));
    for service in scenario.services() {
        match perception.take_if(|_| service == Service::PerceptionSim) {
            Some(perception) => run.start(service, &told, perception)?,
            None => run.start(service, &told, entry(service))?,
        }
    }
    let mut course = Course::default();
    run.take_turns(&mut |service, said| course.receive(service, said));
    if let Some((service, how)) = course.failed.take() {
        run.abort();
        let what = format!("failed: {how}");
        let foreign = is_foreign(&programs, service);
        return Err(Error::NotReady { service, what, foreign });
    }
    let ready_after = begun.elapsed();
    run.begin();
    let started = Instant::now();
    let mut faults = Faults::of(scenario);
    let step_ns = run.timetable().step_ns;
    loop {
        let alive = run.take_turns(&mut |service, said| course.receive(service, said));
        log.drain()?;
        if !alive {
            break;
        }
        let time_ns = step_ns * i64::try_from(log.reached()).expect("runs are finite");
        watch(&Moment { time_ns, drive: &log, faults: &faults.log.records });
        if let Some(step) = course.stop_after.take() {
            run.stop_after(step);
        }
        if course.failed.is_some() {
            run.abort();
        } else if interrupted() {
            course.interrupted = true;
            run.abort();
        }
    }
    let ran_for = started.elapsed();
    let messages =
        course.reports.values().flat_map(|report| report.fault_statistics.iter().copied());
    faults.log.count_messages(messages);
    let services = scenario.services();
    let exits = services.iter().map(|&service| (service, course.exit_of(service))).collect();
    let wrote = course.failed.iter().cloned().collect();
    Ok(GroupOutcome {
        carrier: Carrier::Memory,
        root: PathBuf::new(),
        ended: match course.failed {
            Some((service, how)) => Ended::Broken { service, how },
            None if course.interrupted => Ended::Interrupted,
            None => Ended::Orderly,
        },
        reports: course.reports,
        exits,
        restarts: services.into_iter().map(|service| (service, 0)).collect(),
        take_overs: BTreeMap::new(),
        standby_costs: BTreeMap::new(),
        heartbeats: BTreeMap::new(),
        faults: faults.log.records,
        drive: log.finish()?,
        ready_after,
        ran_for: ran_for.max(Duration::from_nanos(1)),
        recording: None,
        wrote,
        programs,
    })
}

/// Messages of the services about the run so far.
#[derive(Default)]
struct Course {
    reports: BTreeMap<Service, ServiceReport>,
    /// The first service that could not go on, and why.
    failed: Option<(Service, String)>,
    /// The plant ended the run in this step.
    stop_after: Option<u64>,
    interrupted: bool,
}

impl Course {
    fn receive(&mut self, service: Service, said: FromService) {
        match said {
            FromService::Ready(_) | FromService::TookOver(_) => {}
            FromService::Report(report) => {
                self.reports.insert(service, read(*report));
            }
            FromService::Ended(step) => self.stop_after = Some(step),
            FromService::Failed(how) => {
                self.failed.get_or_insert((service, how));
            }
        }
    }

    /// End that the service's process would have had.
    fn exit_of(&self, service: Service) -> Exit {
        match &self.failed {
            Some((failed, _)) if *failed == service => Exit::Status(1),
            _ => Exit::Ok,
        }
    }
}
