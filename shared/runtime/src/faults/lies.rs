//! What a sender makes up: its messages are intact and their content is not true.

use super::Faults;
use messages::{Header, Message, Odometry, RadarTracks, Spat};
use scenario::faults::{BiasedField, Fault, Kind};

/// Falsifies the messages of one publisher.
#[derive(Debug)]
pub(crate) struct Lies<T> {
    /// The last message that was true.
    true_one: Option<T>,
}

impl<T: Message> Lies<T> {
    pub(crate) fn new() -> Self {
        Self { true_one: None }
    }

    /// Falsifies `message`, stamped but not yet protected, as the faults want it.
    pub(crate) fn tell(&mut self, message: &mut T, faults: &Faults, now_ns: i64) {
        let header = message.header();
        let identity = (header.source, header.incarnation, header.sequence);
        let told = *message;
        let mut frozen = false;
        let is_a_lie = |fault: &Fault| fault.kind.is_a_lie();
        faults.strike(is_a_lie, T::TOPIC, identity, now_ns, |strike| {
            let amount = strike.fault.amount.map_or(0.0, |amount| amount.value());
            let shift_ns = (amount * 1e9) as i64;
            match (strike.fault.kind, strike.fault.field) {
                (Kind::Freeze, _) => {
                    frozen = true;
                    if let Some(last) = &self.true_one {
                        let content = size_of::<Header>()..;
                        bytemuck::bytes_of_mut(message)[content.clone()]
                            .copy_from_slice(&bytemuck::bytes_of(last)[content]);
                    }
                }
                (Kind::Bias, Some(field)) => bias(message, field, amount),
                (Kind::Stale, _) => message.header_mut().acquisition_ns -= shift_ns,
                (Kind::ClockStep, _) => {
                    message.header_mut().acquisition_ns += shift_ns;
                    message.header_mut().publish_ns += shift_ns;
                }
                _ => {}
            }
        });
        if !frozen {
            self.true_one = Some(told);
        }
    }
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
