//! What a run's launcher knows at its end, as plain data.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use controller::law::Formulation;
use controller::laws;
use messages::Service;
use runtime::{Carrier, Program};
use scenario::Scenario;
use scenario::faults::Helper;
use serde::{Serialize, Serializer};

use crate::exits::Exit;
use crate::log::DriveLog;
use crate::report::ServiceReport;
use crate::steps::Drive;

/// Reason why a group ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All services reached the announced end.
    Orderly,
    /// Ctrl-C, SIGTERM or SIGHUP.
    Interrupted,
    /// A service ended before its time and was not replaced.
    Broken { service: Service, how: String },
    /// A service ended too often: the vehicle was ordered to stop in lane.
    GivenUp { service: Service, restarts: u32 },
}

#[derive(Debug)]
pub struct GroupOutcome {
    pub carrier: Carrier,
    /// Root of the run, which is gone.
    pub root: PathBuf,
    /// Reason why it ended.
    pub ended: Ended,
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
    pub faults: Vec<FaultRecord>,
    /// The drive as the launcher received it.
    pub drive: Drive,
    /// Time from the first spawn until all services were ready.
    pub ready_after: Duration,
    /// Time from the start instant until all services had reported.
    pub ran_for: Duration,
    pub recording: Option<RecordingSummary>,
    /// Lines that services wrote beside their messages: warnings, panics.
    pub wrote: Vec<(Service, String)>,
    /// The programs of the user's that took part, by the service that they are or compute for.
    pub programs: BTreeMap<Service, Program>,
}

impl GroupOutcome {
    /// Meaning of the numbers in the diagnostics; empty if a program in the controller's place sends its own.
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

/// Cost of a service's standby beside the active process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StandbyCost {
    /// Part of one processor that it used while it stood by, all its threads, %.
    pub cpu_percent: f64,
    /// Memory of its own: what would be free without it, KiB.
    pub private_kib: u64,
}

/// Signs of life of a service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Heartbeats {
    pub count: u64,
    /// Number of these in which the service reported a missing or stale input.
    pub degraded: u64,
    /// Longest time without one, ms.
    pub longest_silence_ms: f64,
    /// Time without one because the machine did not give it the processor, ms.
    pub starved_ms: f64,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RecordingSummary {
    #[serde(serialize_with = "as_text")]
    pub path: PathBuf,
    pub messages: u64,
    /// Messages that were sent and are not in it; null if the recorder died.
    pub lost: Option<u64>,
    pub bytes: u64,
    /// Reason why it ends before the run's end, if it does.
    pub failed: Option<String>,
}

/// A path in JSON, which holds text alone: bytes that are not text are replaced.
fn as_text<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// One thing that went wrong, asked for or not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultRecord<R = Service> {
    /// Run time at which it began, s.
    pub t_s: f64,
    /// Kind of the fault, or `died`, `hung`, `flooded` or `not ready` for one that was not asked for.
    pub kind: String,
    pub service: Option<R>,
    /// The topic whose messages it acts on.
    pub topic: Option<&'static str>,
    /// The process that it acts on, other than a service.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub helper: Option<Helper>,
    /// The process that it killed had not taken part in the run yet.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub while_starting: bool,
    /// Messages that it changed, summed over the topic's ports.
    pub messages: Option<u64>,
    /// Messages that it corrupted and a receiver took for intact.
    #[serde(skip_serializing_if = "is_zero")]
    pub undetected: u64,
    /// Time until the launcher found that the service was gone or hung, µs. It is null for a death at an unknown
    /// instant.
    pub detected_after_us: Option<f64>,
    /// Time until the first fresh message of the service's next process, µs.
    pub recovered_after_us: Option<f64>,
    /// Whose message that was.
    pub recovered_by: Option<Recovery>,
    /// Its number in the run, for the ports' counts.
    #[serde(skip)]
    pub number: u32,
    /// Restart of the service whose first message is the recovery.
    #[serde(skip)]
    pub awaits: Option<u32>,
}

/// The process that took the place of one that is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Recovery {
    /// One that was started for it.
    Restart,
    TakeOver,
}

impl Recovery {
    pub fn name(self) -> &'static str {
        match self {
            Self::Restart => "restart",
            Self::TakeOver => "take-over",
        }
    }
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}
