//! Input of a group's launch, and its result.

use super::attached::StandbyCost;
use super::drive::Drive;
use super::drive_log::DriveLog;
use super::exits::Exit;
use super::fault_log::FaultRecord;
use super::member::Heartbeats;
use super::recording::RecordingSummary;
use crate::report::ServiceReport;
use controller::law::Formulation;
use controller::laws;
use messages::Service;
use runtime::{Carrier, Mode, Program};
use scenario::Scenario;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

/// Input of a launch.
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
    /// File that describes to others how to join the group; present while it drives.
    pub live_file: Option<PathBuf>,
    /// File of the run's recording.
    pub recording: Option<PathBuf>,
}

/// Reason why a group ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All services reached the announced end.
    Orderly,
    /// Ctrl-C, SIGTERM or SIGHUP.
    Interrupted,
    /// A service ended before its time and was not replaced.
    Broken {
        /// The service.
        service: Service,
        /// The end.
        how: String,
    },
    /// A service ended too often: the vehicle was ordered to stop in lane.
    GivenUp {
        /// The service.
        service: Service,
        /// Number of its restarts.
        restarts: u32,
    },
}

/// Result of a group.
#[derive(Debug)]
pub struct GroupOutcome {
    /// Carrier of the messages.
    pub carrier: Carrier,
    /// Root of the run, which is gone.
    pub root: PathBuf,
    /// Reason why it ended.
    pub ended: Ended,
    /// Reports of the services.
    pub reports: BTreeMap<Service, ServiceReport>,
    /// End of the last process of each service.
    pub exits: BTreeMap<Service, Exit>,
    /// Number of replacements of each service.
    pub restarts: BTreeMap<Service, u32>,
    /// Number of these in which the service's standby took over, of services that have one.
    pub take_overs: BTreeMap<Service, u32>,
    /// Cost of each standby that was present at the end.
    pub standby_costs: BTreeMap<Service, StandbyCost>,
    /// Each service's signs of life, in realtime.
    pub heartbeats: BTreeMap<Service, Heartbeats>,
    /// The error.
    pub faults: Vec<FaultRecord>,
    /// The drive as the launcher received it.
    pub drive: Drive,
    /// Time from the first spawn until all services were ready.
    pub ready_after: Duration,
    /// Time from the start instant until all services had reported.
    pub ran_for: Duration,
    /// Fate of the recording.
    pub recording: Option<RecordingSummary>,
    /// Lines that services wrote beside their messages: warnings, panics.
    pub wrote: Vec<(Service, String)>,
    /// The programs of the user's that took part, by the service that they are or compute for.
    pub programs: BTreeMap<Service, Program>,
}

impl GroupOutcome {
    /// Meaning of the numbers in the diagnostics; empty if a program in the controller's place sends its own.
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
    /// The drive so far.
    pub drive: &'a DriveLog,
    /// Errors so far.
    pub faults: &'a [FaultRecord],
}

/// The scenario as the services read it. It has the gap at which the law aims. So the referee can measure against it
/// without any law. The aim of a program in the controller's place is known only from the scenario.
pub(super) fn for_services(scenario: &Scenario, is_replaced: bool) -> Scenario {
    let mut scenario = scenario.clone();
    if !is_replaced {
        scenario.referee.desired_gap = laws::desired_gap(&scenario);
    }
    scenario
}
