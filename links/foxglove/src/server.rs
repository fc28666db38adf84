//! The server: its port, its viewers, and the messages that wait for them.
//!
//! ```text
//! run ─► newest 16 MiB of messages ─┬─► viewer: its place among them, its subscriptions
//!                                   └─► viewer
//! ```

use crate::protocol::{self, Parameter};
use crate::viewer;
use recorder::Channel;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Most bytes of messages that wait for viewers; beyond them the oldest are lost.
const MOST_WAITING: usize = 16 << 20;
/// Most viewers at a time, those that only connect included.
const MOST_VIEWERS: usize = 16;

/// Answers a request of the service; an error is for the viewer's user.
pub type Answer = Box<dyn Fn(&[u8]) -> Result<Vec<u8>, String> + Send + Sync>;

/// The offer to viewers.
pub struct Subject {
    /// Name of the server.
    pub name: String,
    /// Another one for each run: a viewer that comes back knows whether it sees the same run.
    pub session: String,
    /// Channels, by the numbers that their messages have.
    pub channels: Vec<Channel>,
    /// Values that do not change.
    pub parameters: Vec<Parameter>,
    /// The announcement of a service, and the function that answers.
    pub service: Option<(String, Answer)>,
}

/// A message on its way to viewers.
#[derive(Debug)]
struct Sent {
    /// Its channel; none for the time alone.
    channel: Option<u16>,
    unix_ns: u64,
    payload: Vec<u8>,
}

impl Sent {
    /// Bytes that it takes in the queue.
    fn bytes(&self) -> usize {
        size_of::<Self>() + self.payload.len()
    }
}

/// Channels by the numbers that a viewer gave its subscriptions.
pub(crate) type Subscriptions = BTreeMap<u32, u16>;

/// All that the threads of a server share.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    sent: VecDeque<Sent>,
    bytes: usize,
    /// Messages that were dropped from the front of `sent`.
    dropped: u64,
    /// Viewers by their numbers.
    pub(crate) viewers: BTreeMap<u64, Subscriptions>,
    newest: u64,
    /// The connections end with these words, when all else is written.
    pub(crate) end: Option<String>,
}

pub(crate) fn lock(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    fn put(&mut self, message: Sent) {
        self.bytes += message.bytes();
        self.sent.push_back(message);
        while self.bytes > MOST_WAITING
            && let Some(oldest) = self.sent.pop_front()
        {
            self.bytes -= oldest.bytes();
            self.dropped += 1;
        }
    }

    /// Number of the message that is sent next.
    pub(crate) fn next(&self) -> u64 {
        self.dropped + self.sent.len() as u64
    }

    /// Message number `*next` in the viewer's words, once for each of its subscriptions, or `None` if it was not sent
    /// yet. `*next` moves on. True beside the words if messages before it are lost.
    pub(crate) fn take(&self, viewer: u64, next: &mut u64) -> Option<(bool, Vec<Vec<u8>>)> {
        let is_late = *next < self.dropped;
        *next = self.dropped.max(*next);
        let Sent { channel, unix_ns, payload } =
            self.sent.get(usize::try_from(*next - self.dropped).ok()?)?;
        *next += 1;
        let own = self.viewers.get(&viewer)?;
        let words = match channel {
            None => own.first_key_value().map(|_| protocol::time(*unix_ns)).into_iter().collect(),
            Some(channel) => own
                .iter()
                .filter(|(_, of)| *of == channel)
                .map(|(id, _)| protocol::message_data(*id, *unix_ns, payload))
                .collect(),
        };
        Some((is_late, words))
    }
}

/// A server on 127.0.0.1. Viewers come and go; sending never waits for one.
#[derive(Debug)]
pub struct Server {
    port: u16,
    hub: Arc<Mutex<Hub>>,
}

