//! Mechanisms and conditions of a measurement.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Display;
use supervise::MachineError;

/// Scheduling of the measured processes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheduling {
    /// `SCHED_FIFO`, priorities as in a group.
    #[default]
    Fifo,
    /// The time-sharing default.
    Other,
}

/// Cores of the measured processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// All on the last usable core.
    SameCore,
    /// The source on the first usable core, the sink (in a group: the controller) on the last.
    TwoCores,
}

/// Load of the machine during a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// No load of ours.
    Idle,
    /// A computing process on every core.
    Cpu,
    /// A memory-copying process on every core.
    Memory,
}

macro_rules! names {
    ($($type:ident { $($variant:ident: $name:literal),+ })+) => {$(
        impl $type {
            /// Name in tables, results and tags.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    )+};
}

names! {
    Scheduling { Fifo: "fifo", Other: "other" }
    Placement { SameCore: "same_core", TwoCores: "two_cores" }
    Load { Idle: "idle", Cpu: "cpu", Memory: "memory" }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Conditions {
    pub placement: Placement,
    pub scheduling: Scheduling,
    pub load: Load,
}

impl Conditions {
    pub fn in_words(&self) -> String {
        let Self { placement, scheduling, load } = self;
        format!("{} {} {}", scheduling.name(), placement.name(), load.name())
    }

    /// Words in the tag of a histogram.
    pub fn tag(&self, period_us: u32) -> String {
        format!("{}:{period_us}us", self.in_words().replace(' ', ":"))
    }
}

/// Mechanism of a wake-up, with its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mechanism {
    /// A word in shared memory without data: the floor.
    Futex,
    /// A counter in the kernel.
    Eventfd,
    /// iceoryx2's event service.
    Iceoryx2Event,
    /// A message through the services' own ports: the radar's tracks.
    Message,
    /// The largest message through the services' own ports: the radar's detections.
    Detections,
    /// A payload, loaned and borrowed; a protected one is also written and checked in place.
    Payload { bytes: usize, is_protected: bool },
}

impl Mechanism {
    /// A payload that neither end reads or writes.
    pub const fn bare(bytes: usize) -> Self {
        Self::Payload { bytes, is_protected: false }
    }

    /// Name in tables and tags.
    pub fn name(self) -> String {
        match self {
            Self::Futex => "futex".into(),
            Self::Eventfd => "eventfd".into(),
            Self::Iceoryx2Event => "iceoryx2-event".into(),
            Self::Message => "message".into(),
            Self::Detections => "detections".into(),
            Self::Payload { bytes, is_protected: false } => format!("payload-{bytes}"),
            Self::Payload { bytes, .. } => format!("protected-payload-{bytes}"),
        }
    }
}

/// Size from which on a hand-over takes constant time, bytes: larger ones are not copied.
pub const FLAT_FROM: usize = 4 << 10;
/// Size of the largest payload, bytes.
pub const LARGEST: usize = 4 << 20;

/// The caveats of every verdict: fewer than two cores, a processor quota, time-sharing.
pub fn caveats(cores: usize, reference: Scheduling, quota: Option<f64>) -> Vec<String> {
    let mut caveats = Vec::new();
    if cores < 2 {
        caveats.push("one core".to_owned());
    }
    if let Some(share) = quota.filter(|share| *share < cores as f64) {
        caveats.push(format!("processor quota of {share:.2} cores"));
    }
    if reference == Scheduling::Other {
        caveats.push("without SCHED_FIFO".to_owned());
    }
    caveats
}

/// Tightest processor quota of this process's control group (version 2) and its parents, in cores; `None`
/// without a quota.
pub fn quota() -> Option<f64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = groups.lines().find_map(|line| line.strip_prefix("0::"))?.trim_matches('/');
    let parts: Vec<&str> = group.split('/').filter(|part| !part.is_empty()).collect();
    let tightest = (0..=parts.len()).filter_map(|depth| {
        let path = format!("/sys/fs/cgroup/{}/cpu.max", parts[..depth].join("/"));
        quota_in(&std::fs::read_to_string(path).ok()?)
    });
    tightest.min_by(f64::total_cmp)
}

/// Cores that a `cpu.max` allows: quota over period; `None` for `max`.
fn quota_in(text: &str) -> Option<f64> {
    let mut words = text.split_whitespace();
    let (quota, period) = (words.next()?.parse::<f64>().ok()?, words.next()?.parse::<f64>().ok()?);
    (period > 0.0).then(|| quota / period)
}

/// The error of the step `what`, from its reason.
pub fn failed<E: Display>(what: &'static str) -> impl Fn(E) -> MachineError {
    move |reason| MachineError(format!("the benchmark cannot {what}: {reason}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quota_is_read_in_cores() {
        assert_eq!(quota_in("max 100000\n"), None);
        assert_eq!(quota_in("50000 100000\n"), Some(0.5));
        assert_eq!(quota_in(""), None);
    }

    #[test]
    fn the_machines_lacks_are_named() {
        assert!(caveats(2, Scheduling::Fifo, None).is_empty());
        assert!(caveats(2, Scheduling::Fifo, Some(4.0)).is_empty(), "more than the machine has");
        let all = caveats(1, Scheduling::Other, Some(0.5));
        assert_eq!(all, ["one core", "processor quota of 0.50 cores", "without SCHED_FIFO"]);
    }
}
