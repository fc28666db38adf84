//! iceoryx2's own event service, for comparison with the wake-up of the topics.

use super::Probe;
use super::payload::PAYLOAD_TOPIC;
use crate::RuntimeError;
use crate::transport::{Ipc, TransportError, refused};
use iceoryx2::port::{listener::Listener, notifier::Notifier};
use iceoryx2::service::port_factory::event::PortFactory;
use std::time::Duration;

impl Probe {
    fn event(&self) -> Result<PortFactory<Ipc>, RuntimeError> {
        let name = "bench/event".try_into().expect("a valid service name");
        let service = self.node().service(&name).event();
        service.open_or_create().map_err(refused(PAYLOAD_TOPIC))
    }

    /// The waking end of iceoryx2's own event service.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn event_sender(&self) -> Result<EventSender, RuntimeError> {
        let port = (self.event()?.notifier_builder()).create().map_err(refused(PAYLOAD_TOPIC))?;
        Ok(EventSender(port))
    }

    /// The waiting end of iceoryx2's own event service.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn event_receiver(&self) -> Result<EventReceiver, RuntimeError> {
        let port = (self.event()?.listener_builder()).create().map_err(refused(PAYLOAD_TOPIC))?;
        Ok(EventReceiver(port))
    }
}

/// Wakes by iceoryx2's event service.
#[derive(Debug)]
pub struct EventSender(Notifier<Ipc>);

impl EventSender {
    /// Wakes who waits.
    ///
    /// # Errors
    /// [`RuntimeError::Send`].
    pub fn wake(&self) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Send { topic: PAYLOAD_TOPIC, reason };
        self.0.notify().map(|_| ()).map_err(TransportError::iceoryx2).map_err(error)
    }
}

/// Waits by iceoryx2's event service.
#[derive(Debug)]
pub struct EventReceiver(Listener<Ipc>);

impl EventReceiver {
    /// Waits to be woken, at most for `timeout`.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`].
    pub fn wait(&self, timeout: Duration) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Receive { topic: PAYLOAD_TOPIC, reason };
        self.0
            .timed_wait(|_| {}, timeout)
            .map(|_| ())
            .map_err(TransportError::iceoryx2)
            .map_err(error)
    }
}
