//! All ports of one service.

use super::{Backlog, Tally};
use crate::RuntimeError;
use crate::report::{ReceivedTopic, SentTopic};
use crate::transport::{Receiver, Sender, Transport};
use messages::Topic;
use std::cell::RefCell;
use std::rc::Rc;

/// One end of a topic, and what it counts.
#[derive(Debug)]
pub(crate) struct Opened<P> {
    pub(crate) topic: Topic,
    pub(crate) port: Rc<P>,
    pub(crate) tally: Rc<RefCell<Tally>>,
}

/// The ports that a service opened, and what new ones need.
#[derive(Debug)]
pub(crate) struct Ports {
    pub(crate) transport: Transport,
    pub(crate) senders: Vec<Opened<Sender>>,
    pub(crate) receivers: Vec<Opened<Receiver>>,
    /// Messages that the senders keep back while this process is a standby.
    pub(crate) backlogs: Vec<Rc<dyn Backlog>>,
}

impl Ports {
    /// No ports yet, on this carrier.
    pub(crate) fn new(transport: Transport) -> Self {
        let (senders, receivers, backlogs) = Default::default();
        Self { transport, senders, receivers, backlogs }
    }

    /// Connects all ports to the other ends that exist.
    pub(crate) fn connect(&self) -> Result<(), RuntimeError> {
        let senders = self.senders.iter().map(|end| (end.topic, end.port.connect()));
        let receivers = self.receivers.iter().map(|end| (end.topic, end.port.connect()));
        for (topic, connected) in senders.chain(receivers) {
            connected.map_err(RuntimeError::topic("open", topic))?;
        }
        Ok(())
    }

    /// True if the service sends or receives messages of `topic`.
    pub(crate) fn has(&self, topic: Topic) -> bool {
        let sent = self.senders.iter().map(|end| end.topic);
        sent.chain(self.receivers.iter().map(|end| end.topic)).any(|known| known == topic)
    }

    /// True if a message waits at each receiving end.
    pub(crate) fn have_input(&self) -> bool {
        self.receivers.iter().all(|end| end.port.has_input())
    }

    /// Sends the messages of `step` that were kept back.
    pub(crate) fn send_held(&self, step: u64) -> Result<(), RuntimeError> {
        self.backlogs.iter().try_for_each(|backlog| backlog.send_held(step))
    }

    pub(crate) fn count_received_anew(&self) {
        for end in &self.receivers {
            *end.tally.borrow_mut() = Tally::default();
        }
    }

    /// Counts of both, as a service reports them.
    pub(crate) fn reports(&self) -> (Vec<SentTopic>, Vec<ReceivedTopic>) {
        let sent = self.senders.iter().map(|end| end.tally.borrow().sent(end.topic));
        let received = self.receivers.iter().map(|end| end.tally.borrow().received(end.topic));
        (sent.collect(), received.collect())
    }
}
