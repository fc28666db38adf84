//! The graph of a file: its tables and keys (docs/graph.md shows one), and its rules.
//!
//! * A topic has one writer.
//! * Each node is released, directly or not, by a node with a period.
//! * Each node of a chain reads what the node before it publishes.

use bench::setup::Scheduling;
use scenario::name::{Line, Name};
use scenario::quantity::{Core, DelayMs, Duration, Priority, Time};
use scenario::{Problem, ScenarioError, accepted};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Graph {
    pub name: Name,
    #[serde(default)]
    pub description: Line,
    /// Length of the measurement, s.
    #[serde(default = "five")]
    pub duration_s: Duration,
    #[serde(default = "fifo")]
    pub scheduling: Scheduling,
    /// Length of each topic's messages, bytes.
    pub topics: BTreeMap<String, u64>,
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub chains: Vec<Chain>,
    #[serde(default)]
    pub faults: Vec<Fault>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Node {
    pub name: Name,
    /// CPU; without the key the last that this process may use.
    pub core: Option<Core>,
    /// Priority under SCHED_FIFO.
    #[serde(default = "eighty")]
    pub priority: Priority,
    /// A second process of the node waits to take over.
    #[serde(default)]
    pub standby: bool,
    /// Period of its timer.
    pub period_ms: Option<f64>,
    /// Topics that release it, each with a new message.
    #[serde(default)]
    pub trigger: Vec<String>,
    /// Topics of which it takes the newest message.
    #[serde(default)]
    pub reads: Vec<String>,
    #[serde(default)]
    pub publishes: Vec<String>,
    /// Processor time of a cycle.
    #[serde(default)]
    pub load_us: f64,
    /// Command of a program that computes in place of the load.
    pub program: Option<String>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    pub name: Line,
    /// Nodes from the source to the last one.
    pub path: Vec<String>,
    pub deadline_ms: Option<f64>,
    /// Late reactions that are accepted.
    #[serde(default)]
    pub max_misses: u64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Fault {
    Kill {
        node: String,
        at_s: Time,
    },
    Stop {
        node: String,
        at_s: Time,
        for_s: Duration,
    },
    /// Messages of a topic reach their readers later.
    Delay {
        topic: String,
        at_s: Time,
        for_s: Duration,
        delay_ms: DelayMs,
    },
}

fn five() -> Duration {
    Duration::of(5.0)
}

fn fifo() -> Scheduling {
    Scheduling::Fifo
}

fn eighty() -> Priority {
    Priority::of(80)
}

/// Most nodes, and most chains.
pub const MOST: usize = 100;
/// Shortest and longest message, bytes.
const BYTES: (f64, f64) = (1.0, (16 << 20) as f64);
/// Shortest and longest period or deadline, ms.
const PERIOD_MS: (f64, f64) = (0.05, 60_000.0);

/// ns of a time in ms.
pub fn ns(ms: f64) -> i64 {
    (1e6 * ms).round() as i64
}

impl Node {
    /// All topics that it reads, the triggers first.
    pub fn inputs(&self) -> impl Iterator<Item = &String> {
        let others = self.reads.iter().filter(|topic| !self.trigger.contains(topic));
        self.trigger.iter().chain(others)
    }

    pub fn load_ns(&self) -> i64 {
        ns(self.load_us / 1e3)
    }
}

impl Chain {
    pub fn deadline_ns(&self) -> Option<i64> {
        self.deadline_ms.map(ns)
    }
}

impl Fault {
    /// The node that it acts on.
    pub fn node(&self) -> Option<&String> {
        match self {
            Self::Kill { node, .. } | Self::Stop { node, .. } => Some(node),
            Self::Delay { .. } => None,
        }
    }

    /// Run time of its begin and its end, ns.
    pub fn span_ns(&self) -> (i64, i64) {
        let (at_s, for_ns) = match self {
            Self::Kill { at_s, .. } => (at_s, 0),
            Self::Stop { at_s, for_s, .. } | Self::Delay { at_s, for_s, .. } => {
                (at_s, for_s.nanoseconds())
            }
        };
        let at_ns = at_s.nanoseconds();
        (at_ns.cast_signed(), (at_ns + for_ns).cast_signed())
    }
}

impl Graph {
    /// Reads the text of a graph. `source` stands for it in errors.
    pub fn parse(source: &str, text: &str) -> Result<Self, ScenarioError> {
        scenario::read_as(source, text, Self::check)
    }

    /// Place of the node of this name.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.name.as_str() == name)
    }

    pub fn writer(&self, topic: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.publishes.iter().any(|one| one == topic))
    }

    pub fn readers(&self, topic: &str) -> impl Iterator<Item = (usize, &Node)> {
        let reads = move |(_, node): &(usize, &Node)| node.inputs().any(|one| one == topic);
        self.nodes.iter().enumerate().filter(reads)
    }

    /// Topic that leads a chain from its node at `place` to the next.
    pub fn link(&self, chain: usize, place: usize) -> Option<&String> {
        let path = &self.chains[chain].path;
        let from = &self.nodes[self.node(path.get(place)?)?];
        let to = &self.nodes[self.node(path.get(place + 1)?)?];
        to.inputs().find(|topic| from.publishes.contains(topic))
    }

    /// Chains that go over a topic, each with its number of nodes up to there.
    pub fn chains_over(&self, topic: &str) -> impl Iterator<Item = (usize, usize)> {
        (0..self.chains.len()).filter_map(move |chain| {
            let mut places = 0..self.chains[chain].path.len();
            let place = places.find(|place| self.link(chain, *place).is_some_and(|t| t == topic));
            Some((chain, place? + 1))
        })
    }

    fn check(&self) -> Result<(), Problem> {
        for (key, count) in [("nodes", self.nodes.len()), ("chains", self.chains.len())] {
            if count > MOST || (count == 0 && key == "nodes") {
                return Err(Problem::new(key, format!("{count} {key}"), format!("1 to {MOST}")));
            }
        }
        for (topic, bytes) in &self.topics {
            let good = |c: char| c.is_ascii_alphanumeric() || "/_-".contains(c);
            if !(1..=100).contains(&topic.len()) || !topic.chars().all(good) {
                let message = format!("`{}` names no topic", topic.escape_debug());
                let expected = "1 to 100 letters, digits, `/`, `_` or `-`";
                return Err(Problem::new("topics", message, expected));
            }
            within(&format!("topics.{topic}"), *bytes as f64, BYTES, "bytes")?;
        }
        (0..self.nodes.len()).try_for_each(|node| self.check_node(node))?;
        self.check_releases()?;
        (0..self.chains.len()).try_for_each(|chain| self.check_chain(chain))?;
        for (index, fault) in self.faults.iter().enumerate() {
            if let Some(name) = fault.node() {
                self.known_node(&format!("faults.{index}.node"), name)?;
            }
            if let Fault::Delay { topic, .. } = fault {
                self.known_topic(&format!("faults.{index}.topic"), topic)?;
            }
        }
        Ok(())
    }

    fn check_node(&self, index: usize) -> Result<(), Problem> {
        let (path, node) = (format!("nodes.{index}"), &self.nodes[index]);
        let name = node.name.as_str();
        if self.node(name) != Some(index) {
            let message = format!("a second node `{name}`");
            return Err(Problem::new(format!("{path}.name"), message, "another name"));
        }
        within(&format!("{path}.load_us"), node.load_us, (0.0, 10e6), "µs")?;
        match (node.period_ms, node.trigger.is_empty()) {
            (Some(period_ms), true) => {
                within(&format!("{path}.period_ms"), period_ms, PERIOD_MS, "ms")?;
            }
            (Some(_), false) => {
                let message = format!("`{name}` has a period and a trigger");
                let expected = "one of both; a topic that releases nothing belongs into `reads`";
                return Err(Problem::new(format!("{path}.trigger"), message, expected));
            }
            (None, true) => {
                let expected = "`period_ms`, or `trigger` with the topics that release it";
                return Err(Problem::new(path, format!("`{name}` is never released"), expected));
            }
            (None, false) => {}
        }
        if let Some(command) = &node.program {
            let (words, here) = (shlex::split(command), std::env::current_dir());
            let found = runtime::executable(&words.unwrap_or_default(), &here.unwrap_or_default());
            let path = format!("{path}.program");
            found.map_err(|error| Problem::new(path, error.message, error.expected))?;
        }
        for (key, topics) in
            [("trigger", &node.trigger), ("reads", &node.reads), ("publishes", &node.publishes)]
        {
            for (place, topic) in topics.iter().enumerate() {
                let path = format!("{path}.{key}.{place}");
                self.known_topic(&path, topic)?;
                if topics[..place].contains(topic) {
                    let message = format!("`{topic}` is there twice");
                    return Err(Problem::new(path, message, "each topic once"));
                }
                match self.writer(topic) {
                    None => {
                        let written = self.nodes.iter().flat_map(|node| &node.publishes);
                        let expected = accepted(topic, written.map(String::as_str));
                        let message = format!("no node publishes `{topic}`");
                        return Err(Problem::new(path, message, expected));
                    }
                    Some(writer) if key == "publishes" && writer != index => {
                        let other = self.nodes[writer].name.as_str();
                        let message = format!("`{other}` publishes `{topic}` too");
                        return Err(Problem::new(path, message, "one writer for each topic"));
                    }
                    Some(_) => {}
                }
            }
        }
        Ok(())
    }

    /// Refuses nodes that no timer ever releases: they wait for each other.
    fn check_releases(&self) -> Result<(), Problem> {
        let mut sent: BTreeSet<&String> = BTreeSet::new();
        let runs =
            |node: &Node, sent: &BTreeSet<&String>| node.trigger.iter().all(|t| sent.contains(t));
        // Each round releases what the topics of the last one trigger.
        for _ in &self.nodes {
            let ran = self.nodes.iter().filter(|node| runs(node, &sent));
            sent = ran.flat_map(|node| &node.publishes).collect();
        }
        let stuck: Vec<_> = self.nodes.iter().filter(|node| !runs(node, &sent)).collect();
        let Some(first) = stuck.first() else { return Ok(()) };
        let path = format!("nodes.{}.trigger", self.node(first.name.as_str()).unwrap_or_default());
        let names: Vec<_> = stuck.iter().map(|node| format!("`{}`", node.name.as_str())).collect();
        let names = names.join(", ");
        let message = format!("a cycle that nothing starts: {names} wait for each other");
        let expected = "a node with `period_ms` in it, or a topic in `reads` that need not release";
        Err(Problem::new(path, message, expected))
    }

    fn check_chain(&self, index: usize) -> Result<(), Problem> {
        let (path, chain) = (format!("chains.{index}"), &self.chains[index]);
        if let Some(deadline_ms) = chain.deadline_ms {
            within(&format!("{path}.deadline_ms"), deadline_ms, PERIOD_MS, "ms")?;
        }
        let names = &chain.path;
        if names.len() < 2 {
            let message = format!("a chain of {} nodes", names.len());
            return Err(Problem::new(format!("{path}.path"), message, "two nodes or more"));
        }
        for (place, name) in names.iter().enumerate() {
            let path = format!("{path}.path.{place}");
            let node = self.known_node(&path, name)?;
            if names[..place].contains(name) {
                let message = format!("`{name}` is there twice");
                return Err(Problem::new(path, message, "each node once"));
            }
            if place > 0 && self.link(index, place - 1).is_none() {
                let before = &names[place - 1];
                let sent = &self.nodes[self.node(before).unwrap_or(node)].publishes;
                let message = format!("`{name}` reads nothing that `{before}` publishes");
                let expected = match sent.as_slice() {
                    [] => format!("`{before}` to publish a topic that `{name}` reads"),
                    sent => format!("`{name}` to read `{}`", sent.join("` or `")),
                };
                return Err(Problem::new(path, message, expected));
            }
        }
        Ok(())
    }

    fn known_node(&self, path: &str, name: &str) -> Result<usize, Problem> {
        known(path, "node", name, self.nodes.iter().map(|node| node.name.as_str()))
    }

    fn known_topic(&self, path: &str, topic: &str) -> Result<usize, Problem> {
        known(path, "topic", topic, self.topics.keys().map(String::as_str))
    }
}

/// Place of a name among those that are known.
fn known<'a>(
    path: &str,
    what: &str,
    name: &str,
    all: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Problem> {
    all.clone().position(|one| one == name).ok_or_else(|| {
        let message = format!("unknown {what} `{}`", name.escape_debug());
        Problem::new(path, message, accepted(name, all))
    })
}

fn within(path: &str, value: f64, (low, high): (f64, f64), unit: &str) -> Result<(), Problem> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Problem::new(path, format!("{value} is out of range"), format!("{low} to {high} {unit}")))
}
