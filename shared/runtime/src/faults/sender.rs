//! Sender faults: messages that are intact and whose content is false.

use super::activation::{Faults, drive};
use messages::{Header, Message, Odometry, RadarTracks, Spat};
use scenario::faults::{BiasedField, Effect, Falsification};
use scenario::quantity::Shift;
use std::rc::Rc;

#[derive(Debug)]
pub(crate) struct Falsified<T> {
    faults: Rc<Faults>,
    /// The last message that no freeze replaced, where one may come.
    last_intact: Option<Box<T>>,
}

impl<T: Message> Falsified<T> {
    /// Lets `faults` change what is sent.
    pub(crate) fn new(faults: Rc<Faults>) -> Self {
        Self { faults, last_intact: None }
    }

    /// Falsifies `message`, stamped at `now_ns` but not yet protected, as the faults say.
    pub(crate) fn apply(&mut self, message: &mut T, now_ns: i64) {
        self.faults.observe(|| drive(&*message), now_ns);
        if !self.faults.reach(T::TOPIC, |effect| effect.of_senders().is_some()) {
            return;
        }
        let header = message.header();
        let identity = (header.source, header.incarnation, header.sequence);
        // Copied only where it is needed: detections are 48 KiB.
        let may_freeze = self.faults.may_freeze(T::TOPIC, header.source);
        let intact = if may_freeze { Some(*message) } else { None };
        let mut frozen = false;
        let which = Effect::of_senders;
        self.faults.activate(which, T::TOPIC, identity, now_ns, |fault, _| {
            match fault.falsification {
                Falsification::Freeze { .. } => {
                    frozen = true;
                    if let Some(last) = &self.last_intact {
                        let content = size_of::<Header>()..;
                        bytemuck::bytes_of_mut(message)[content.clone()]
                            .copy_from_slice(&bytemuck::bytes_of(&**last)[content]);
                    }
                }
                Falsification::Bias { field, amount, .. } => bias(message, field, amount.value()),
                Falsification::Stale { amount, .. } => {
                    message.header_mut().acquisition_ns -= nanoseconds(amount);
                }
                Falsification::ClockStep { amount, .. } => {
                    message.header_mut().acquisition_ns += nanoseconds(amount);
                    message.header_mut().publish_ns += nanoseconds(amount);
                }
            }
        });
        if let Some(intact) = intact.filter(|_| !frozen) {
            match &mut self.last_intact {
                Some(last) => **last = intact,
                None => self.last_intact = Some(Box::new(intact)),
            }
        }
    }
}

fn nanoseconds(shift_s: Shift) -> i64 {
    (shift_s.value() * 1e9) as i64
}

fn bias<T: Message>(message: &mut T, field: BiasedField, amount: f64) {
    if T::TOPIC != field.topic() {
        return;
    }
    let bytes = bytemuck::bytes_of_mut(message);
    match field {
        BiasedField::GapM => bytemuck::from_bytes_mut::<RadarTracks>(bytes).target.gap_m += amount,
        BiasedField::RelativeSpeedMps => {
            bytemuck::from_bytes_mut::<RadarTracks>(bytes).target.relative_speed_mps += amount;
        }
        BiasedField::SpeedMps => {
            let odometry = bytemuck::from_bytes_mut::<Odometry>(bytes);
            odometry.speed_mps = (odometry.speed_mps + amount).max(0.0);
        }
        BiasedField::EndS => {
            let spat = bytemuck::from_bytes_mut::<Spat>(bytes);
            for interval in spat.signals.iter_mut().flat_map(|signal| &mut signal.intervals) {
                interval.min_end_s += amount;
                interval.likely_end_s += amount;
                interval.max_end_s += amount;
            }
        }
    }
}
