//! All ports of one service.

use super::{Backlog, Counted, Tally};
use crate::RuntimeError;
use crate::report::{ReceivedTopic, SentTopic};
use crate::transport::{Receiver, Sender, Transport};
use messages::Topic;
use std::cell::RefCell;
use std::rc::Rc;

/// The ports that a service opened, and what new ones need.
#[derive(Debug)]
pub(crate) struct Ports {
    pub(crate) transport: Transport,
    /// Counts of the sending ends.
    pub(crate) sent: Vec<Counted>,
    /// Counts of the receiving ends.
    pub(crate) received: Vec<Counted>,
    senders: Vec<(Topic, Rc<Sender>)>,
    receivers: Vec<(Topic, Rc<Receiver>)>,
    /// Messages that the ports keep back while this process is a standby.
    backlogs: Vec<Rc<dyn Backlog>>,
}

impl Ports {
    /// No ports yet, on this carrier.
    pub(crate) fn new(transport: Transport) -> Self {
        let (sent, received, senders, receivers, backlogs) = Default::default();
        Self { transport, sent, received, senders, receivers, backlogs }
    }

    /// Enters a sending end, which counts in `tally`.
    pub(crate) fn enter_sender(
        &mut self,
        topic: Topic,
        port: &Rc<Sender>,
        tally: &Rc<RefCell<Tally>>,
    ) {
        self.sent.push((topic, Rc::clone(tally)));
        self.senders.push((topic, Rc::clone(port)));
    }

    /// Enters the message that a sending end keeps back.
    pub(crate) fn enter_backlog(&mut self, backlog: Rc<dyn Backlog>) {
        self.backlogs.push(backlog);
    }

    /// Enters a receiving end, which counts in `tally`.
    pub(crate) fn enter_receiver(
        &mut self,
        topic: Topic,
        port: &Rc<Receiver>,
        tally: &Rc<RefCell<Tally>>,
    ) {
        self.received.push((topic, Rc::clone(tally)));
        self.receivers.push((topic, Rc::clone(port)));
    }

    /// Connects all ports to the other ends that exist.
    pub(crate) fn connect(&self) -> Result<(), RuntimeError> {
        let senders = self.senders.iter().map(|(topic, port)| (*topic, port.connect()));
        let receivers = self.receivers.iter().map(|(topic, port)| (*topic, port.connect()));
        for (topic, connected) in senders.chain(receivers) {
            connected.map_err(RuntimeError::topic("open", topic))?;
        }
        Ok(())
    }

    /// True if the service sends or receives messages of `topic`.
    pub(crate) fn has(&self, topic: Topic) -> bool {
        self.sent.iter().chain(&self.received).any(|(known, _)| *known == topic)
    }

    /// True if a message waits at each receiving end.
    pub(crate) fn have_input(&self) -> bool {
        self.receivers.iter().all(|(_, port)| port.has_input())
    }

    /// Sends the messages of `step` that were kept back.
    pub(crate) fn send_held(&self, step: u64) -> Result<(), RuntimeError> {
        self.backlogs.iter().try_for_each(|backlog| backlog.send_held(step))
    }

    /// Counts all that is received from zero.
    pub(crate) fn count_received_anew(&self) {
        for (_, tally) in &self.received {
            *tally.borrow_mut() = Tally::default();
        }
    }

    /// Counts of both, as a service reports them.
    pub(crate) fn reports(&self) -> (Vec<SentTopic>, Vec<ReceivedTopic>) {
        let sent = self.sent.iter().map(|(topic, tally)| tally.borrow().sent(*topic));
        let received = self.received.iter().map(|(topic, tally)| tally.borrow().received(*topic));
        (sent.collect(), received.collect())
    }
}
