//! The server: its port, and the messages that wait for its viewers in one queue.
//!
//! ```text
//! run ─► newest 16 MiB of messages ─┬─► viewer: its place among them, its subscriptions
//!                                   └─► viewer
//! ```

use crate::protocol::{self, Subject};
use crate::viewer;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Most viewers at a time, those that only connect included.
const MOST_VIEWERS: usize = 16;
/// Most bytes of messages that wait for viewers; beyond them the oldest are lost.
const MOST_WAITING: usize = 16 << 20;

/// A message on its way to viewers: its channel, its time in ns since 1970, its payload.
type Sent = (u16, u64, Vec<u8>);

/// All that the threads of a server share.
#[derive(Debug, Default)]
pub(crate) struct Hub {
    sent: VecDeque<Sent>,
    bytes: usize,
    /// Messages that were dropped from the front of `sent`.
    dropped: u64,
    /// Viewers by their numbers: the channel of each subscription, by the number that the viewer gave it.
    pub(crate) viewers: BTreeMap<u64, BTreeMap<u32, u16>>,
    newest: u64,
    /// Time of the newest message, ns since 1970, in whatever channel.
    pub(crate) unix_ns: u64,
    /// The connections end with these words, when all else is written.
    pub(crate) end: Option<String>,
}

pub(crate) fn lock(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    fn put(&mut self, message: Sent) {
        self.bytes += size_of::<Sent>() + message.2.len();
        self.sent.push_back(message);
        while self.bytes > MOST_WAITING
            && let Some((_, _, payload)) = self.sent.pop_front()
        {
            self.bytes -= size_of::<Sent>() + payload.len();
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
        let place = usize::try_from(*next - self.dropped).ok()?;
        let (channel, unix_ns, payload) = self.sent.get(place)?;
        *next += 1;
        let subscribed = self.viewers.get(&viewer)?.iter().filter(|(_, of)| *of == channel);
        let words = subscribed.map(|(id, _)| protocol::message_data(*id, *unix_ns, payload));
        Some((is_late, words.collect()))
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

    /// Hands a message of `channel` with its time, ns since 1970, to the viewers that subscribe to it. All
    /// of them show that time once they have what was sent.
    pub fn send(&self, channel: u16, unix_ns: u64, payload: &[u8]) {
        let mut hub = lock(&self.hub);
        hub.unix_ns = unix_ns;
        if hub.viewers.values().flat_map(BTreeMap::values).any(|of| *of == channel) {
            hub.put((channel, unix_ns, payload.to_vec()));
        }
    }

    /// True if a viewer subscribes to anything.
    pub fn is_watched(&self) -> bool {
        lock(&self.hub).viewers.values().any(|own| !own.is_empty())
    }

    /// Ends all connections with these words, and waits until the viewers have what was sent, or `waits` says no.
    pub fn end(&self, words: &str, waits: impl Fn() -> bool) {
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
    fn messages_without_content_fill_the_queue_no_further_than_others_do() {
        let mut hub = Hub::default();
        (0..1_000_000).for_each(|unix_ns| hub.put((0, unix_ns, Vec::new())));
        assert!(hub.sent.len() < 500_000 && hub.next() == 1_000_000, "{}", hub.sent.len());
    }
}
