//! The graph of a file: its tables and keys (docs/graph.md shows one), and its rules.
//!
//! * A topic has one writer.
//! * Each node is released, directly or not, by a node with a period.
//! * Each node of a chain reads what the node before it publishes.

use bench::setup::Scheduling;
use scenario::name::{Line, Name};
use scenario::quantity::{Core, DelayMs, Duration, LoadUs, LoopMs, MessageBytes, Priority, Time};
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
    #[serde(default)]
    pub scheduling: Scheduling,
    /// Length of each topic's messages, bytes.
    pub topics: BTreeMap<String, MessageBytes>,
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
    /// Priority under SCHED_FIFO; without the key 80.
    pub priority: Option<Priority>,
    /// A second process of the node waits to take over.
    #[serde(default)]
    pub standby: bool,
    /// Period of its timer.
    pub period_ms: Option<LoopMs>,
    /// Topics that release it, each with a new message.
    #[serde(default)]
    pub trigger: Vec<String>,
    /// Topics of which it takes the newest message.
    #[serde(default)]
    pub reads: Vec<String>,
    #[serde(default)]
    pub publishes: Vec<String>,
    /// Processor time of a cycle.
    pub load_us: Option<LoadUs>,
    /// Command of a program that computes in place of the load.
    pub program: Option<String>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    pub name: Line,
    /// Nodes from the source to the last one.
    pub path: Vec<String>,
    pub deadline_ms: Option<LoopMs>,
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

/// Most nodes, and most chains.
pub const MOST: usize = 100;
impl Node {
    /// All topics that it reads, the triggers first.
    pub fn inputs(&self) -> impl Iterator<Item = &String> {
        let others = self.reads.iter().filter(|topic| !self.trigger.contains(topic));
        self.trigger.iter().chain(others)
    }

    pub fn load_ns(&self) -> i64 {
        self.load_us.map_or(0, |load| load.nanoseconds().cast_signed())
    }

    pub fn period_ns(&self) -> Option<i64> {
        self.period_ms.map(|period| period.nanoseconds().cast_signed())
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
        let (at_s, for_s) = match self {
            Self::Kill { at_s, .. } => (at_s, None),
            Self::Stop { at_s, for_s, .. } | Self::Delay { at_s, for_s, .. } => (at_s, Some(for_s)),
        };
        let begin_ns = at_s.nanoseconds().cast_signed();
        (begin_ns, begin_ns + for_s.map_or(0, |for_s| for_s.nanoseconds().cast_signed()))
    }
}

impl Graph {
    /// Reads the text of a graph. `source` stands for it in errors.
    pub fn parse(source: &str, text: &str) -> Result<Self, ScenarioError> {
        scenario::read_as(source, text, Self::check)
    }

    /// Length of the measurement.
    pub fn length_ns(&self) -> i64 {
        self.duration_s.nanoseconds().cast_signed()
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
        (0..self.nodes.len()).try_for_each(|node| self.check_node(node))?;
        self.topics.keys().try_for_each(|topic| self.check_topic(topic))?;
        self.check_releases()?;
        (0..self.chains.len()).try_for_each(|chain| self.check_chain(chain))?;
        for (index, fault) in self.faults.iter().enumerate() {
            match fault {
                Fault::Kill { node, .. } | Fault::Stop { node, .. } => {
                    known(&format!("faults.{index}.node"), "node", node, self.node_names())?;
                }
                Fault::Delay { topic, .. } => {
                    known(&format!("faults.{index}.topic"), "topic", topic, self.topic_names())?;
                }
            }
        }
        Ok(())
    }

    fn check_topic(&self, topic: &str) -> Result<(), Problem> {
        let good = |c: char| c.is_ascii_alphanumeric() || "/_-".contains(c);
        if !(1..=100).contains(&topic.len()) || !topic.chars().all(good) {
            let message = format!("`{}` names no topic", topic.escape_debug());
            let expected = "1 to 100 letters, digits, `/`, `_` or `-`";
            return Err(Problem::new("topics", message, expected));
        }
        let is_writer = |node: &usize| self.nodes[*node].publishes.iter().any(|one| one == topic);
        let writers: Vec<usize> = (0..self.nodes.len()).filter(is_writer).collect();
        let (place, message) = match writers[..] {
            [_] => return Ok(()),
            [] => (format!("topics.{topic}"), format!("no node publishes `{topic}`")),
            [first, second, ..] => {
                let first = self.nodes[first].name.as_str();
                (format!("nodes.{second}.publishes"), format!("`{first}` publishes `{topic}` too"))
            }
        };
        Err(Problem::new(place, message, "one writer for each topic"))
    }

