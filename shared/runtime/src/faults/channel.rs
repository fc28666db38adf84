//! Faults of messages on their way: between their arrival and a receiver's check.

use super::activation::{Faults, drive};
use crate::Clock;
use messages::Message;
use scenario::faults::{Disturbance, Effect};
use std::collections::VecDeque;
use std::rc::Rc;

/// Messages that can be on their way at once; the oldest is lost beyond it.
const CAPACITY: usize = 256;

/// The disturbed channel between a topic and one receiver.
#[derive(Debug)]
pub(crate) struct Disturbed<T> {
    faults: Rc<Faults>,
    clock: Rc<Clock>,
    /// Messages and when they are handed over, ns of run time.
    pending: VecDeque<(i64, OnItsWay<T>)>,
    /// A message that lets its successor pass.
    overtaken: Option<Box<OnItsWay<T>>>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct OnItsWay<T> {
    pub(crate) message: T,
    pub(super) corrupted_by: Option<u32>,
}

impl<T: Message> Disturbed<T> {
    /// Lets `faults` disturb messages.
    pub(crate) fn new(faults: Rc<Faults>, clock: Rc<Clock>) -> Self {
        Self { faults, clock, pending: VecDeque::new(), overtaken: None }
    }

    /// Takes a message that arrived now. True if no fault acts on it and none is before it. It is then the receiver's at
    /// once, and is not copied.
    pub(crate) fn passes(&mut self, message: &T) -> bool {
        if !self.faults.reach(T::TOPIC, |effect| effect.of_channels().is_some()) {
            return true;
        }
        let now_ns = self.clock.now_ns();
        let in_use = T::LAYOUT.bytes_in_use(bytemuck::bytes_of(message));
        let header = message.header();
        let identity = (header.source, header.incarnation, header.sequence);
        let mut changed: Option<T> = None;
        let mut corrupted_by = None;
        let mut due_ns = now_ns;
        let (mut copies, mut reordered) = (1, false);
        let which = Effect::of_channels;
        self.faults.activate(which, T::TOPIC, identity, now_ns, |fault, activation| {
            match fault.disturbance {
                Disturbance::Drop {} => copies = 0,
                Disturbance::Duplicate {} => copies += u32::from(copies > 0),
                Disturbance::Reorder {} => reordered = true,
                Disturbance::Delay { delay_ms, jitter_ms } => {
                    let jitter = jitter_ms.nanoseconds() as f64 * random::unit(activation.draw(1));
                    due_ns = due_ns.saturating_add_unsigned(delay_ms.nanoseconds() + jitter as u64);
                }
                Disturbance::Corrupt { bits } => {
                    corrupted_by = Some(activation.number);
                    let bytes = bytemuck::bytes_of_mut(changed.get_or_insert(*message));
                    // Nothing reads what is behind it.
                    let bytes = &mut bytes[..in_use];
                    for k in 0..bits.value() {
                        let bit = activation.draw(2 + u64::from(k)) % (8 * bytes.len() as u64);
                        let bit = usize::try_from(bit).expect("messages are short");
                        bytes[bit / 8] ^= 1 << (bit % 8);
                    }
                    // Flips can meet in one bit and undo each other: then nothing would be corrupt.
                    if *bytes == bytemuck::bytes_of(message)[..in_use] {
                        bytes[0] ^= 1;
                    }
                }
            }
        });
        let undisturbed = changed.is_none() && !reordered && copies == 1 && due_ns == now_ns;
        if undisturbed && self.pending.is_empty() && self.overtaken.is_none() {
            return true;
        }
        let message = OnItsWay { message: changed.unwrap_or(*message), corrupted_by };
        if reordered && copies > 0 && self.overtaken.is_none() {
            self.overtaken = Some(Box::new(message));
            return false;
        }
        for _ in 0..copies {
            self.send(due_ns, message);
        }
        if let Some(overtaken) = self.overtaken.take_if(|_| copies > 0) {
            self.send(due_ns, *overtaken);
        }
        false
    }

    /// The next message that is due now.
    pub(crate) fn hand_over(&mut self) -> Option<OnItsWay<T>> {
        let (due_ns, _) = self.pending.front()?;
        if *due_ns > self.clock.now_ns() {
            return None;
        }
        self.pending.pop_front().map(|(_, message)| message)
    }

    /// Notes that a receiver's check let this message pass.
    pub(crate) fn note_passed(&self, late: &OnItsWay<T>) {
        if let Some(number) = late.corrupted_by {
            self.faults.went_undetected(number);
        }
    }

    /// Begins faults that wait for what the newest message shows.
    pub(crate) fn observe(&self, newest: Option<&T>) {
        self.faults.observe(|| newest.and_then(drive), self.clock.now_ns());
    }

    /// Keeps the messages in the order in which they are due.
    fn send(&mut self, due_ns: i64, message: OnItsWay<T>) {
        if self.pending.len() == CAPACITY {
            self.pending.pop_front();
        }
        let place = self.pending.partition_point(|(due, _)| *due <= due_ns);
        self.pending.insert(place, (due_ns, message));
    }
}
