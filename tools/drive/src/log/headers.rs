//! Topics of which only the headers matter.

use messages::{Header, Message, Topic};
use runtime::{Observed, Observer, RuntimeError};

/// A topic of which only the headers matter.
pub(crate) trait Headers: std::fmt::Debug {
    /// Takes all that arrived.
    fn drain_headers(&mut self, each: &mut dyn FnMut(Topic, &Header)) -> Result<(), RuntimeError>;
}

impl<T: Message> Headers for Observed<T> {
    fn drain_headers(&mut self, each: &mut dyn FnMut(Topic, &Header)) -> Result<(), RuntimeError> {
        self.drain(|message| each(T::TOPIC, message.header()))
    }
}

/// Opens a topic by its number.
pub(crate) fn listen_to(
    observer: &Observer,
    topic: Topic,
) -> Result<Box<dyn Headers>, RuntimeError> {
    macro_rules! by_topic {
        ($($message:ty),+) => {
            match topic {
                $(<$message as Message>::TOPIC => Ok(Box::new(observer.listen::<$message>()?)),)+
            }
        };
    }
    messages::each_message!(by_topic)
}
