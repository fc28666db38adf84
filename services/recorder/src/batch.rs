//! Messages on their way from the topics to a file or a viewer.

use messages::{TOPICS, Topic};
use runtime::{Guest, RuntimeError, Tapped};

/// Most messages that are taken from one topic before the next one's turn.
const TURN: usize = 1024;

/// Messages taken from all topics in one pass.
#[derive(Debug, Default)]
pub struct Batch {
    /// Topics and places of the messages among the bytes.
    entries: Vec<(Topic, usize)>,
    bytes: Vec<u8>,
}

impl Batch {
    fn push(&mut self, topic: Topic, message: &[u8]) {
        self.entries.push((topic, self.bytes.len()));
        self.bytes.extend_from_slice(message);
    }

    /// Each message with its topic, those of one sender on one topic in their order.
    pub fn messages(&self) -> impl Iterator<Item = (Topic, &[u8])> {
        let bytes =
            |(topic, at): &(Topic, usize)| (*topic, &self.bytes[*at..*at + topic.message_bytes()]);
        self.entries.iter().map(bytes)
    }

    /// True if nothing was there.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

/// The tapped topics.
pub struct Taps {
    topics: Vec<Tapped>,
    // Ports before the node that owns them.
    _guest: Guest,
}

impl Taps {
    /// Taps every topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn open(guest: Guest) -> Result<Self, RuntimeError> {
        let topics = TOPICS.into_iter().map(|topic| guest.tap(topic)).collect::<Result<_, _>>()?;
        Ok(Self { topics, _guest: guest })
    }

    /// Takes what is there.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn take(&self) -> Result<Batch, RuntimeError> {
        let mut batch = Batch::default();
        for tapped in &self.topics {
            for _ in 0..TURN {
                if !tapped.take(|message| batch.push(tapped.topic, message))? {
                    break;
                }
            }
        }
        Ok(batch)
    }
}
