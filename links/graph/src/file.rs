//! The file of a graph, as it is written: tables and keys.
//!
//! ```toml
//! name = "camera-to-brake"
//! topics = { image = 65536, objects = 512 }   # bytes of a message
//!
//! [[nodes]]
//! name = "camera"
//! period_ms = 10                # released by a timer
//! load_us = 300                 # processor time of a cycle
//! publishes = ["image"]
//!
//! [[nodes]]
//! name = "detect"
//! trigger = ["image"]           # released when each of these topics has a new message
//! load_us = 2000
//! publishes = ["objects"]
//! standby = true                # a second process takes over when this one ends or hangs
//!
//! [[nodes]]
//! name = "brake"
//! period_ms = 5
//! reads = ["objects"]           # takes the newest message at its release
//!
//! [[chains]]
//! name = "camera to brake"
//! path = ["camera", "detect", "brake"]
//! deadline_ms = 30
//!
//! [[faults]]
//! kind = "kill"                 # or "stop", "delay", "hog"
//! node = "detect"
//! at_s = 2
//! ```

use bench::setup::Scheduling;
use scenario::name::{Line, Name};
use scenario::quantity::{Core, DelayMs, Duration, Priority, Time};
use scenario::{Problem, accepted};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    /// Version of the schema: 1.
    #[serde(default = "one")]
    pub schema_version: u32,
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
    pub nodes: Vec<NodeTable>,
    #[serde(default)]
    pub chains: Vec<ChainTable>,
    #[serde(default)]
    pub faults: Vec<FaultTable>,
}

/// A node: a process with one callback, whose keys stand here, or with several.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeTable {
    pub name: Name,
    /// CPU; without the key the last that this process may use.
    pub core: Option<Core>,
    /// Priority under SCHED_FIFO.
    pub priority: Option<Priority>,
    /// A second process of the node waits to take over.
    #[serde(default)]
    pub standby: bool,
    /// Command of a program that computes in place of the load.
    pub program: Option<String>,
    pub period_ms: Option<f64>,
    pub trigger: Option<Vec<String>>,
    #[serde(default)]
    pub reads: Vec<String>,
    #[serde(default)]
    pub publishes: Vec<String>,
    #[serde(default)]
    pub load_us: f64,
    #[serde(default)]
    pub callbacks: Vec<CallbackTable>,
}

