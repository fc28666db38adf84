//! iceoryx2's own event service, for comparison with the wake-up of the topics. It is of the topics' own node and
//! variant.

use super::wake::{WakeError, failed};
use iceoryx2::port::{listener::Listener, notifier::Notifier};
use iceoryx2::service::port_factory::event::PortFactory;
use runtime::{Guest, Ipc};
use std::time::Duration;

fn service(guest: &Guest) -> Result<PortFactory<Ipc>, WakeError> {
    let name = "bench/event".try_into().expect("a valid service name");
    guest.service(&name).event().open_or_create().map_err(failed("open an event service"))
}

/// Wakes by iceoryx2's event service.
#[derive(Debug)]
pub struct EventSender(Notifier<Ipc>);

impl EventSender {
    pub fn open(guest: &Guest) -> Result<Self, WakeError> {
        let port = service(guest)?.notifier_builder().create();
        Ok(Self(port.map_err(failed("make a notifier"))?))
    }

    /// Wakes who waits.
    pub fn wake(&self) -> Result<(), WakeError> {
        self.0.notify().map(|_| ()).map_err(failed("notify"))
    }
}

/// Waits by iceoryx2's event service.
#[derive(Debug)]
pub struct EventReceiver(Listener<Ipc>);

impl EventReceiver {
    /// The waiting end.
    pub fn open(guest: &Guest) -> Result<Self, WakeError> {
        let port = service(guest)?.listener_builder().create();
        Ok(Self(port.map_err(failed("make a listener"))?))
    }

    /// Waits to be woken, at most for `timeout`.
    pub fn wait(&self, timeout: Duration) -> Result<(), WakeError> {
        self.0.timed_wait(|_| {}, timeout).map(|_| ()).map_err(failed("wait for an event"))
    }
}
