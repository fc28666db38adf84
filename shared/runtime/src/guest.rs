//! The ends of a topic without a service around them, for measurements: those of the services themselves.
//!
//! A guest can also open iceoryx2 services that no topic uses, in the same node and variant. It can wake those who wait
//! for a topic. So a program can send bytes of any size as the topics' messages are sent. `timegap bench` does.

use crate::life::link::End;
use crate::ports::members::Members;
use crate::ports::{Check, Protection, Seal, Tally};
use crate::survival::fence::Gate;
use crate::transport::waking::{Waiter, Waker};
use crate::transport::{Inlet, Ipc, Outlet, SharedMemory};
use crate::{Clock, Group, Mode, Publisher, RuntimeError, Subscriber};
use iceoryx2::prelude::ServiceName;
use iceoryx2::service::builder::Builder;
use messages::{Message, Service, Topic};
use std::rc::Rc;
use std::time::Duration;

/// A member of a group that is not a service.
#[derive(Debug)]
pub struct Guest {
    node: SharedMemory,
    group: Group,
}

impl Guest {
    /// Joins `group` under `name`.
    pub fn join(group: Group, name: &str) -> Result<Self, RuntimeError> {
        Ok(Self { node: SharedMemory::join(&group, name)?, group })
    }

    /// Begins to open an iceoryx2 service that is not a topic.
    pub fn service(&self, name: &ServiceName) -> Builder<Ipc> {
        self.node.service(name)
    }

    /// Removes what dead processes left on all topics.
    pub fn remove_dead(&self) {
        self.node.remove_dead();
    }

    /// Wakes those who wait for `topic`.
    pub fn waker(&self, topic: Topic) -> Waker {
        self.node.waker(topic)
    }

    /// Waits for `topic`.
    pub fn waiter(&self, topic: Topic) -> Waiter {
        self.node.waiter(topic)
    }

    /// The sending end of `T`'s topic, as `source` has it.
    pub fn publisher<T: Message>(&self, source: Service) -> Result<Publisher<T>, RuntimeError> {
        let Group { mode, timetable, .. } = self.group;
        Ok(Publisher::new(Seal {
            outlet: Outlet::SharedMemory(Rc::new(self.node.sender(T::TOPIC, End::default())?)),
            waker: Some((self.waker(T::TOPIC), timetable)),
            falsified: None,
            protection: Protection::Full,
            clock: Rc::new(Clock::new(mode, timetable.step_ns)),
            source,
            incarnation: 0,
            tally: Tally::of_sender(mode == Mode::Lockstep),
            gate: Rc::new(Gate::open(source)),
            held: None,
        }))
    }

    /// The receiving end of `T`'s topic, as a service that it releases has it.
    pub fn subscriber<T: Message>(&self) -> Result<Subscriber<T>, RuntimeError> {
        let inlet = Inlet::SharedMemory(Rc::new(self.node.receiver(T::TOPIC)?));
        let tally = Rc::default();
        let members = Some(Rc::new(Members::of(&self.group.root)));
        let check = Check::new(members, true, Rc::clone(&tally));
        Ok(Subscriber::new(inlet, Some(self.waiter(T::TOPIC)), None, check, tally))
    }

    /// Waits for samples of `T`'s topic, at most for `timeout`, and hands all to `each`.
    pub fn next_samples<T: Message>(
        &self,
        topic: &mut Subscriber<T>,
        timeout: Duration,
        mut each: impl FnMut(&T),
    ) -> Result<(), RuntimeError> {
        let ticket = topic.ticket();
        let mut found = false;
        topic.drain(u64::MAX, |sample| {
            found = true;
            each(sample);
        })?;
        if found {
            return Ok(());
        }
        topic.wait(ticket, timeout)?;
        topic.drain(u64::MAX, each)
    }
}
