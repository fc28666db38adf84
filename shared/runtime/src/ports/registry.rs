//! All ports of one service.

use super::{Backlog, Counted, Tally};
use crate::RuntimeError;
use crate::ports::members::Members;
use crate::report::{ReceivedTopic, SentTopic};
use crate::survival::fence::Fences;
use crate::transport::{Carrier, Connect, Input, Transport};
use messages::Topic;
use std::cell::RefCell;
use std::rc::Rc;

/// The ports that a service opened, and what new ones need.
#[derive(Debug)]
pub(crate) struct Ports {
    pub(crate) transport: Transport,
    pub(crate) members: Rc<Members>,
    pub(crate) fences: Option<Fences>,
    sent: Vec<Counted>,
    received: Vec<Counted>,
    connections: Vec<(Topic, Rc<dyn Connect>)>,
    /// Receiving ends that a restarted service waits for.
    inputs: Vec<Rc<dyn Input>>,
    /// Messages that the ports keep back while this process is a standby.
    backlogs: Vec<Rc<dyn Backlog>>,
}

impl Ports {
    /// No ports yet, on this carrier.
    pub(crate) fn new(transport: Transport, members: Members, fences: Option<Fences>) -> Self {
        Self {
            transport,
            members: Rc::new(members),
            fences,
            sent: Vec::new(),
            received: Vec::new(),
            connections: Vec::new(),
            inputs: Vec::new(),
            backlogs: Vec::new(),
        }
    }

    /// Enters a sending end.
    pub(crate) fn enter_sender(
        &mut self,
        topic: Topic,
        port: Rc<dyn Connect>,
        tally: Rc<RefCell<Tally>>,
        backlog: Rc<dyn Backlog>,
    ) {
        self.connections.push((topic, port));
        self.sent.push((topic, tally));
        self.backlogs.push(backlog);
    }

    /// Enters a receiving end, as its two sides.
    pub(crate) fn enter_receiver(
        &mut self,
        topic: Topic,
        port: Rc<dyn Connect>,
        input: Rc<dyn Input>,
        tally: Rc<RefCell<Tally>>,
    ) {
        self.connections.push((topic, port));
        self.inputs.push(input);
        self.received.push((topic, tally));
    }

    /// Carrier of the messages.
    pub(crate) fn carrier(&self) -> Carrier {
        match self.transport {
            Transport::SharedMemory(_) => Carrier::SharedMemory,
            Transport::Memory(_) => Carrier::Memory,
        }
    }

    /// Connects all ports to the other ends that exist.
    pub(crate) fn connect(&self) -> Result<(), RuntimeError> {
        for (topic, port) in &self.connections {
            port.connect().map_err(|reason| RuntimeError::Topic { topic: *topic, reason })?;
        }
        Ok(())
    }

    /// True if the service sends or receives messages of `topic`.
    pub(crate) fn has(&self, topic: Topic) -> bool {
        self.connections.iter().any(|(known, _)| *known == topic)
    }

    /// True if a message waits at each receiving end.
    pub(crate) fn have_input(&self) -> bool {
        self.inputs.iter().all(|input| input.has_input())
    }

    /// Sends the messages of `step` that were kept back.
    pub(crate) fn send_held(&self, step: u64) -> Result<(), RuntimeError> {
        self.backlogs.iter().try_for_each(|backlog| backlog.send_held(step))
    }

    /// Counts all that is received from zero.
    pub(crate) fn count_received_anew(&self) {
        for (_, tally) in &self.received {
            tally.borrow_mut().begin_anew();
        }
    }

    /// Counts of the sending ends.
    pub(crate) fn sent(&self) -> &[Counted] {
        &self.sent
    }

    /// Counts of the receiving ends.
    pub(crate) fn received(&self) -> &[Counted] {
        &self.received
    }

    /// Counts of both, as a service reports them.
    pub(crate) fn reports(&self) -> (Vec<SentTopic>, Vec<ReceivedTopic>) {
        let sent = self.sent.iter().map(|(topic, tally)| tally.borrow().sent(*topic));
        let received = self.received.iter().map(|(topic, tally)| tally.borrow().received(*topic));
        (sent.collect(), received.collect())
    }
}
