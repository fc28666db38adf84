//! The ends of topics that a service opens.

use super::Runtime;
use crate::faults::SenderFaults;
use crate::ports::{Expected, Outlet, Tally};
use crate::transport::{Connect, Input};
use crate::{Carried, Mode, Publisher, RuntimeError, Subscriber};
use messages::Topic;
use std::rc::Rc;

impl Runtime {
    /// Opens the sending end of `T`'s topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn publisher<T: Carried>(&mut self) -> Result<Publisher<T>, RuntimeError> {
        let awaited = match self.group.mode {
            Mode::Lockstep => !T::TOPIC.consumers().is_empty(),
            // Only these can release services.
            Mode::Realtime => {
                matches!(T::TOPIC, Topic::RadarTracks | Topic::RadarDetections | Topic::RadioFrames)
            }
        };
        let port = T::sender(&self.transport, self.link.end.clone())?;
        let tally = Tally::of_sender(self.group.mode, port.sealing());
        self.sent.push((T::TOPIC, Rc::clone(&tally)));
        self.ports.push((T::TOPIC, Rc::clone(&port) as Rc<dyn Connect>));
        let publisher = Publisher::new(Outlet {
            port,
            waker: self.transport.waker(T::TOPIC).filter(|_| awaited),
            clock: Rc::clone(&self.clock),
            timetable: self.group.timetable,
            source: self.service,
            incarnation: self.incarnation,
            faults: Rc::clone(&self.faults),
            sender_faults: SenderFaults::new(),
            tally,
            gate: Rc::clone(&self.gate),
            held: None,
        });
        self.backlogs.push(publisher.backlog());
        Ok(publisher)
    }

    /// Opens the receiving end of `T`'s topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn subscriber<T: Carried>(&mut self) -> Result<Subscriber<T>, RuntimeError> {
        self.subscribe(self.group.mode == Mode::Lockstep)
    }

    /// Opens the receiving end of `T`'s topic so that its samples can release this service.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn releasing_subscriber<T: Carried>(&mut self) -> Result<Subscriber<T>, RuntimeError> {
        self.subscribe(true)
    }

    fn subscribe<T: Carried>(&mut self, waits: bool) -> Result<Subscriber<T>, RuntimeError> {
        let tally = Tally::of_receiver();
        self.received.push((T::TOPIC, Rc::clone(&tally)));
        let waiter = waits.then(|| self.transport.waiter(T::TOPIC));
        let port = T::receiver(&self.transport)?;
        self.ports.push((T::TOPIC, Rc::clone(&port) as Rc<dyn Connect>));
        self.inputs.push(Rc::clone(&port) as Rc<dyn Input>);
        let (members, faults) = (Rc::clone(&self.members), Rc::clone(&self.faults));
        let clock = Some(Rc::clone(&self.clock));
        let fences = self.fences.clone();
        let mut subscriber = Subscriber::new(port, waiter, members, fences, clock, faults, tally);
        subscriber.expected = self.expected(T::TOPIC);
        Ok(subscriber)
    }

    /// How often messages of `topic` are expected.
    fn expected(&self, topic: Topic) -> Option<Expected> {
        let source = topic.source(&self.scenario.services())?;
        let timetable = &self.group.timetable;
        let period_ns = match topic {
            // Frames of other hosts are looked for more often than they are sent.
            Topic::RadioFrames | Topic::RadioSent => {
                i64::from(self.scenario.v2x.period_ms.value()) * 1_000_000
            }
            _ => timetable.period_ns(source),
        };
        Some(Expected { source, stride: timetable.stride(source), period_ns })
    }

    pub(super) fn connect(&self) -> Result<(), RuntimeError> {
        for (topic, port) in &self.ports {
            port.connect().map_err(|reason| RuntimeError::Topic { topic: *topic, reason })?;
        }
        Ok(())
    }
}
