//! `graph.json`: the figures of a run. A figure that does not apply is null.

use crate::group::{Ran, Record};
use crate::plan::Graph;
use crate::times::{NodeCounts, Reactions, ReaderCounts, sent};
use crate::trail::PARTS;
use bench::peer::Outcome;
use report::results::Object;
use report::summary::Host;
use runtime::statistics::{Latencies, Percentiles};
use runtime::{Group, RuntimeError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Report {
    pub schema_version: u32,
    /// No chain missed its deadline more often than it may, and no node was given up.
    pub ok: bool,
    /// Name of the graph.
    pub graph: String,
    pub seconds: f64,
    #[schemars(with = "Object")]
    pub host: Host,
    /// Requests that the kernel refused, with its reasons.
    pub refused: BTreeSet<String>,
    /// Why the run ended early; null for a whole run.
    pub broken: Option<String>,
    pub floor: Floor,
    pub chains: Vec<ChainRow>,
    pub nodes: Vec<NodeRow>,
    pub topics: Vec<TopicRow>,
    #[schemars(with = "Vec<Object>")]
    pub faults: Vec<Record>,
}

/// The machine's floor: a process that only sleeps, during the same seconds.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Floor {
    pub core: usize,
    pub period_us: u32,
    #[schemars(with = "Option<Object>")]
    pub sleep_jitter_us: Option<Percentiles>,
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ChainRow {
    pub chain: String,
    pub deadline_us: Option<f64>,
    /// Messages that the source sent into the chain.
    pub started: u64,
    /// Those that reached its end.
    pub reactions: u64,
    /// Reactions that were longer than the deadline; null without one.
    pub misses: Option<u64>,
    pub max_misses: u64,
    #[schemars(with = "Option<Object>")]
    pub reaction_time_us: Option<Percentiles>,
    #[schemars(with = "Option<Object>")]
    pub data_age_us: Option<Percentiles>,
    /// Waits for the release of a timer, or for another topic.
    #[schemars(with = "Option<Object>")]
    pub designed_wait_us: Option<Percentiles>,
    /// Reaction time without them.
    #[schemars(with = "Option<Object>")]
    pub net_reaction_us: Option<Percentiles>,
    pub hops: Vec<HopRow>,
    /// Reaction times in blocks of equal length, for a comparison with another run; null for an empty block.
    #[schemars(with = "Vec<Option<Object>>")]
    pub blocks: Vec<Option<Percentiles>>,
}

/// The part of a reaction that a node makes up.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HopRow {
    pub node: String,
    /// The message is there, and the node is busy or not yet due.
    #[schemars(with = "Option<Object>")]
    pub wait_us: Option<Percentiles>,
    /// From then to the start of the cycle.
    #[schemars(with = "Option<Object>")]
    pub wake_us: Option<Percentiles>,
    /// Start of the cycle to its publication, or its end.
    #[schemars(with = "Option<Object>")]
    pub work_us: Option<Percentiles>,
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct NodeRow {
    pub node: String,
    /// Scheduling that the kernel granted.
    pub scheduling: Option<String>,
    pub core: Option<usize>,
    pub cycles: u64,
    pub skipped: u64,
    /// Start of a cycle after its release.
    #[schemars(with = "Option<Object>")]
    pub release_jitter_us: Option<Percentiles>,
    #[schemars(with = "Option<Object>")]
    pub work_us: Option<Percentiles>,
    /// Times that another process became the active one.
    pub replacements: u32,
    pub take_overs: u32,
    pub starved_ms: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct TopicRow {
    pub topic: String,
    /// Length of a message, with header and stamps.
    pub bytes: usize,
    pub sent: u64,
    /// Of all readers together.
    pub received: u64,
    /// Messages that newer ones replaced before a cycle used them.
    pub unused: u64,
    pub refused: u64,
}

impl Report {
    /// The figures that the processes left, and their histograms by tags.
    pub fn of(
        graph: &Graph,
        group: &Group,
        ran: Ran,
        (core, period_us, floor): (usize, u32, &Outcome),
    ) -> Result<(Self, Vec<(String, Latencies)>), RuntimeError> {
        let mut histograms = Vec::new();
        let chains = (0..graph.chains.len())
            .map(|chain| ChainRow::of(graph, chain, group, &mut histograms))
            .collect::<Result<Vec<_>, _>>()?;
        let topics = (0..graph.topics.len()).map(|topic| TopicRow::of(graph, topic, group));
        let granted = ran.granted.iter().flatten().chain([&floor.granted]);
        let refused = granted.flat_map(|granted| &granted.refused).map(ToString::to_string);
        let floor_as_asked = floor.granted.granted == floor.granted.requested;
        let sleep_jitter_us = floor.latencies.percentiles_us().filter(|_| floor_as_asked);
        histograms.push(("sleep".to_owned(), floor.latencies.clone()));
        let report = Self {
            schema_version: 1,
            ok: ran.broken.is_none() && chains.iter().all(ChainRow::holds),
            graph: graph.name.clone(),
            seconds: graph.duration_s,
            host: Host::this(),
            refused: refused.collect(),
            floor: Floor { core, period_us, sleep_jitter_us },
            chains,
            nodes: (0..graph.nodes.len())
                .map(|node| NodeRow::of(graph, node, group, &ran))
                .collect::<Result<_, _>>()?,
            topics: topics.collect::<Result<_, _>>()?,
            faults: ran.records,
            broken: ran.broken,
        };
        Ok((report, histograms))
    }
}

impl ChainRow {
    fn of(
        graph: &Graph,
        chain: usize,
        group: &Group,
        histograms: &mut Vec<(String, Latencies)>,
    ) -> Result<Self, RuntimeError> {
        let of = &graph.chains[chain];
        let Reactions { times, blocks, .. } = Reactions::open(graph, chain, group)?;
        let hop = |(hop, parts): (&crate::plan::Hop, &[Latencies])| {
            let [wait_us, wake_us, work_us] = [0, 1, 2].map(|part| parts[part].percentiles_us());
            HopRow { node: graph.nodes[hop.node].name.clone(), wait_us, wake_us, work_us }
        };
        let first = of.path[1].topic.expect("each node but the first has one");
        let row = Self {
            chain: of.name.clone(),
            deadline_us: of.deadline_ns.map(|ns| ns as f64 / 1e3),
            started: sent(first, group)?.get(),
            reactions: times.reaction.count(),
            misses: of.deadline_ns.map(|_| times.late.get()),
            max_misses: of.max_misses,
            reaction_time_us: times.reaction.percentiles_us(),
            data_age_us: times.age.percentiles_us(),
            designed_wait_us: times.designed_wait.percentiles_us(),
            net_reaction_us: times.net_reaction.percentiles_us(),
            hops: of.path.iter().zip(times.parts.chunks(PARTS)).map(hop).collect(),
            blocks: blocks.iter().map(Latencies::percentiles_us).collect(),
        };
        for (name, latencies) in [("reaction_time", times.reaction), ("data_age", times.age)] {
            histograms.push((format!("{name}:{chain}"), latencies.clone()));
        }
        Ok(row)
    }

    /// True if it has reactions, and no more of them are late than may be.
    pub fn holds(&self) -> bool {
        self.reactions > 0 && self.misses.is_none_or(|misses| misses <= self.max_misses)
    }
}

impl NodeRow {
    fn of(graph: &Graph, node: usize, group: &Group, ran: &Ran) -> Result<Self, RuntimeError> {
        let counts = NodeCounts::open(node, None, group)?;
        let granted = ran.granted[node].as_ref();
        Ok(Self {
            node: graph.nodes[node].name.clone(),
            scheduling: granted.map(|granted| granted.granted.clone()),
            core: granted.and_then(|granted| granted.core),
            cycles: counts.cycles.get(),
            skipped: counts.skipped.get(),
            release_jitter_us: counts.jitter.percentiles_us(),
            work_us: counts.work.percentiles_us(),
            replacements: ran.restarts[node],
            take_overs: ran.take_overs[node],
            starved_ms: ran.starved_ms[node],
        })
    }
}

impl TopicRow {
    fn of(graph: &Graph, topic: usize, group: &Group) -> Result<Self, RuntimeError> {
        let of = &graph.topics[topic];
        let mut row = Self {
            topic: of.name.clone(),
            bytes: crate::trail::length(of),
            sent: sent(topic, group)?.get(),
            received: 0,
            unused: 0,
            refused: 0,
        };
        for reader in &of.readers {
            let counts = ReaderCounts::open(topic, *reader, group)?;
            row.received += counts.received.get();
            row.unused += counts.unused.get();
            row.refused += counts.refused.get();
        }
        Ok(row)
    }
}
