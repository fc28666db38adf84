//! The figures of a run: `graph.json`, and the same for people. A figure that does not apply is null.

use crate::chains::{Layout, PARTS, Reactions};
use crate::group::Launcher;
use crate::plan::Graph;
use crate::ports;
use bench::document::drawn;
use bench::peer::Outcome;
use report::gate::{Against, Baseline, Sample};
use report::html::grid;
use report::output::{HISTOGRAMS, histogram_log};
use report::print::duration;
use report::results::{Broken, Column, Document, Object, Table, count, micros, value, word};
use report::summary::Host;
use runtime::statistics::{Latencies, Percentiles};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use supervise::{Error, Recovery};

/// Tag of the floor's histogram.
const FLOOR: &str = "sleep";

/// Percentiles, µs.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct Us(#[schemars(with = "Option<Object>")] Option<Percentiles>);

impl From<&Latencies> for Us {
    fn from(latencies: &Latencies) -> Self {
        Self(latencies.percentiles_us())
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub struct Report {
    pub schema_version: u32,
    /// No chain missed its deadline more often than it may, and no node was given up.
    pub ok: bool,
    pub graph: String,
    pub seconds: f64,
    #[schemars(with = "Object")]
    pub host: Host,
    /// Requests that the kernel refused, with its reasons.
    pub refused: BTreeSet<String>,
    /// Why the run ended early.
    pub broken: Option<String>,
    /// Lateness of a process that only sleeps, during the same seconds.
    pub floor_us: Us,
    pub chains: Vec<ChainRow>,
    pub hops: Vec<HopRow>,
    pub nodes: Vec<NodeRow>,
    pub topics: Vec<TopicRow>,
    pub faults: Vec<FaultRow>,
    /// Figures of each block of the run, for `--against`.
    #[schemars(with = "Vec<Object>")]
    pub samples: Vec<Sample>,
    /// The run against that of `--against`; null without it.
    pub against: Option<Against>,
}

/// Declares the rows of a table once: the fields of its JSON, each with its columns for people. A column has a kind, a
/// heading, the percentile that it shows, and a weight in brackets.
macro_rules! rows {
    ($(#[$doc:meta])* $row:ident, $columns:ident; $($field:ident: $type:ty, $meaning:literal
        $(=> $($kind:ident $heading:literal $($percentile:ident)? $([$weight:literal])?),+)?;)*) => {
        $(#[$doc])*
        #[derive(Debug, Serialize, JsonSchema)]
        pub struct $row { $(#[doc = $meaning] pub $field: $type),* }

        fn $columns() -> Vec<Column<$row>> {
            let columns = [$($($($kind(
                concat!(stringify!($field) $(, ".", stringify!($percentile))?), $heading, $meaning,
            )$(.weight($weight))?,)+)?)*];
            columns.into()
        }
    };
}

rows! {
    ChainRow, chain_columns;
    chain: String, "Chain from its source to its last node" => word "chain";
    deadline_us: Option<f64>, "Longest accepted reaction time" => micros "deadline";
    reactions: u64, "Messages of the source that reached the end" => count "n";
    replaced: u64, "Messages of the source that newer ones replaced on the way" => count "not used" [1];
    misses: Option<u64>, "Reactions later than the deadline; null without one" => count "misses";
    max_misses: u64, "Late reactions that are accepted";
    reaction_time_us: Us, "Source's release to the last node's end"
        => micros "reaction p50" p50, micros "p99" p99, micros "max" max;
    data_age_us: Us, "Age of the data at each end of a cycle" => micros "age p50" p50 [1], micros "max" max [1];
    designed_wait_us: Us, "Waits for the release of a timer, or for another topic";
    net_reaction_us: Us, "Reaction without waits for a timer or topic" => micros "net p50" p50, micros "p99" p99 [1];
}

rows! {
    /// The part of a chain's reactions that a node makes up.
    HopRow, hop_columns;
    chain: String, "Chain" => word "chain";
    node: String, "Node on it" => word "node";
    wait_us: Us, "The message is there, the node busy or not due" => micros "wait p50" p50, micros "max" max [1];
    wake_us: Us, "From then to the start of the cycle" => micros "wake-up p50" p50, micros "max" max;
    work_us: Us, "Start of the cycle to its publication, or its end" => micros "work p50" p50, micros "max" max;
}

rows! {
    NodeRow, node_columns;
    node: String, "Node" => word "node";
    scheduling: Option<String>, "Scheduling that the kernel granted" => word "scheduling" [1];
    core: Option<usize>, "CPU that it is pinned to" => count "core" [3];
    cycles: u64, "Cycles of all its processes" => count "cycles";
    skipped: u64, "Releases that were left out: it was busy or stopped" => count "skipped";
    release_jitter_us: Us, "Start of a cycle after its release" => micros "release p50" p50, micros "max" max;
    work_us: Us, "Length of a cycle" => micros "work p50" p50 [1];
    replacements: u32, "Times that another process became the active one" => count "replaced";
    take_overs: u32, "Those in which it was the standby";
    starved_ms: f64, "Time without the processor" => value "starved, ms" [2];
}

rows! {
    TopicRow, topic_columns;
    topic: String, "Topic" => word "topic";
    bytes: usize, "Length of a message, with header and stamps" => count "bytes";
    sent: u64, "Messages sent" => count "sent";
    received: u64, "Messages received, by all readers together" => count "received";
    unused: u64, "Messages that newer ones replaced before a cycle used them" => count "unused";
    refused: u64, "Messages that failed a check" => count "refused" [1];
}

rows! {
    /// A fault that was asked for, or an end or silence that was not.
    FaultRow, fault_columns;
    t_s: f64, "Run time of its begin" => value "t, s";
    fault: String, "`kill camera`, `stop camera`, `delay image`; `died` and `hung` were not asked for" => word "fault";
    detected_after_us: Option<f64>, "Until launcher or standby noticed it" => micros "noticed after";
    recovered_after_us: Option<f64>, "Until the first cycle of the next process" => micros "back after";
    recovered_by: Option<&'static str>, "`restart` or `take-over`" => word "by";
}

impl ChainRow {
    /// True if it has reactions, and no more of them are late than may be.
    fn holds(&self) -> bool {
        self.reactions > 0 && self.misses.is_none_or(|misses| misses <= self.max_misses)
    }

    /// Why it does not hold, in words.
    fn broken(&self) -> String {
        let Self { chain, reactions, misses, deadline_us, max_misses, .. } = self;
        if *reactions == 0 {
            return format!("{chain}: no message reached the end");
        }
        let (misses, limit) = (misses.unwrap_or(0), duration(deadline_us.unwrap_or(0.0)));
        let accepted = format!("({max_misses} accepted)");
        format!("{chain}: {misses} of {reactions} reactions are later than {limit} {accepted}")
    }
}

/// The result of a run that has ended, with the floor beside it.
pub fn document(
    graph: &Graph,
    launcher: &Launcher<'_>,
    floor: &Outcome,
    (baseline, factor): (Option<&Baseline>, f64),
) -> Result<Document, Error> {
    let Launcher { roster, counts, log, broken, .. } = launcher;
    let group = &roster.group;
    let (mut chains, mut hops, mut pictures) = (Vec::new(), Vec::new(), String::new());
    let mut samples = Vec::new();
    let mut histograms = vec![(FLOOR.to_owned(), floor.latencies.clone())];
    for (number, chain) in graph.chains.iter().enumerate() {
        let Reactions { times, blocks, .. } = Reactions::open(graph, number, group)?;
        let name = chain.name.as_str().to_owned();
        let first = graph.link(number, 0).expect("checked");
        let reactions = times.reaction.count();
        chains.push(ChainRow {
            chain: name.clone(),
            deadline_us: chain.deadline_ms.map(|ms| 1e3 * ms.value()),
            reactions,
            replaced: ports::count(group, first, "sent")?.get().saturating_sub(reactions),
            misses: chain.deadline_ms.map(|_| times.late.get()),
            max_misses: chain.max_misses,
            reaction_time_us: (&times.reaction).into(),
            data_age_us: (&times.age).into(),
            designed_wait_us: (&times.designed_wait).into(),
            net_reaction_us: (&times.net_reaction).into(),
        });
        for (node, parts) in chain.path.iter().zip(times.parts.chunks(PARTS)) {
            let [wait_us, wake_us, work_us] = [0, 1, 2].map(|part| Us::from(&parts[part]));
            let (chain, node) = (name.clone(), node.clone());
            hops.push(HopRow { chain, node, wait_us, wake_us, work_us });
        }
        let mut sample = |figure: &str, value: fn(&Percentiles) -> f64| {
            let values = blocks.iter().map(|block| block.percentiles_us().as_ref().map(value));
            // Blocks of one run vary less than runs do.
            samples.push(Sample::growing(&name, figure, values.collect(), factor));
        };
        sample("reaction time p50, µs", |us| us.p50);
        sample("reaction time p99, µs", |us| us.p99);
        let [reaction, age] = ["reaction_time", "data_age"].map(|tag| format!("{tag}:{number}"));
        histograms.push((reaction.clone(), times.reaction));
        histograms.push((age.clone(), times.age));
        let floor = (FLOOR.to_owned(), "floor: a process that only sleeps");
        let tagged = [(reaction, "reaction time"), (age, "data age"), floor];
        pictures += &drawn(&histograms, &name, &tagged).unwrap_or_default();
    }
    let nodes = roster.iter().zip(counts).map(|(member, counts)| {
        let node = member.role.to_string();
        let granted = roster.granted.get(&node);
        NodeRow {
            scheduling: granted.map(|granted| granted.granted.clone()),
            core: granted.and_then(|granted| granted.core),
            cycles: counts.cycles.get(),
            skipped: counts.skipped.get(),
            release_jitter_us: (&counts.jitter).into(),
            work_us: (&counts.work).into(),
            replacements: member.succession.replacements(),
            take_overs: member.succession.take_overs(),
            starved_ms: member.heartbeats.starved_ms.round(),
            node,
        }
    });
    let faults = log.records.iter().map(|record| FaultRow {
        t_s: (1e6 * record.t_s).round() / 1e6,
        fault: record.service.map_or(record.kind.clone(), |node| format!("{} {node}", record.kind)),
        detected_after_us: record.detected_after_us,
        recovered_after_us: record.recovered_after_us,
        recovered_by: record.recovered_by.map(Recovery::name),
    });
    let mut topics = Vec::new();
    for topic in graph.topics.keys() {
        let count = |name| ports::count(group, topic, name).map(|count| count.get());
        topics.push(TopicRow {
            topic: topic.clone(),
            bytes: Layout::of(graph, topic).length,
            sent: count("sent")?,
            received: count("received")?,
            unused: count("unused")?,
            refused: count("refused")?,
        });
    }
    let granted = roster.granted.values().chain([&floor.granted]);
    let refused = granted.flat_map(|granted| &granted.refused).cloned();
    let late: Vec<&ChainRow> = chains.iter().filter(|chain| !chain.holds()).collect();
    let held = chains.len() - late.len();
    let why = broken.iter().cloned().chain(late.into_iter().map(ChainRow::broken));
    let why: Vec<Broken> = why.map(|what| Broken::new(what, "")).collect();
    let report = Report {
        schema_version: 1,
        ok: why.is_empty(),
        graph: graph.name.as_str().to_owned(),
        seconds: graph.duration_s.value(),
        host: Host::this(),
        refused: refused.collect(),
        broken: broken.clone(),
        floor_us: (&floor.latencies).into(),
        against: baseline.map(|file| file.judge(&samples)).transpose()?,
        samples,
        hops,
        nodes: nodes.collect(),
        topics,
        faults: faults.collect(),
        chains,
    };
    let mut verdict = format!("{held} of {} chains hold", report.chains.len());
    if let (Some(us), Some(core)) = (report.floor_us.0, floor.granted.core) {
        let (p50, max) = (duration(us.p50), duration(us.max));
        verdict += &format!("; floor on core {core}: a sleep is {p50} late (p50), {max} at worst");
    }
    let Host { cpus, kernel, realtime_kernel } = &report.host;
    let kind = if *realtime_kernel { ", real-time kernel" } else { "" };
    let facts = report.refused.iter().map(|why| ("not granted", why.clone()));
    let document = Document::new("graph", &format!("Graph {}", report.graph), &report)
        .about(format!("{cpus} processors, Linux {kernel}{kind}, {} s", report.seconds))
        .facts("Not granted", facts)
        .table(Table::new("Chains", &chain_columns(), &report.chains))
        .figures("Chains", grid(&pictures))
        .table(Table::new("Hops", &hop_columns(), &report.hops).blocks("chain").without_cases())
        .table(Table::new("Nodes", &node_columns(), &report.nodes).without_cases())
        .table(Table::new("Topics", &topic_columns(), &report.topics).without_cases())
        .table(Table::new("Faults", &fault_columns(), &report.faults).without_cases())
        .file(HISTOGRAMS, histogram_log(&histograms))
        .verdict(report.ok, verdict)
        .broken(why);
    Ok(report.against.iter().fold(document, |document, against| against.onto(document)))
}
