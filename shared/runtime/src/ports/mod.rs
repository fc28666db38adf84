//! Typed ends of a topic. A message takes four steps from one to the other:
//!
//! ```text
//! Loan ─► the service writes ─► Seal ─► Deliver ─► Check ─► newest
//! memory    header, (false content),    shared      sender, (disturbed channel),
//! to write  protection, count           memory,     epoch, end-to-end, clock
//!                                       or memory
//! ```
//!
//! [`Loan`](crate::Loan) and what delivers belong to the carrier (`transport`). A [`Publisher`] seals, a [`Subscriber`] checks
//! ([`check`]). What stands in brackets acts only where faults do ([`crate::faults`]).

mod check;
pub mod guest;
pub mod members;
mod publisher;
mod registry;
mod subscriber;

pub(super) use check::{Check, Expected};
pub use publisher::Publisher;
pub(super) use publisher::{Backlog, Seal};
pub(super) use registry::{Opened, Ports};
pub use subscriber::Subscriber;

use crate::report::{ReceivedTopic, SentTopic};
use messages::Topic;
use messages::e2e::Outcomes;
use std::cell::RefCell;
use std::rc::Rc;
use xxhash_rust::xxh3::Xxh3Default;

/// Counts of a port, shared with the runtime that reports them.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) messages: u64,
    pub(crate) lost: u64,
    pub(crate) e2e: Outcomes,
    /// Digest of the sent messages, if it is asked for.
    digest: Option<Box<Xxh3Default>>,
}

impl std::fmt::Debug for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tally")
            .field("messages", &self.messages)
            .field("lost", &self.lost)
            .finish_non_exhaustive()
    }
}

impl Tally {
    /// Counts of a sending port, with a digest of its messages or without.
    pub(crate) fn of_sender(has_digest: bool) -> Rc<RefCell<Self>> {
        let digest = has_digest.then(Box::default);
        Rc::new(RefCell::new(Self { digest, ..Self::default() }))
    }

    /// Counts a message that is sent; returns its number.
    pub(super) fn next(&mut self) -> u64 {
        self.messages += 1;
        self.messages
    }

    /// Takes the bytes in use of a message that is sent.
    pub(super) fn digest(&mut self, bytes: &[u8]) {
        if let Some(digest) = &mut self.digest {
            digest.update(bytes);
        }
    }

    pub(crate) fn sent(&self, topic: Topic) -> SentTopic {
        let digest = self.digest.as_ref().map(|digest| format!("{:016x}", digest.digest()));
        SentTopic { topic: topic.name().into(), sent: self.messages, digest }
    }

    pub(crate) fn received(&self, topic: Topic) -> ReceivedTopic {
        ReceivedTopic {
            topic: topic.name().into(),
            received: self.messages,
            lost: self.lost,
            e2e: self.e2e,
        }
    }
}
