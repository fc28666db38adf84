//! Counts of the messages of a run.

use crate::report::{LinkReport, ObuReport, ReceivedTopic, ServiceReport};
use crate::{Drive, GroupOutcome};
use messages::Service;
use messages::e2e::Outcomes;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::OnceLock;

#[derive(Clone, Debug, Default, Serialize)]
pub struct TopicCounts {
    /// Messages sent by all of the topic's senders.
    pub sent: u64,
    /// Fewest messages that one of the topic's readers received; null if it has no readers.
    pub received: Option<u64>,
    /// Most messages that one of the topic's readers missed.
    pub lost: Option<u64>,
    /// Messages that each late reader missed.
    pub lost_by: BTreeMap<&'static str, u64>,
    /// Messages that the topic's readers refused; null if it has no readers.
    pub e2e_errors: Option<u64>,
    /// Outcomes of the end-to-end check, summed over the topic's readers.
    pub e2e: Outcomes,
    /// XXH3 over the bytes of all messages of each sender, in lockstep.
    pub digests: BTreeMap<String, String>,
}

/// Counts of all topics, from the services' reports and the launcher's own reading.
pub(super) fn of(
    reports: &BTreeMap<Service, ServiceReport>,
    drive: &Drive,
) -> BTreeMap<String, TopicCounts> {
    let mut topics: BTreeMap<String, TopicCounts> = BTreeMap::new();
    for report in reports.values() {
        for sent in &report.sent {
            let counts = topics.entry(sent.topic.clone()).or_default();
            counts.sent += sent.sent;
            if let Some(digest) = &sent.digest {
                counts.digests.insert(report.service.name().into(), digest.clone());
            }
        }
    }
    let of_services = reports.values().flat_map(|report| {
        report.received.iter().map(|received| (report.service.name(), received))
    });
    let of_launcher = drive.received.iter().map(|received| ("launcher", received));
    for (reader, received) in of_services.chain(of_launcher) {
        let ReceivedTopic { topic, received, lost, e2e, .. } = received;
        let counts = topics.entry(topic.clone()).or_default();
        counts.received = Some(counts.received.map_or(*received, |least| least.min(*received)));
        counts.lost = Some(counts.lost.map_or(*lost, |most| most.max(*lost)));
        if *lost > 0 {
            counts.lost_by.insert(reader, *lost);
        }
        counts.e2e.add(e2e);
        counts.e2e_errors = Some(counts.e2e.refused());
    }
    topics
}

/// The machine that ran the processes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Host {
    /// Processors that this process may use.
    pub cpus: usize,
    pub kernel: String,
    /// True if the kernel is built with PREEMPT_RT.
    pub realtime_kernel: bool,
}

impl Host {
    pub fn this() -> Self {
        static THIS: OnceLock<Host> = OnceLock::new();
        THIS.get_or_init(Self::read).clone()
    }

    fn read() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default().trim().to_owned();
        Self {
            cpus: std::thread::available_parallelism().map_or(1, usize::from),
            kernel: read("/proc/sys/kernel/osrelease"),
            realtime_kernel: read("/sys/kernel/realtime") == "1",
        }
    }
}

/// The on-board unit's report; `None` without one.
pub(super) fn unit(group: &GroupOutcome) -> Option<ObuReport> {
    group.reports.get(&Service::Obu)?.details.read()
}

/// The carrier's report from v2x-sim; `None` without one.
pub(super) fn link(group: &GroupOutcome) -> Option<LinkReport> {
    group.reports.get(&Service::V2xSim)?.details.read::<Option<_>>().flatten()
}
