//! Messages on their way from the topics to a file or a viewer.

use messages::{Message, Topic};
use runtime::{Guest, RuntimeError};

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
    fn push<T: Message>(&mut self, message: &T) {
        self.entries.push((T::TOPIC, self.bytes.len()));
        self.bytes.extend_from_slice(bytemuck::bytes_of(message));
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

/// Moves what is there of one topic into a batch.
type Drain = Box<dyn Fn(&mut Batch) -> Result<(), RuntimeError>>;

/// The tapped topics.
pub struct Taps {
    topics: Vec<Drain>,
    // Ports before the node that owns them.
    _guest: Guest,
}

impl Taps {
    /// Taps every topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn open(guest: Guest) -> Result<Self, RuntimeError> {
        fn drain<T: Message>(guest: &Guest) -> Result<Drain, RuntimeError> {
            let tapped = guest.tap::<T>()?;
            Ok(Box::new(move |into| {
                for _ in 0..TURN {
                    if !tapped.take(|message| into.push(message))? {
                        break;
                    }
                }
                Ok(())
            }))
        }
        macro_rules! every {
            ($($message:ty),+) => { vec![$(drain::<$message>(&guest)?),+] };
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
        self.topics.iter().try_for_each(|drain| drain(&mut batch))?;
        Ok(batch)
    }
}
