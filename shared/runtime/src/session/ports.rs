//! The ends of topics that a service opens.

use super::Runtime;
use crate::faults::{Disturbed, Falsified};
use crate::ports::{Checks, Expected, Outlet, Protection, Tally, Wire};
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
        let port = T::sender(&self.ports.transport, self.life.link.end.clone())?;
        let tally = Tally::of_sender(self.group.mode, port.sealing());
        let protection = Protection {
            port: Rc::clone(&port),
            waker: self.ports.transport.waker(T::TOPIC).filter(|_| awaited),
            timetable: self.group.timetable,
            tally: Rc::clone(&tally),
        };
        let outlet = Outlet {
            next: Box::new(Falsified::new(protection, Rc::clone(&self.injection.faults))),
            clock: Rc::clone(&self.cycles.clock),
            source: self.service,
            incarnation: self.incarnation,
            tally: Rc::clone(&tally),
            gate: Rc::clone(&self.survival.gate),
            held: None,
        };
        let publisher = Publisher::new(Rc::clone(&port), outlet);
        self.ports.enter_sender(T::TOPIC, port, tally, publisher.backlog());
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
        let waiter = waits.then(|| self.ports.transport.waiter(T::TOPIC));
        let (port, tally) = (T::receiver(&self.ports.transport)?, Tally::of_receiver());
        let (input, connection) = (Rc::clone(&port), Rc::clone(&port));
        self.ports.enter_receiver(T::TOPIC, connection, input, Rc::clone(&tally));
        let clock = &self.cycles.clock;
        let wire = Wire::new(Rc::clone(&port), Rc::clone(&self.ports.members), Rc::clone(&tally));
        let faults = Rc::clone(&self.injection.faults);
        let intake = Disturbed::new(wire, port.sealing(), faults, Rc::clone(clock));
        let (fences, expected) = (self.ports.fences.clone(), self.expected(T::TOPIC));
        let checks = Checks::new(fences, Some(Rc::clone(clock)), expected, Rc::clone(&tally));
        Ok(Subscriber::new(port, waiter, Box::new(intake), checks, tally))
    }

    /// Expected period of messages of `topic`.
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
}
