//! The ends of a topic at a node: iceoryx2's ports, the end-to-end check, epochs, delays.

use crate::page::Page;
use crate::plan::{Act, Graph, Topic};
use crate::times::{ReaderCounts, sent};
use crate::trail;
use bench::payload::{BytesReceiver, BytesSender, Peers};
use messages::Header;
use runtime::{Count, Group, Guest, epoch, monotonic_ns};
use serde_json::json;
use std::collections::VecDeque;
use supervise::{Error, MachineError};

/// Processes of a node that may hold an end at the same time: the active one, its dead self, a standby and the next.
const PROCESSES: usize = 4;

/// Processes at a topic.
pub fn peers(topic: &Topic) -> Peers {
    Peers { senders: PROCESSES, receivers: PROCESSES * topic.readers.len().max(1), history: 1 }
}

fn service(topic: &Topic) -> String {
    format!("graph/{}", topic.name)
}

/// The sending end.
#[derive(Debug)]
pub struct Output {
    pub topic: usize,
    port: BytesSender,
    sequence: u64,
    sent: Count,
}

impl Output {
    pub fn open(graph: &Graph, topic: usize, group: &Group, guest: &Guest) -> Result<Self, Error> {
        let of = &graph.topics[topic];
        let port = BytesSender::open(guest, &service(of), trail::length(of), peers(of))?;
        Ok(Self { topic, port, sequence: 0, sent: sent(topic, group)? })
    }

    /// Sends a message with this header and these trails.
    pub fn send<'a>(
        &mut self,
        graph: &Graph,
        mut header: Header,
        trails: impl Iterator<Item = (usize, &'a [i64])>,
    ) -> Result<(), MachineError> {
        self.sequence += 1;
        header.sequence = self.sequence;
        self.port.send(|bytes| trail::write(bytes, graph, self.topic, &header, trails))?;
        self.sent.add(1);
        Ok(())
    }
}

/// A receiving end. It keeps header and trails of the newest message.
#[derive(Debug)]
pub struct Input {
    pub topic: usize,
    port: BytesReceiver,
    /// Header and trails of the newest message; empty before the first.
    pub newest: Vec<u8>,
    /// Publication of that message, ns.
    pub sent_ns: i64,
    /// Messages that have come.
    pub arrived: u64,
    pub counts: ReaderCounts,
    /// Incarnation and sequence number of the last message.
    last: (u32, u64),
    /// Messages that a fault delays, and until when, ns.
    delayed: VecDeque<(i64, Vec<u8>)>,
}

impl Input {
    pub fn open(
        graph: &Graph,
        topic: usize,
        node: usize,
        group: &Group,
        guest: &Guest,
    ) -> Result<Self, Error> {
        let of = &graph.topics[topic];
        let port = BytesReceiver::open(guest, &service(of), peers(of))?;
        let counts = ReaderCounts::open(topic, node, group)?;
        let newest = Vec::with_capacity(trail::used(of));
        let (sent_ns, arrived, last, delayed) = (0, 0, (0, 0), VecDeque::new());
        Ok(Self { topic, port, newest, sent_ns, arrived, counts, last, delayed })
    }

    /// End of the first delay, ns.
    pub fn delayed_until_ns(&self) -> Option<i64> {
        self.delayed.front().map(|(until_ns, _)| *until_ns)
    }

    /// Takes all messages that have come, and those whose delay is over. The run began at `start_ns`.
    pub fn take(&mut self, graph: &Graph, page: &Page, start_ns: i64) -> Result<(), MachineError> {
        let Self { topic, port, newest, sent_ns, arrived, counts, last, delayed } = self;
        let of = &graph.topics[*topic];
        let mut keep = |bytes: &[u8], published_ns: i64| {
            newest.clear();
            newest.extend_from_slice(&bytes[..trail::used(of)]);
            *sent_ns = published_ns;
            *arrived += 1;
        };
        port.take(|_, bytes| {
            let header = trail::read(bytes, graph, *topic);
            let writer = of.writer.filter(|writer| graph.nodes[*writer].standby);
            let is_current = |header: &Header| {
                writer.is_none_or(|node| epoch::is_accepted(page.epoch(node), header.incarnation))
            };
            let Some(header) = header.filter(is_current) else {
                counts.refused.add(1);
                return Ok(());
            };
            counts.received.add(1);
            if last.0 == header.incarnation && last.1 > 0 {
                counts.unused.add(header.sequence.saturating_sub(last.1 + 1));
            }
            *last = (header.incarnation, header.sequence);
            match delay_ns(graph, *topic, header.publish_ns - start_ns) {
                0 => keep(bytes, header.publish_ns),
                delay_ns => {
                    let bytes = bytes[..trail::used(of)].to_vec();
                    delayed.push_back((header.publish_ns + delay_ns, bytes));
                }
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
}

/// The delay of a message that was published at `run_ns` of run time, ns.
fn delay_ns(graph: &Graph, topic: usize, run_ns: i64) -> i64 {
    let acts = graph.faults.iter().filter_map(|fault| match fault.act {
        Act::Delay(of, delay_ns) if of == topic => {
            (fault.at_ns..fault.at_ns + fault.for_ns).contains(&run_ns).then_some(delay_ns)
        }
        _ => None,
    });
    acts.max().unwrap_or(0)
}

/// The line that a node's program gets for a cycle.
pub fn question(graph: &Graph, node: &str, cycle: u64, inputs: &[Input], now_ns: i64) -> String {
    let came = inputs.iter().filter(|input| input.arrived > 0);
    let inputs = came.map(|input| {
        json!({
            "topic": graph.topics[input.topic].name,
            "sequence": input.last.1,
            "age_us": (now_ns - input.sent_ns) as f64 / 1e3,
        })
    });
    json!({"node": node, "cycle": cycle, "inputs": inputs.collect::<Vec<_>>()}).to_string()
}
