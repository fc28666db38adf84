//! The ends of topics that a service opens.

use super::Runtime;
use crate::faults::{Disturbed, Falsified, Faults};
use crate::ports::{Check, Expected, Opened, Seal, Tally};
use crate::transport::{Carrier, Sealing, Wanted};
use crate::{Mode, Publisher, RuntimeError, Subscriber};
use messages::{Message, Topic};
use std::rc::Rc;

impl Runtime {
    /// Opens the sending end of `T`'s topic.
    pub fn publisher<T: Message>(&mut self) -> Result<Publisher<T>, RuntimeError> {
        let awaited = match self.group.mode {
            Mode::Lockstep => !T::TOPIC.consumers().is_empty(),
            // Only these can release services.
            Mode::Realtime => {
                matches!(T::TOPIC, Topic::RadarTracks | Topic::RadarDetections | Topic::RadioFrames)
            }
        };
        let transport = &self.ports.transport;
        let port = transport.sender(T::TOPIC, self.life.link.orders.end.clone())?;
        let waker = transport.waker(T::TOPIC).filter(|_| awaited);
        let is_sealed = transport.sealing() == Sealing::Sealed;
        let tally = Tally::of_sender(is_sealed && self.group.mode == Mode::Lockstep);
        let publisher = Publisher::new(Seal {
            port: Rc::clone(&port),
            waker: waker.map(|waker| (waker, self.group.timetable)),
            falsified: self.faults_on(T::TOPIC).map(Falsified::new),
            protects: is_sealed || self.injection.faults.concern(T::TOPIC),
            clock: Rc::clone(&self.cycles.clock),
            source: self.service,
            incarnation: self.incarnation,
            tally: Rc::clone(&tally),
            gate: Rc::clone(&self.survival.gate),
            held: None,
        });
        self.ports.senders.push(Opened { topic: T::TOPIC, port, tally });
        self.ports.backlogs.push(publisher.backlog());
        Ok(publisher)
    }

    /// Opens the receiving end of `T`'s topic.
    pub fn subscriber<T: Message>(&mut self) -> Result<Subscriber<T>, RuntimeError> {
        self.subscribe(self.group.mode == Mode::Lockstep)
    }

    /// Opens the receiving end of `T`'s topic so that its samples can release this service.
    pub fn releasing_subscriber<T: Message>(&mut self) -> Result<Subscriber<T>, RuntimeError> {
        self.subscribe(true)
    }

    fn subscribe<T: Message>(&mut self, waits: bool) -> Result<Subscriber<T>, RuntimeError> {
        let (transport, clock) = (&self.ports.transport, &self.cycles.clock);
        let waiter = waits.then(|| transport.waiter(T::TOPIC));
        let is_concerned = self.injection.faults.concern(T::TOPIC);
        let wanted = if is_concerned { Wanted::Every } else { Wanted::Newest(clock) };
        let (port, tally) = (transport.receiver(T::TOPIC, wanted)?, Rc::default());
        let is_judged = is_concerned || transport.carrier() == Carrier::SharedMemory;
        let mut check = Check::new(transport.peers(), is_judged, Rc::clone(&tally));
        check.clock = Some(Rc::clone(clock));
        check.expected = self.expected(T::TOPIC);
        let disturbed = self.faults_on(T::TOPIC);
        let disturbed = disturbed.map(|faults| Disturbed::new(faults, Rc::clone(clock)));
        let opened = Opened { topic: T::TOPIC, port: Rc::clone(&port), tally: Rc::clone(&tally) };
        self.ports.receivers.push(opened);
        Ok(Subscriber::new(port, waiter, disturbed, check, tally))
    }

    /// The faults, if they can come to act on messages of `topic` or wait for what such a message shows.
    fn faults_on(&self, topic: Topic) -> Option<Rc<Faults>> {
        let faults = &self.injection.faults;
        let waits = topic == Topic::EgoTruth && faults.waits_for_the_drive();
        let can_act = self.carrier() == Carrier::SharedMemory || faults.concern(topic) || waits;
        can_act.then(|| Rc::clone(faults))
    }

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
