//! Messages on their way from the topics to a file or a viewer.

use messages::{Message, Topic};
use runtime::{Guest, RuntimeError, Tapped};

/// Most messages that are taken from one topic before the next one's turn.
const TURN: usize = 1024;

/// Messages taken from all topics in one pass.
#[derive(Debug, Default)]
pub struct Batch {
    entries: Vec<Entry>,
    bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    topic: Topic,
    offset: usize,
}

impl Batch {
    fn push<T: Message>(&mut self, message: &T) {
        let offset = self.bytes.len();
        self.entries.push(Entry { topic: T::TOPIC, offset });
        self.bytes.extend_from_slice(bytemuck::bytes_of(message));
    }

    /// Each message with its topic, those of one sender on one topic in their order.
    pub fn messages(&self) -> impl Iterator<Item = (Topic, &[u8])> {
        self.entries.iter().map(|entry| {
            let end = entry.offset + entry.topic.message_bytes();
            (entry.topic, &self.bytes[entry.offset..end])
        })
    }

    /// True if nothing was there.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

/// The tapped topics, each by its type.
pub struct Taps {
    topics: Vec<Box<dyn Drain>>,
    // Ports before the node that owns them.
    _guest: Guest,
}

trait Drain {
    fn drain_into(&self, into: &mut Batch) -> Result<(), RuntimeError>;
}

impl<T: Message> Drain for Tapped<T> {
    fn drain_into(&self, into: &mut Batch) -> Result<(), RuntimeError> {
        for _ in 0..TURN {
            if !self.take(|message| into.push(message))? {
                break;
            }
        }
        Ok(())
    }
}

impl Taps {
    /// Taps every topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn open(guest: Guest) -> Result<Self, RuntimeError> {
        macro_rules! every {
            ($($message:ty),+) => { vec![$(Box::new(guest.tap::<$message>()?) as Box<dyn Drain>),+] };
        }
        let topics = messages::each_message!(every);
        Ok(Self { topics, _guest: guest })
    }

    /// Takes what is there.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn take(&self) -> Result<Batch, RuntimeError> {
        let mut batch = Batch::default();
        for topic in &self.topics {
            topic.drain_into(&mut batch)?;
        }
        Ok(batch)
    }
}
