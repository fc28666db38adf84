//! Messages that wait for viewers, in one queue for all.

use crate::protocol;
use std::collections::{BTreeMap, VecDeque};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Most bytes of messages that wait for viewers; beyond them the oldest are lost.
const MOST_WAITING: usize = 16 << 20;

/// A message on its way to viewers.
#[derive(Debug)]
pub(crate) struct Sent {
    pub channel: u16,
    pub unix_ns: u64,
    pub payload: Vec<u8>,
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
    pub(crate) newest: u64,
    /// Time of the newest message, ns since 1970, in whatever channel.
    pub(crate) unix_ns: u64,
    /// The connections end with these words, when all else is written.
    pub(crate) end: Option<String>,
}

pub(crate) fn lock(hub: &Mutex<Hub>) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    pub(crate) fn put(&mut self, message: Sent) {
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
        let subscribed = own.iter().filter(|(_, of)| *of == channel);
        let words = subscribed.map(|(id, _)| protocol::message_data(*id, *unix_ns, payload));
        Some((is_late, words.collect()))
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
        let empty = |unix_ns| Sent { channel: 0, unix_ns, payload: Vec::new() };
        (0..1_000_000).for_each(|unix_ns| hub.put(empty(unix_ns)));
        assert!(hub.sent.len() < 500_000 && hub.next() == 1_000_000, "{}", hub.sent.len());
    }
}