impl Server {
    /// Opens the port, any free one for 0.
    ///
    /// # Errors
    /// If the port is taken, or a thread cannot be started.
    pub fn open(port: u16, subject: Subject) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let port = listener.local_addr()?.port();
        let hub: Arc<Mutex<Hub>> = Arc::default();
        let (own, subject) = (Arc::clone(&hub), Arc::new(subject));
        std::thread::Builder::new().name("accept".into()).spawn(move || {
            for stream in listener.incoming() {
                match stream.and_then(|stream| Ok((stream.peer_addr()?, stream))) {
                    Ok((address, stream)) => welcome(stream, address, &own, &subject),
                    // Without a descriptor: the connection waits until there is one.
                    Err(_) => std::thread::sleep(Duration::from_millis(100)),
                }
            }
        })?;
        Ok(Self { port, hub })
    }

    pub fn port(&self) -> u16 {
        self.port
    }

    /// Hands a message of `channel` with its time, ns since 1970, to the viewers that subscribe to it.
    pub fn send(&self, channel: u16, unix_ns: u64, payload: &[u8]) {
        let mut hub = lock(&self.hub);
        if hub.viewers.values().flat_map(BTreeMap::values).any(|of| *of == channel) {
            hub.put(Sent { channel: Some(channel), unix_ns, payload: payload.to_vec() });
        }
    }

    /// Hands the time that viewers show, ns since 1970, to all.
    pub fn send_time(&self, unix_ns: u64) {
        lock(&self.hub).put(Sent { channel: None, unix_ns, payload: Vec::new() });
    }

    /// True if a viewer subscribes to anything.
    pub fn is_watched(&self) -> bool {
        lock(&self.hub).viewers.values().any(|own| !own.is_empty())
    }

    /// Ends all connections with these words, and waits until the viewers have what was sent, or `waits` says no.
    pub fn end(self, words: &str, waits: impl Fn() -> bool) {
        lock(&self.hub).end = Some(words.to_owned());
        while !lock(&self.hub).viewers.is_empty() && waits() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Takes in a connection, in a thread of its own.
fn welcome(stream: TcpStream, address: SocketAddr, hub: &Arc<Mutex<Hub>>, subject: &Arc<Subject>) {
    let mut open = lock(hub);
    if open.viewers.len() >= MOST_VIEWERS {
        return report(address, "refused", &format!("there are {MOST_VIEWERS} others"));
    }
    open.newest += 1;
    let id = open.newest;
    open.viewers.insert(id, BTreeMap::new());
    drop(open);
    let (own, subject) = (Arc::clone(hub), Arc::clone(subject));
    let serve = move || {
        viewer::serve(&stream, address, (id, &own), &subject);
        lock(&own).viewers.remove(&id);
    };
    if let Err(why) = std::thread::Builder::new().name("viewer".into()).spawn(serve) {
        lock(hub).viewers.remove(&id);
        report(address, "refused", &why.to_string());
    }
}

/// Writes a line about a viewer, unless viewers have given reason for many.
pub(crate) fn report(address: SocketAddr, what: &str, why: &str) {
    const MOST: usize = 10;
    static LINES: AtomicUsize = AtomicUsize::new(0);
    match LINES.fetch_add(1, Ordering::Relaxed) {
        line if line < MOST => tracing::warn!("viewer {address} was {what}: {why}"),
        MOST => tracing::warn!("no more lines about viewers"),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_alone_fills_the_queue_no_further_than_messages_do() {
        let mut hub = Hub::default();
        for unix_ns in 0..1_000_000 {
            hub.put(Sent { channel: None, unix_ns, payload: Vec::new() });
        }
        assert!(hub.sent.len() < 500_000 && hub.next() == 1_000_000, "{}", hub.sent.len());
        hub.viewers.insert(7, [(1, 0)].into());
        let mut next = 0;
        let (is_late, words) = hub.take(7, &mut next).expect("the oldest that is left");
        assert!(is_late && words.len() == 1 && next == hub.dropped + 1);
        let (is_late, _) = hub.take(7, &mut next).expect("the one behind it");
        assert!(!is_late);
    }
}
