//! Facts about its run that a recording holds beside the messages.

use messages::LAYOUT_VERSION;
use messages::names::ENUMERATIONS;
use runtime::{Mode, Program, scheduling::Granted};
use scenario::Scenario;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Name of the metadata record at a recording's begin.
const RUN: &str = "timegap";
/// Name of the metadata record at the end of a recording that was ended.
const END: &str = "timegap.end";

/// Facts that are known when a recording begins. Its record has one entry a field; a text stands there as it is, any
/// other value as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    /// Program and version that recorded.
    pub program: String,
    pub layout_version: String,
    /// The effective scenario, TOML.
    pub scenario: String,
    pub scenario_name: String,
    pub controller: String,
    /// Seed of all random numbers.
    pub seed: u64,
    pub mode: Mode,
    /// Run time 0 in ns since 1970, to place the run in the calendar. In lockstep it is [`SIMULATED_START_NS`], so
    /// that the same run gives the same file.
    pub started_unix_ns: i64,
    /// The log time of run time 0, ns: the same, except for older files, whose log times are run time.
    #[serde(default)]
    pub epoch_ns: i64,
    /// The machine; none in lockstep, where it changes nothing.
    #[serde(flatten)]
    pub host: Option<Host>,
    /// Meaning of the law's numbers; empty if unknown.
    #[serde(skip)]
    pub law: LawNames,
    /// Scheduling that the kernel granted to each service, by its name.
    #[serde(skip)]
    pub scheduling: BTreeMap<String, Granted>,
    /// The programs of the user's that took part, by the service that they were or computed for.
    #[serde(skip)]
    pub programs: BTreeMap<String, Program>,
}

/// Run time 0 of a run in simulated time, ns since 1970: the beginning of 2026, UTC.
pub const SIMULATED_START_NS: i64 = 1_767_225_600_000_000_000;

/// Meaning of a law's numbers in `control/diagnostics`, by their place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LawNames {
    pub modes: Vec<String>,
    /// Reasons for a change of mode.
    pub reasons: Vec<String>,
    pub figures: Vec<FigureName>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FigureName {
    pub name: String,
    pub unit: String,
}

/// The machine that a run was recorded on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Host {
    #[serde(rename = "host")]
    pub name: String,
    pub kernel: String,
    /// Processors that the recorder may use.
    pub cpus: usize,
}

impl Host {
    pub fn this() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default().trim().to_owned();
        Self {
            name: read("/proc/sys/kernel/hostname"),
            kernel: read("/proc/sys/kernel/osrelease"),
            cpus: std::thread::available_parallelism().map_or(1, usize::from),
        }
    }
}

impl Metadata {
    /// The metadata of a run of `scenario` on this machine, with run time 0 at `started_unix_ns` and the
    /// grants `scheduling`. In lockstep both are left out, and the machine: the same run is to give
    /// the same file.
    pub fn new(
        scenario: &Scenario,
        mode: Mode,
        started_unix_ns: i64,
        scheduling: BTreeMap<String, Granted>,
        law: LawNames,
    ) -> Self {
        let (started_unix_ns, host, scheduling) = match mode {
            Mode::Realtime => (started_unix_ns, Some(Host::this()), scheduling),
            Mode::Lockstep => (SIMULATED_START_NS, None, BTreeMap::new()),
        };
        Self {
            program: concat!("timegap ", env!("CARGO_PKG_VERSION")).into(),
            layout_version: LAYOUT_VERSION.into(),
            scenario: scenario.to_toml(),
            scenario_name: scenario.name.as_str().into(),
            controller: scenario.controller.name.as_str().into(),
            seed: scenario.seed.value(),
            mode,
            started_unix_ns,
            epoch_ns: started_unix_ns,
            host,
            law,
            scheduling,
            programs: BTreeMap::new(),
        }
    }

    pub(crate) fn to_record(&self) -> mcap::records::Metadata {
        let facts = serde_json::to_value(self).expect("plain data");
        let facts = facts.as_object().into_iter().flatten();
        let entry = |(key, value): (&String, &Value)| {
            (key.clone(), value.as_str().map_or_else(|| value.to_string(), str::to_owned))
        };
        let mut map: BTreeMap<String, String> = facts.map(entry).collect();
        map.insert(LAW.into(), serde_json::to_string(&self.law).expect("plain data"));
        for enumeration in &ENUMERATIONS {
            let names: BTreeMap<_, _> = enumeration.values.iter().copied().collect();
            let json = serde_json::to_string(&names).expect("plain data");
            map.insert(format!("{NAMES}{}", enumeration.name), json);
        }
        map.extend(under(SCHEDULING, &self.scheduling));
        map.extend(under(PROGRAM, &self.programs));
        mcap::records::Metadata { name: RUN.into(), metadata: map }
    }

