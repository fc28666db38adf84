//! The graph that is run: a file whose names are resolved, with the rules of a graph.
//!
//! * A topic has one writer.
//! * Each callback is released, directly or not, by a node with a period.
//! * Each node of a chain reads what the node before it publishes.

use crate::file::{FaultTable, File, unknown};
use bench::setup::Scheduling;
use scenario::{Problem, ScenarioError, accepted};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Graph {
    pub name: String,
    pub description: String,
    pub duration_s: f64,
    pub scheduling: Scheduling,
    pub topics: Vec<Topic>,
    pub nodes: Vec<Node>,
    pub chains: Vec<Chain>,
    pub faults: Vec<Fault>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Topic {
    pub name: String,
    pub bytes: usize,
    /// Node that publishes it; none: nothing does.
    pub writer: Option<usize>,
    /// Nodes that read it.
    pub readers: Vec<usize>,
    /// Nodes that it helps to release.
    pub releases: Vec<usize>,
    /// Chains that go over it, each with its number of nodes up to here.
    pub chains: Vec<(usize, usize)>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    pub name: String,
    pub core: Option<usize>,
    pub priority: u8,
    pub standby: bool,
    /// Words of its program's command; empty: it spins.
    pub program: Vec<String>,
    pub callbacks: Vec<Callback>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Callback {
    /// Period of its timer, ns; `None`: its triggers release it.
    pub period_ns: Option<i64>,
    /// Topics of which each must have a new message.
    pub trigger: Vec<usize>,
    /// All topics that it reads, the triggers first.
    pub reads: Vec<usize>,
    pub publishes: Vec<usize>,
    pub load_ns: i64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    pub name: String,
    pub path: Vec<Hop>,
    pub deadline_ns: Option<i64>,
    pub max_misses: u64,
}

/// A node on a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hop {
    pub node: usize,
    pub callback: usize,
    /// Topic that brings the chain here; none at its source.
    pub topic: Option<usize>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    pub at_ns: i64,
    /// Its length, ns; 0 for a kill.
    pub for_ns: i64,
    pub act: Act,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Act {
    Kill(usize),
    Stop(usize),
    /// Topic, and the delay of its messages, ns.
    Delay(usize, i64),
    Hog(Option<u16>),
}

/// Priority of a node without one of its own: the controller's neighbourhood in a car's group.
const PRIORITY: u8 = 80;

impl Graph {
    /// Reads the text of a graph. `source` stands for it in errors.
    pub fn parse(source: &str, text: &str) -> Result<Self, ScenarioError> {
        let mut graph = None;
        scenario::read_as(source, text, |file: &File| {
            file.check()?;
            graph = Some(Self::of(file)?);
            Ok(())
        })?;
        Ok(graph.expect("the check resolved it"))
    }

    fn of(file: &File) -> Result<Self, Problem> {
        let topic = |name: &String| file.topics.keys().position(|known| known == name);
        let topics = |names: &[String]| -> Vec<usize> { names.iter().filter_map(topic).collect() };
        let mut graph = Self {
            name: file.name.as_str().to_owned(),
            description: file.description.as_str().to_owned(),
            duration_s: file.duration_s.value(),
            scheduling: file.scheduling,
            topics: (file.topics.iter())
                .map(|(name, bytes)| Topic {
                    name: name.clone(),
                    bytes: *bytes as usize,
                    writer: None,
                    readers: Vec::new(),
                    releases: Vec::new(),
                    chains: Vec::new(),
                })
                .collect(),
            nodes: Vec::new(),
            chains: Vec::new(),
            faults: Vec::new(),
        };
        let mut paths = Vec::new();
        for (index, table) in file.nodes.iter().enumerate() {
            let path = format!("nodes.{index}");
            let program = match &table.program {
                None => Vec::new(),
                Some(command) => words(&format!("{path}.program"), command)?,
            };
            let callbacks = table.paths(&path);
            let callback = |(_, table): &(String, crate::file::CallbackTable)| {
                let trigger = topics(table.trigger.as_deref().unwrap_or_default());
                let others = topics(&table.reads).into_iter().filter(|one| !trigger.contains(one));
                Callback {
                    period_ns: table.period_ms.map(ns),
                    reads: trigger.iter().copied().chain(others).collect(),
                    trigger,
                    publishes: topics(&table.publishes),
                    load_ns: ns(table.load_us / 1e3),
                }
            };
            graph.nodes.push(Node {
                name: table.name.as_str().to_owned(),
                core: table.core.map(|core| core.value().into()),
                priority: table.priority.map_or(PRIORITY, |priority| priority.value()),
                standby: table.standby,
                program,
                callbacks: callbacks.iter().map(callback).collect(),
            });
            paths.push(callbacks.into_iter().map(|(path, _)| path).collect::<Vec<_>>());
        }
        graph.connect(&paths)?;
        graph.check_releases(&paths)?;
        for (index, table) in file.chains.iter().enumerate() {
            let path = graph.path(&format!("chains.{index}.path"), &table.path)?;
            for (place, hops) in path.windows(2).enumerate() {
                let topic = hops[1].topic.expect("each node but the first has one");
                graph.topics[topic].chains.push((index, place + 1));
            }
            graph.chains.push(Chain {
                name: table.name.as_str().to_owned(),
                path,
                deadline_ns: table.deadline_ms.map(ns),
                max_misses: table.max_misses,
            });
        }
        for (index, table) in file.faults.iter().enumerate() {
            let fault = graph.fault(&format!("faults.{index}"), table)?;
            graph.faults.push(fault);
        }
        Ok(graph)
    }

    /// Names of all nodes.
    pub fn names(&self) -> Vec<String> {
        self.nodes.iter().map(|node| node.name.clone()).collect()
    }

    /// Notes writers and readers of each topic.
    fn connect(&mut self, paths: &[Vec<String>]) -> Result<(), Problem> {
        for (index, node) in self.nodes.iter().enumerate() {
            for (callback, path) in node.callbacks.iter().zip(&paths[index]) {
                for (place, &topic) in callback.publishes.iter().enumerate() {
                    let topic = &mut self.topics[topic];
                    if let Some(writer) = topic.writer.replace(index) {
                        let other = &self.nodes[writer].name;
                        let message = format!("`{other}` publishes `{}` too", topic.name);
                        let path = format!("{path}.publishes.{place}");
                        return Err(Problem::new(path, message, "one writer for each topic"));
                    }
                }
                for &topic in &callback.reads {
                    let Topic { readers, releases, .. } = &mut self.topics[topic];
                    if !readers.contains(&index) {
                        readers.push(index);
                    }
                    if callback.trigger.contains(&topic) && !releases.contains(&index) {
                        releases.push(index);
                    }
                }
            }
        }
        let written = self.topics.iter().filter(|topic| topic.writer.is_some());
        let written: Vec<String> = written.map(|topic| topic.name.clone()).collect();
        for (callback, path) in self.callbacks(paths) {
            let unwritten = |topic: &&usize| self.topics[**topic].writer.is_none();
            if let Some(&topic) = callback.reads.iter().find(unwritten) {
                let name = &self.topics[topic].name;
                let key = if callback.trigger.contains(&topic) { "trigger" } else { "reads" };
                let expected = accepted(name, written.iter().map(String::as_str));
                let message = format!("no node publishes `{name}`");
                return Err(Problem::new(format!("{path}.{key}"), message, expected));
            }
        }
        Ok(())
    }

    fn callbacks<'a>(
        &'a self,
        paths: &'a [Vec<String>],
    ) -> impl Iterator<Item = (&'a Callback, &'a String)> {
        self.nodes.iter().zip(paths).flat_map(|(node, paths)| node.callbacks.iter().zip(paths))
    }

    /// Refuses callbacks that no timer ever releases: they wait for each other.
    fn check_releases(&self, paths: &[Vec<String>]) -> Result<(), Problem> {
        let mut sent: BTreeSet<usize> = BTreeSet::new();
        loop {
            let runs = |callback: &Callback| callback.trigger.iter().all(|t| sent.contains(t));
            let ran = self.callbacks(paths).filter(|(callback, _)| runs(callback));
            let more: BTreeSet<usize> = ran.flat_map(|(c, _)| c.publishes.clone()).collect();
            if more.len() == sent.len() {
                break;
            }
            sent = more;
        }
        let is_stuck = |callback: &Callback| callback.trigger.iter().any(|t| !sent.contains(t));
        let stuck: Vec<_> = self.callbacks(paths).filter(|(c, _)| is_stuck(c)).collect();
        let Some((_, path)) = stuck.first() else { return Ok(()) };
        let named = self.nodes.iter().filter(|node| node.callbacks.iter().any(is_stuck));
        let named: Vec<_> = named.map(|node| format!("`{}`", node.name)).collect();
        let message =
            format!("a cycle that nothing starts: {} wait for each other", named.join(", "));
        let expected = "a node with `period_ms` in it, or a topic in `reads` that need not release";
        Err(Problem::new(format!("{path}.trigger"), message, expected))
    }

    /// The nodes of a chain, with the callbacks and topics that connect them.
    fn path(&self, path: &str, names: &[String]) -> Result<Vec<Hop>, Problem> {
        if names.len() < 2 {
            return Err(Problem::new(path, format!("{} nodes", names.len()), "two nodes or more"));
        }
        let known = self.names();
        let mut nodes = Vec::new();
        for (place, name) in names.iter().enumerate() {
            let path = format!("{path}.{place}");
            let node = known.iter().position(|known| known == name);
            nodes.push(node.ok_or_else(|| unknown(&path, "node", name, known.iter()))?);
            if names[..place].contains(name) {
                let message = format!("`{name}` is there twice");
                return Err(Problem::new(path, message, "each node once"));
            }
        }
        let mut reached = 0;
        let first = 0..self.nodes[nodes[0]].callbacks.len();
        let found = first.into_iter().find_map(|callback| {
            let hop = Hop { node: nodes[0], callback, topic: None };
            self.follow(vec![hop], &nodes, &mut reached)
        });
        found.ok_or_else(|| {
            let [before, after] = [&names[reached], &names[reached + 1]];
            let sent = self.nodes[nodes[reached]].callbacks.iter().flat_map(|c| &c.publishes);
            let sent: Vec<_> =
                sent.map(|&topic| format!("`{}`", self.topics[topic].name)).collect();
            let expected = match sent.as_slice() {
                [] => format!("`{before}` to publish a topic that `{after}` reads"),
                sent => format!("`{after}` to read {}", sent.join(" or ")),
            };
            let message = format!("`{after}` reads nothing that `{before}` publishes");
            Problem::new(format!("{path}.{}", reached + 1), message, expected)
        })
    }

    /// The rest of a chain's nodes behind `hops`; `reached` is the longest way that was found.
    fn follow(&self, hops: Vec<Hop>, nodes: &[usize], reached: &mut usize) -> Option<Vec<Hop>> {
        *reached = (*reached).max(hops.len() - 1);
        let Some(&node) = nodes.get(hops.len()) else { return Some(hops) };
        let last = hops.last().expect("the source");
        let sent = &self.nodes[last.node].callbacks[last.callback].publishes;
        (self.nodes[node].callbacks.iter().enumerate()).find_map(|(callback, reader)| {
            let topic = reader.reads.iter().copied().find(|topic| sent.contains(topic));
            let hop = Hop { node, callback, topic: Some(topic?) };
            self.follow([&hops[..], &[hop]].concat(), nodes, reached)
        })
    }

    fn fault(&self, path: &str, table: &FaultTable) -> Result<Fault, Problem> {
        let names = self.names();
        let node = |name: &String| {
            let found = names.iter().position(|known| known == name);
            found.ok_or_else(|| unknown(&format!("{path}.node"), "node", name, names.iter()))
        };
        let (at_s, for_ns, act) = match table {
            FaultTable::Kill { node: name, at_s } => (at_s, 0, Act::Kill(node(name)?)),
            FaultTable::Stop { node: name, at_s, for_s } => {
                (at_s, for_s.nanoseconds(), Act::Stop(node(name)?))
            }
            FaultTable::Delay { topic, at_s, for_s, delay_ms } => {
                let known = self.topics.iter().map(|topic| &topic.name);
                let found = known.clone().position(|known| known == topic);
                let path = format!("{path}.topic");
                let found = found.ok_or_else(|| unknown(&path, "topic", topic, known))?;
                let delay_ns = delay_ms.nanoseconds().cast_signed();
                (at_s, for_s.nanoseconds(), Act::Delay(found, delay_ns))
            }
            FaultTable::Hog { core, at_s, for_s } => {
                (at_s, for_s.nanoseconds(), Act::Hog(core.map(|core| core.value())))
            }
        };
        let (at_ns, for_ns) = (at_s.nanoseconds().cast_signed(), for_ns.cast_signed());
        Ok(Fault { at_ns, for_ns, act })
    }
}

fn ns(ms: f64) -> i64 {
    (1e6 * ms).round() as i64
}

/// The words of a command.
fn words(path: &str, command: &str) -> Result<Vec<String>, Problem> {
    let expected = "a command as a shell reads it, of a program that can be run";
    let words = shlex::split(command).unwrap_or_default();
    let here = std::env::current_dir().unwrap_or_default();
    match runtime::executable(&words, &here) {
        Ok(program) => {
            let program = program.to_string_lossy().into_owned();
            Ok(std::iter::once(program).chain(words.into_iter().skip(1)).collect())
        }
        Err(error) => Err(Problem::new(path, error.message(), expected)),
    }
}