/// One of several callbacks of a node. They run one after the other.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CallbackTable {
    pub period_ms: Option<f64>,
    pub trigger: Option<Vec<String>>,
    #[serde(default)]
    pub reads: Vec<String>,
    #[serde(default)]
    pub publishes: Vec<String>,
    #[serde(default)]
    pub load_us: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainTable {
    pub name: Line,
    /// Nodes from the source to the last one.
    pub path: Vec<String>,
    pub deadline_ms: Option<f64>,
    /// Late reactions that are accepted.
    #[serde(default)]
    pub max_misses: u64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FaultTable {
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
    /// A process that computes takes a core, or all.
    Hog {
        core: Option<Core>,
        at_s: Time,
        for_s: Duration,
    },
}

fn one() -> u32 {
    1
}

fn five() -> Duration {
    Duration::of(5.0)
}

fn fifo() -> Scheduling {
    Scheduling::Fifo
}

/// Most nodes, and most chains.
pub const MOST: usize = 100;
/// Longest message, bytes.
const LONGEST: u64 = 16 << 20;

impl File {
    /// Compares numbers and words with what can be run. The graph's own rules stand in [`crate::plan`].
    pub fn check(&self) -> Result<(), Problem> {
        let version = self.schema_version;
        if version != 1 {
            let message = format!("version {version} of the schema is not known");
            return Err(Problem::new("schema_version", message, "1"));
        }
        for (key, count) in [("nodes", self.nodes.len()), ("chains", self.chains.len())] {
            if count > MOST || (count == 0 && key == "nodes") {
                let expected = format!("1 to {MOST}");
                return Err(Problem::new(key, format!("{count} {key}"), expected));
            }
        }
        for (topic, bytes) in &self.topics {
            let good = |c: char| c.is_ascii_alphanumeric() || "/_-".contains(c);
            if topic.is_empty() || topic.len() > 100 || !topic.chars().all(good) {
                let message = format!("`{}` names no topic", topic.escape_debug());
                let expected = "1 to 100 letters, digits, `/`, `_` or `-`";
                return Err(Problem::new("topics", message, expected));
            }
            let path = format!("topics.{topic}");
            within(&path, *bytes as f64, (1.0, LONGEST as f64), "bytes")?;
        }
        for (index, node) in self.nodes.iter().enumerate() {
            let path = format!("nodes.{index}");
            let is_twice = |other: &NodeTable| other.name == node.name;
            if self.nodes[..index].iter().any(is_twice) {
                let message = format!("a second node `{}`", node.name.as_str());
                return Err(Problem::new(format!("{path}.name"), message, "another name"));
            }
            if node.program.is_some() && !node.callbacks.is_empty() {
                let message = "a program and several callbacks";
                return Err(Problem::new(format!("{path}.program"), message, "one of both"));
            }
            for (path, callback) in node.paths(&path) {
                self.check_callback(&path, node, &callback)?;
            }
        }
        for (index, chain) in self.chains.iter().enumerate() {
            if let Some(deadline_ms) = chain.deadline_ms {
                within(
                    &format!("chains.{index}.deadline_ms"),
                    deadline_ms,
                    (0.01, 60_000.0),
                    "ms",
                )?;
            }
        }
        Ok(())
    }

    fn check_callback(
        &self,
        path: &str,
        node: &NodeTable,
        callback: &CallbackTable,
    ) -> Result<(), Problem> {
        within(&format!("{path}.load_us"), callback.load_us, (0.0, 10e6), "µs")?;
        let released = "`period_ms`, or `trigger` with the topics that release it";
        let name = node.name.as_str();
        match (callback.period_ms, &callback.trigger) {
            (Some(period_ms), None) => {
                within(&format!("{path}.period_ms"), period_ms, (0.05, 60_000.0), "ms")?;
            }
            (None, Some(topics)) if !topics.is_empty() => {}
            (Some(_), Some(_)) => {
                let message = format!("`{name}` has a period and a trigger");
                let expected = "one of both; a topic that releases nothing belongs into `reads`";
                return Err(Problem::new(format!("{path}.trigger"), message, expected));
            }
            (None, _) => {
                return Err(Problem::new(path, format!("`{name}` is never released"), released));
            }
        }
        let lists = [
            ("trigger", callback.trigger.as_deref().unwrap_or_default()),
            ("reads", &callback.reads),
            ("publishes", &callback.publishes),
        ];
        for (key, topics) in lists {
            for (place, topic) in topics.iter().enumerate() {
                let path = format!("{path}.{key}.{place}");
                if !self.topics.contains_key(topic) {
                    return Err(unknown(&path, "topic", topic, self.topics.keys()));
                }
                if topics[..place].contains(topic) {
                    let message = format!("`{topic}` is there twice");
                    return Err(Problem::new(path, message, "each topic once"));
                }
            }
        }
        Ok(())
    }
}

impl NodeTable {
    /// Its callbacks with their paths in the file.
    pub fn paths(&self, path: &str) -> Vec<(String, CallbackTable)> {
        let own = CallbackTable {
            period_ms: self.period_ms,
            trigger: self.trigger.clone(),
            reads: self.reads.clone(),
            publishes: self.publishes.clone(),
            load_us: self.load_us,
        };
        let below = |(index, callback): (usize, &CallbackTable)| {
            (format!("{path}.callbacks.{index}"), callback.clone())
        };
        let is_written = own.period_ms.is_some()
            || own.trigger.is_some()
            || !own.reads.is_empty()
            || !own.publishes.is_empty();
        let own = (self.callbacks.is_empty() || is_written).then(|| (path.to_owned(), own));
        own.into_iter().chain(self.callbacks.iter().enumerate().map(below)).collect()
    }
}

fn within(path: &str, value: f64, (low, high): (f64, f64), unit: &str) -> Result<(), Problem> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let expected = format!("{low} to {high} {unit}");
    Err(Problem::new(path, format!("{value} is out of range"), expected))
}

/// The error of a name that nothing has.
pub fn unknown<'a>(
    path: &str,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a String>,
) -> Problem {
    let expected = accepted(name, known.map(String::as_str));
    Problem::new(path, format!("unknown {what} `{}`", name.escape_debug()), expected)
}
