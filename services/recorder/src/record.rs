//! One message of a recording.

use messages::{Header, Message, Topic};
use std::ops::Range;
use std::sync::Arc;

/// One recorded message. It keeps its chunk of the file in memory: copy what must live long.
#[derive(Clone, Debug)]
pub struct Record {
    pub topic: Topic,
    /// Time of its publication by its sender's clock, ns of run time. The file is in this order.
    pub log_time_ns: i64,
    /// Time of publication by its sender, ns of run time.
    pub publish_time_ns: i64,
    pub(crate) chunk: Arc<Vec<u8>>,
    pub(crate) range: Range<usize>,
}

impl Record {
    /// The bytes of the topic's struct.
    pub fn bytes(&self) -> &[u8] {
        &self.chunk[self.range.clone()]
    }

    /// The header that every message starts with.
    pub fn header(&self) -> Header {
        bytemuck::pod_read_unaligned(&self.bytes()[..size_of::<Header>()])
    }

    /// The message, if `T` is the topic's type.
    pub fn message<T: Message>(&self) -> Option<T> {
        (self.topic == T::TOPIC).then(|| bytemuck::pod_read_unaligned(self.bytes()))
    }
}

impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        let times = |record: &Self| (record.topic, record.log_time_ns, record.publish_time_ns);
        times(self) == times(other) && self.bytes() == other.bytes()
    }
}

/// A message with the time under which it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed<T> {
    pub log_time_ns: i64,
    pub message: T,
}
