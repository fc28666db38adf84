//! Messages on their way from the topics to the file.

use messages::{
    Brake, Command, Diagnostics, Heartbeat, Map, Message, Odometry, Powertrain, Preview,
    RadarDetections, RadarTracks, SignalTruth, Spat, Topic, VehicleTruth,
};
use runtime::{RuntimeError, Tap, Tapped};

/// Most messages that are taken from one topic before the next one's turn.
const TURN: usize = 1024;

/// What was taken from all topics in one pass.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    entries: Vec<Entry>,
    bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    topic: Topic,
    publish_ns: i64,
    /// Newest publish time of the topic's messages up to this one.
    order_ns: i64,
    offset: usize,
}

impl Batch {
    fn push<T: Message>(&mut self, message: &T) {
        let publish_ns = message.header().publish_ns;
        // Whatever a faulty clock stamps, a topic's messages keep the order of their arrival.
        let before = self.entries.last().filter(|entry| entry.topic == T::TOPIC);
        let order_ns = before.map_or(publish_ns, |before| before.order_ns.max(publish_ns));
        let offset = self.bytes.len();
        self.entries.push(Entry { topic: T::TOPIC, publish_ns, order_ns, offset });
        self.bytes.extend_from_slice(bytemuck::bytes_of(message));
    }

    /// Brings the messages in the order of their publication.
    pub(crate) fn sort(&mut self) {
        self.entries.sort_by_key(|entry| entry.order_ns);
    }

    /// Each message with its topic and publish time.
    pub(crate) fn messages(&self) -> impl Iterator<Item = (Topic, i64, &[u8])> {
        self.entries.iter().map(|entry| {
            let end = entry.offset + entry.topic.message_bytes();
            (entry.topic, entry.publish_ns, &self.bytes[entry.offset..end])
        })
    }

    /// Memory in use, bytes.
    pub(crate) fn size(&self) -> usize {
        self.bytes.len()
    }
}

/// The tapped topics, each by its type.
pub(crate) struct Taps {
    topics: Vec<Box<dyn Hear>>,
    // Ports before the node that owns them.
    _tap: Tap,
}

trait Hear {
    fn hear(&self, into: &mut Batch) -> Result<(), RuntimeError>;
}

impl<T: Message> Hear for Tapped<T> {
    fn hear(&self, into: &mut Batch) -> Result<(), RuntimeError> {
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
    pub(crate) fn open(tap: Tap) -> Result<Self, RuntimeError> {
        let topics: Vec<Box<dyn Hear>> = vec![
            Box::new(tap.on::<Odometry>()?),
            Box::new(tap.on::<Powertrain>()?),
            Box::new(tap.on::<RadarDetections>()?),
            Box::new(tap.on::<Brake>()?),
            Box::new(tap.on::<RadarTracks>()?),
            Box::new(tap.on::<Spat>()?),
            Box::new(tap.on::<Map>()?),
            Box::new(tap.on::<Preview>()?),
            Box::new(tap.on::<Command>()?),
            Box::new(tap.on::<Diagnostics>()?),
            Box::new(tap.on::<VehicleTruth>()?),
            Box::new(tap.on::<SignalTruth>()?),
            Box::new(tap.on::<Heartbeat>()?),
        ];
        assert_eq!(topics.len(), messages::TOPICS.len(), "every topic is recorded");
        Ok(Self { topics, _tap: tap })
    }

    /// Takes what is there, in the order of publication.
    pub(crate) fn take(&self) -> Result<Batch, RuntimeError> {
        let mut batch = Batch::default();
        for topic in &self.topics {
            topic.hear(&mut batch)?;
        }
        batch.sort();
        Ok(batch)
    }
}
