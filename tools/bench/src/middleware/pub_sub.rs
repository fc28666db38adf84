//! The same message by iceoryx2 alone: its own variant, its publish-subscribe service, and its event service
//! as wake-up.

use super::{MiddlewareError, Receiving, Sending, iceoryx2_failed as failed};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, publish_subscribe};
use messages::RadarTracks;
use runtime::Group;
use std::time::Duration;

type Ipc = ipc::Service;

/// A node with the two services.
struct Topic {
    messages: publish_subscribe::PortFactory<Ipc, RadarTracks, ()>,
    event: event::PortFactory<Ipc>,
    _node: Node<Ipc>,
}

impl Topic {
    fn open(root: &std::path::Path) -> Result<Self, MiddlewareError> {
        let domain = runtime::domain(&Group::read(root)?)?;
        let node = NodeBuilder::new()
            .config(&domain)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(failed("make a node"))?;
        let name: ServiceName = "bench/pub-sub".try_into().expect("a valid service name");
        let messages = (node.service_builder(&name).publish_subscribe::<RadarTracks>())
            .open_or_create()
            .map_err(failed("open a topic"))?;
        let event = (node.service_builder(&name).event())
            .open_or_create()
            .map_err(failed("open an event service"))?;
        Ok(Self { messages, event, _node: node })
    }
}

/// The publishing end.
pub struct Source {
    publisher: Publisher<Ipc, RadarTracks, ()>,
    notifier: Notifier<Ipc>,
    _topic: Topic,
}

impl Source {
    /// Opens the end.
    pub fn open(root: &std::path::Path) -> Result<Self, MiddlewareError> {
        let topic = Topic::open(root)?;
        let publisher =
            topic.messages.publisher_builder().create().map_err(failed("make a publisher"))?;
        let notifier =
            topic.event.notifier_builder().create().map_err(failed("make a notifier"))?;
        Ok(Self { publisher, notifier, _topic: topic })
    }
}

impl Sending for Source {
    fn send(&mut self, message: &RadarTracks) -> Result<(), MiddlewareError> {
        let sample = self.publisher.loan_uninit().map_err(failed("loan"))?;
        sample.write_payload(*message).send().map_err(failed("send"))?;
        self.notifier.notify().map(|_| ()).map_err(failed("notify"))
    }
}

/// The subscribing end.
pub struct Sink {
    subscriber: Subscriber<Ipc, RadarTracks, ()>,
    listener: Listener<Ipc>,
    _topic: Topic,
}

impl Sink {
    /// Opens the end.
    pub fn open(root: &std::path::Path) -> Result<Self, MiddlewareError> {
        let topic = Topic::open(root)?;
        let subscriber =
            topic.messages.subscriber_builder().create().map_err(failed("make a subscriber"))?;
        let listener =
            topic.event.listener_builder().create().map_err(failed("make a listener"))?;
        Ok(Self { subscriber, listener, _topic: topic })
    }
}

impl Receiving for Sink {
    fn receive(
        &mut self,
        timeout: Duration,
        each: &mut dyn FnMut(i64),
    ) -> Result<(), MiddlewareError> {
        self.listener.timed_wait(|_| {}, timeout).map_err(failed("wait"))?;
        while let Some(sample) = self.subscriber.receive().map_err(failed("receive"))? {
            each(sample.header.acquisition_ns);
        }
        Ok(())
    }
}