    /// Reads it from a record of the file; `None` if it is another's, or not whole.
    pub(crate) fn of_record(name: &str, map: &BTreeMap<String, String>) -> Option<Self> {
        (name == RUN).then_some(())?;
        let fact = |(key, text): (&String, &String)| {
            let is_text = TEXTS.contains(&key.as_str());
            let value =
                if is_text { text.clone().into() } else { serde_json::from_str(text).ok()? };
            Some((key.clone(), value))
        };
        let facts = Value::Object(map.iter().filter_map(fact).collect());
        Some(Self {
            law: map.get(LAW).and_then(|law| serde_json::from_str(law).ok()).unwrap_or_default(),
            scheduling: read_under(SCHEDULING, map),
            programs: read_under(PROGRAM, map),
            ..serde_json::from_value(facts).ok()?
        })
    }
}

/// Values of services in a record, under keys that begin with `prefix`.
fn under<T: Serialize>(prefix: &str, all: &BTreeMap<String, T>) -> BTreeMap<String, String> {
    let json = |value| serde_json::to_string(value).expect("plain data");
    all.iter().map(|(service, value)| (format!("{prefix}{service}"), json(value))).collect()
}

/// Reads what [`under`] wrote; values that this program does not know are left out.
fn read_under<T: DeserializeOwned>(
    prefix: &str,
    map: &BTreeMap<String, String>,
) -> BTreeMap<String, T> {
    let values = map.iter().filter_map(|(key, value)| {
        let service = key.strip_prefix(prefix)?;
        Some((service.to_owned(), serde_json::from_str(value).ok()?))
    });
    values.collect()
}

const TEXTS: [&str; 8] = [
    "program",
    "layout_version",
    "scenario",
    "scenario_name",
    "controller",
    "mode",
    "host",
    "kernel",
];
const SCHEDULING: &str = "scheduling.";
const PROGRAM: &str = "program.";
const LAW: &str = "law";
const NAMES: &str = "names.";

/// Counts of the recorder, known when a recording ends.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Per topic name.
    pub topics: BTreeMap<String, TopicTally>,
    /// Processes that each service had: 1 if it was never restarted.
    pub incarnations: BTreeMap<String, u32>,
}

/// Counts of the recorder on one topic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TopicTally {
    pub messages: u64,
    /// Messages that were sent, by their sequence numbers, and are not in the file.
    pub lost: u64,
}

impl Tally {
    pub fn messages(&self) -> u64 {
        self.topics.values().map(|topic| topic.messages).sum()
    }

    /// Messages that were sent and are not in the file.
    pub fn lost(&self) -> u64 {
        self.topics.values().fold(0, |sum, topic| sum.saturating_add(topic.lost))
    }

    pub(crate) fn to_record(&self) -> mcap::records::Metadata {
        let mut map = BTreeMap::new();
        for (topic, tally) in &self.topics {
            map.insert(format!("{topic}.messages"), tally.messages.to_string());
            map.insert(format!("{topic}.lost"), tally.lost.to_string());
        }
        for (service, count) in &self.incarnations {
            map.insert(format!("{service}.incarnations"), count.to_string());
        }
        mcap::records::Metadata { name: END.into(), metadata: map }
    }

    pub(crate) fn of_record(name: &str, map: &BTreeMap<String, String>) -> Option<Self> {
        (name == END).then_some(())?;
        let mut tally = Self::default();
        for (key, value) in map {
            let (name, what) = key.rsplit_once('.')?;
            let value: u64 = value.parse().ok()?;
            match what {
                "messages" => tally.topics.entry(name.into()).or_default().messages = value,
                "lost" => tally.topics.entry(name.into()).or_default().lost = value,
                "incarnations" => {
                    tally.incarnations.insert(name.into(), u32::try_from(value).ok()?);
                }
                _ => return None,
            }
        }
        Some(tally)
    }
}
