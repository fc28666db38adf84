//! The ends of a topic at a node: iceoryx2's ports, the end-to-end check, epochs, delays.

use crate::chains::Layout;
use crate::plan::{Fault, Graph, MOST};
use bench::payload::{BytesReceiver, BytesSender, Peers};
use messages::Header;
use runtime::{Count, Figures, Group, Guest, RuntimeError, SharedWords, epoch, monotonic_ns};
use std::collections::VecDeque;
use std::sync::atomic::AtomicU32;
use supervise::{Error, MachineError};

/// Processes of a node that may hold an end at the same time: the active one, its dead self, a standby and the next.
const PROCESSES: usize = 4;
/// Words of a node.
const NODE: usize = 8;

/// The words that all processes of a graph share: wake-ups and epochs of its nodes.
pub struct Page(SharedWords);

impl Page {
    pub fn map(group: &Group) -> Result<Self, MachineError> {
        const { assert!(NODE * MOST <= 1024, "a page has room for all") };
        let page = SharedWords::map(&format!("{}graph", group.prefix));
        page.map(Self).map_err(MachineError::cannot("share memory"))
    }

    /// Counts the messages that help to release a node.
    pub fn wake(&self, node: usize) -> &AtomicU32 {
        &self.0[NODE * node]
    }

    /// Incarnation of the one process of a node that may send.
    pub fn epoch(&self, node: usize) -> &AtomicU32 {
        &self.0[NODE * node + 1]
    }
}

/// A named count of a topic, which all its ends share.
pub fn count(group: &Group, topic: &str, name: &str) -> Result<Count, RuntimeError> {
    Figures::open(group, format!("topic.{}", topic.replace('/', ".")))?.count(name)
}

/// Processes at a topic.
pub fn peers(graph: &Graph, topic: &str) -> Peers {
    let receivers = PROCESSES * graph.readers(topic).count().max(1);
    Peers { senders: PROCESSES, receivers, history: 1 }
}

/// The sending end.
pub struct Output {
    pub layout: Layout,
    port: BytesSender,
    sent: Count,
    /// Nodes that a message helps to release.
    pub releases: Vec<usize>,
}

impl Output {
    pub fn open(
        graph: &Graph,
        topic: &String,
        group: &Group,
        guest: &Guest,
    ) -> Result<Self, Error> {
        let (layout, service) = (Layout::of(graph, topic), format!("graph/{topic}"));
        let port = BytesSender::open(guest, &service, layout.length, peers(graph, topic))?;
        let sent = count(group, topic, "sent")?;
        let released = graph.readers(topic).filter(|(_, node)| node.trigger.contains(topic));
        let releases = released.map(|(node, _)| node).collect();
        Ok(Self { layout, port, sent, releases })
    }

    /// Sends a message with this header and the trails of its chains.
    pub fn send<'a>(
        &mut self,
        mut header: Header,
        trail: impl Fn(usize) -> &'a [i64],
    ) -> Result<(), MachineError> {
        self.sent.add(1);
        header.sequence = self.sent.get();
        self.port.send(|bytes| self.layout.write(bytes, &header, trail))
    }
}

/// A receiving end. It keeps header and trails of the newest message.
pub struct Input {
    pub topic: String,
    pub layout: Layout,
    port: BytesReceiver,
    /// Header and trails of the newest message; empty before the first.
    pub newest: Vec<u8>,
    /// Publication of that message, ns.
    pub sent_ns: i64,
    /// Messages that have come, and those at the last cycle.
    pub arrived: u64,
    pub used: u64,
    /// The writer, if it has a standby.
    fenced: Option<usize>,
    /// Run times between which messages are delayed, and by how much, ns.
    delays: Vec<((i64, i64), i64)>,
    /// Messages whose delay ends at these instants, ns.
    pub delayed: VecDeque<(i64, Vec<u8>)>,
    /// Incarnation and sequence number of the last message.
    last: (u32, u64),
    received: Count,
    /// Messages that newer ones replaced before a cycle used them.
    unused: Count,
    refused: Count,
}

impl Input {
    pub fn open(graph: &Graph, topic: &str, group: &Group, guest: &Guest) -> Result<Self, Error> {
        let delays = graph.faults.iter().filter_map(|fault| match fault {
            Fault::Delay { topic: of, delay_ms, .. } if of == topic => {
                Some((fault.span_ns(), delay_ms.nanoseconds().cast_signed()))
            }
            _ => None,
        });
        Ok(Self {
            topic: topic.to_owned(),
            layout: Layout::of(graph, topic),
            port: BytesReceiver::open(guest, &format!("graph/{topic}"), peers(graph, topic))?,
            newest: Vec::new(),
            sent_ns: 0,
            arrived: 0,
            used: 0,
            fenced: graph.writer(topic).filter(|writer| graph.nodes[*writer].standby),
            delays: delays.collect(),
            delayed: VecDeque::new(),
            last: (0, 0),
            received: count(group, topic, "received")?,
            unused: count(group, topic, "unused")?,
            refused: count(group, topic, "refused")?,
        })
    }

    /// Takes all messages that have come, and those whose delay is over. The run began at `start_ns`.
    pub fn take(&mut self, page: &Page, start_ns: i64) -> Result<(), MachineError> {
        let Self { layout, newest, sent_ns, arrived, delayed, last, .. } = self;
        let mut keep = |bytes: &[u8], published_ns: i64| {
            newest.clear();
            newest.extend_from_slice(bytes);
            (*sent_ns, *arrived) = (published_ns, *arrived + 1);
        };
        self.port.take(|_, bytes| {
            let is_current = |header: &Header| {
                let word = self.fenced.map(|node| page.epoch(node));
                word.is_none_or(|word| epoch::is_present(word, header.incarnation))
            };
            let Some(header) = layout.read(bytes).filter(is_current) else {
                self.refused.add(1);
                return Ok(());
            };
            self.received.add(1);
            if last.0 == header.incarnation && last.1 > 0 {
                self.unused.add(header.sequence.saturating_sub(last.1 + 1));
            }
            *last = (header.incarnation, header.sequence);
            let (bytes, sent_ns) = (&bytes[..layout.used], header.publish_ns);
            let acts =
                |((from, to), _): &&((i64, i64), i64)| (*from..*to).contains(&(sent_ns - start_ns));
            match self.delays.iter().find(acts) {
                None => keep(bytes, sent_ns),
                Some((_, delay_ns)) => delayed.push_back((sent_ns + delay_ns, bytes.to_vec())),
            }
            Ok(())
        })?;
        let now_ns = monotonic_ns();
        while delayed.front().is_some_and(|(until_ns, _)| *until_ns <= now_ns)
            && let Some((_, bytes)) = delayed.pop_front()
        {
            let header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
            keep(&bytes, header.publish_ns);
        }
        Ok(())
    }

    /// Notes that a cycle uses the newest message.
    pub fn use_newest(&mut self) {
        self.unused.add((self.arrived - self.used).saturating_sub(1));
        self.used = self.arrived;
    }

    /// The newest message for the node's program.
    pub fn question(&self, now_ns: i64) -> serde_json::Value {
        let age_us = (now_ns - self.sent_ns) as f64 / 1e3;
        serde_json::json!({"topic": self.topic, "sequence": self.last.1, "age_us": age_us})
    }
}