    fn check_node(&self, index: usize) -> Result<(), Problem> {
        let (path, node) = (format!("nodes.{index}"), &self.nodes[index]);
        let name = node.name.as_str();
        if self.node(name) != Some(index) {
            let message = format!("a second node `{name}`");
            return Err(Problem::new(format!("{path}.name"), message, "another name"));
        }
        if node.period_ms.is_some() != node.trigger.is_empty() {
            let message = format!("`{name}` has neither a period nor a trigger, or both");
            let expected = "`period_ms`, or `trigger` with topics (others belong into `reads`)";
            return Err(Problem::new(path, message, expected));
        }
        if let Some(command) = &node.program {
            let (words, here) = (shlex::split(command), std::env::current_dir());
            let found = runtime::executable(&words.unwrap_or_default(), &here.unwrap_or_default());
            let path = format!("{path}.program");
            found.map_err(|error| Problem::new(path, error.message, error.expected))?;
        }
        let lists =
            [("trigger", &node.trigger), ("reads", &node.reads), ("publishes", &node.publishes)];
        for (key, topics) in lists {
            check_names(&format!("{path}.{key}"), "topic", topics, self.topic_names())?;
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
        let stuck = self.nodes.iter().filter(|node| !runs(node, &sent));
        let stuck: Vec<&str> = stuck.map(|node| node.name.as_str()).collect();
        let Some(first) = stuck.first().and_then(|name| self.node(name)) else { return Ok(()) };
        let names = stuck.join("`, `");
        let message = format!("a cycle that nothing starts: `{names}` wait for each other");
        let expected = "a node with `period_ms` in it, or a topic in `reads` that need not release";
        Err(Problem::new(format!("nodes.{first}.trigger"), message, expected))
    }

    fn check_chain(&self, index: usize) -> Result<(), Problem> {
        let (path, names) = (format!("chains.{index}.path"), &self.chains[index].path);
        if names.len() < 2 {
            let message = format!("a chain of {} nodes", names.len());
            return Err(Problem::new(path, message, "two nodes or more"));
        }
        let is_known = |at: usize| self.node(&names[at]).is_some();
        let is_apart =
            |at: &usize| is_known(at - 1) && is_known(*at) && self.link(index, at - 1).is_none();
        let Some(place) = (1..names.len()).find(is_apart) else {
            return check_names(&path, "node", names, self.node_names());
        };
        let (before, name) = (&names[place - 1], &names[place]);
        let sent = self.node(before).map_or(&[][..], |node| &self.nodes[node].publishes);
        let message = format!("`{name}` reads nothing that `{before}` publishes");
        let expected = match sent {
            [] => format!("`{before}` to publish a topic that `{name}` reads"),
            sent => format!("`{name}` to read `{}`", sent.join("` or `")),
        };
        Err(Problem::new(format!("{path}.{place}"), message, expected))
    }

    fn node_names(&self) -> impl Iterator<Item = &str> + Clone {
        self.nodes.iter().map(|node| node.name.as_str())
    }

    fn topic_names(&self) -> impl Iterator<Item = &str> + Clone {
        self.topics.keys().map(String::as_str)
    }
}

/// Refuses a name at `path` that is not among `all`.
fn known<'a>(
    path: &str,
    what: &str,
    name: &str,
    all: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), Problem> {
    if all.clone().any(|one| one == name) {
        return Ok(());
    }
    let message = format!("unknown {what} `{}`", name.escape_debug());
    Err(Problem::new(path, message, accepted(name, all)))
}

/// Refuses names in a list that are not among `all`, or are there twice.
fn check_names<'a>(
    path: &str,
    what: &str,
    names: &[String],
    all: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), Problem> {
    for (place, name) in names.iter().enumerate() {
        let path = format!("{path}.{place}");
        known(&path, what, name, all.clone())?;
        if names[..place].contains(name) {
            let message = format!("`{name}` is there twice");
            return Err(Problem::new(path, message, format!("each {what} once")));
        }
    }
    Ok(())
}
