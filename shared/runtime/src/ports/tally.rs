//! Counts of a port.

use crate::Mode;
use crate::report::{ReceivedTopic, SentTopic};
use crate::transport::Sealing;
use messages::e2e::Outcomes;
use messages::{Message, Topic};
use std::cell::RefCell;
use std::rc::Rc;
use xxhash_rust::xxh3::Xxh3Default;

/// A port's counts, shared with the port.
pub(crate) type Counted = (Topic, Rc<RefCell<Tally>>);

/// Counts of a port, shared with the runtime that reports them.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) messages: u64,
    pub(crate) lost: u64,
    /// Bytes that were copied to take the messages.
    pub(crate) copied_bytes: u64,
    pub(crate) e2e: Outcomes,
    /// Digest of the sent messages, in lockstep, if they are sealed.
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
    /// Counts of a sending port.
    pub(crate) fn of_sender(mode: Mode, sealing: Sealing) -> Rc<RefCell<Self>> {
        let digest = (mode == Mode::Lockstep && sealing == Sealing::Sealed).then(Box::default);
        Rc::new(RefCell::new(Self { digest, ..Self::default() }))
    }

    /// Counts of a receiving port.
    pub(crate) fn of_receiver() -> Rc<RefCell<Self>> {
        Rc::default()
    }

    /// Counts from zero: a receiver of a standby that takes over.
    pub(crate) fn begin_anew(&mut self) {
        *self = Self::default();
    }

    pub(super) fn count_sent<T: Message>(&mut self, message: &T) {
        self.messages += 1;
        if let Some(digest) = &mut self.digest {
            digest.update(bytemuck::bytes_of(message));
        }
    }

    fn digest(&self) -> Option<String> {
        self.digest.as_ref().map(|digest| format!("{:016x}", digest.digest()))
    }

    pub(crate) fn sent(&self, topic: Topic) -> SentTopic {
        SentTopic { topic: topic.name().into(), sent: self.messages, digest: self.digest() }
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
