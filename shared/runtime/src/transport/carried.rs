//! The ports of every message type.

use super::{Receiver, Sender, Transport};
use crate::RuntimeError;
use crate::life::link::End;
use messages::Message;
use std::rc::Rc;

/// A message type with its ports. iceoryx2's generic code is compiled here once for each message,
/// and not for each service.
pub trait Carried: Message {
    /// Creates the sending end of the type's topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    fn sender(transport: &Transport, end: End) -> Result<Rc<dyn Sender<Self>>, RuntimeError>;

    /// Creates the receiving end of the type's topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    fn receiver(transport: &Transport) -> Result<Rc<dyn Receiver<Self>>, RuntimeError>;
}

macro_rules! carried {
    ($($type:ty),+ $(,)?) => {$(
        impl Carried for $type {
            fn sender(
                transport: &Transport,
                end: End,
            ) -> Result<Rc<dyn Sender<Self>>, RuntimeError> {
                transport.publisher::<Self>(end)
            }

            fn receiver(transport: &Transport) -> Result<Rc<dyn Receiver<Self>>, RuntimeError> {
                transport.subscriber::<Self>()
            }
        }
    )+};
}

messages::each_message!(carried);
