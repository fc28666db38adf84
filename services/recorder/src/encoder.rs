//! A run's messages as viewers read them: ours with their definitions, and the road drawn from them.

use crate::Metadata;
use crate::cdr::ENCAPSULATION;
use crate::scene::{self, Scene};
use crate::schema::ros2_definition_of;
use mcap::records::MessageHeader;
use messages::{Header, TOPICS, Topic};

/// A topic for viewers: its messages are CDR, and its definition has the encoding `ros2msg`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    pub topic: &'static str,
    pub type_name: &'static str,
    /// The type's definition, with those of all types in it.
    pub definition: String,
}

/// Encodes messages, and draws the road ([`scene`]) from those that it has seen.
#[derive(Debug)]
pub struct Encoder {
    epoch_ns: i64,
    payload: Vec<u8>,
    scene: Scene,
}

impl Encoder {
    pub fn of(metadata: &Metadata) -> Self {
        Self { epoch_ns: metadata.epoch_ns, payload: Vec::new(), scene: Scene::of(metadata) }
    }

    /// All channels: those of our topics, then those of the drawn road.
    pub fn channels(metadata: &Metadata) -> Vec<Channel> {
        let ours = TOPICS.into_iter().map(|topic| Channel {
            topic: topic.name(),
            type_name: topic.layout().type_name,
            definition: ros2_definition_of(topic.layout(), &metadata.law),
        });
        let drawn = scene::TOPICS.into_iter().map(|(topic, type_name)| Channel {
            topic,
            type_name,
            definition: scene::definition(type_name),
        });
        ours.chain(drawn).collect()
    }

    /// Hands `message`, the bytes of `topic`'s struct at `log_time_ns` of run time, to `each`, then what is drawn by it.
    /// `each` gets CDR with its encapsulation, and a head with times in ns since 1970 and the channel's place in
    /// [`Encoder::channels`].
    ///
    /// # Errors
    /// That of `each`.
    ///
    /// # Panics
    /// If `message` is not as long as the topic's struct.
    pub fn encode<E>(
        &mut self,
        topic: Topic,
        log_time_ns: i64,
        message: &[u8],
        mut each: impl FnMut(MessageHeader, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        assert_eq!(message.len(), topic.message_bytes(), "{}", topic.name());
        let head: Header = bytemuck::pod_read_unaligned(&message[..size_of::<Header>()]);
        self.payload.clear();
        self.payload.extend_from_slice(&ENCAPSULATION);
        self.payload.extend_from_slice(message);
        let place = TOPICS.iter().position(|known| *known == topic).expect("every topic is there");
        let log_time = self.unix_ns(log_time_ns);
        let ours = MessageHeader {
            channel_id: place as u16,
            // The format's field is narrower than ours; the payload holds the whole number.
            sequence: head.sequence as u32,
            log_time,
            publish_time: self.unix_ns(head.publish_ns),
        };
        each(ours, &self.payload)?;
        self.scene.take(topic, log_time_ns, message);
        for drawn in self.scene.drawn() {
            let (channel_id, sequence) = ((TOPICS.len() + drawn.topic) as u16, drawn.sequence);
            let head = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            each(head, &drawn.payload)?;
        }
        Ok(())
    }

    /// An instant of run time in ns since 1970.
    fn unix_ns(&self, run_ns: i64) -> u64 {
        u64::try_from(self.epoch_ns.saturating_add(run_ns)).unwrap_or(0)
    }
}
