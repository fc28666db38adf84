//! Faults of messages: on the channel and in the sender.
//!
//! Faults come from the scenario or, during the run, from the launcher. The run's seed, the fault and the
//! message's own number alone decide whether a fault acts on it. So it is the same for every receiver, on
//! either clock.
//!
//! ```text
//! Falsified ─► protection ─► topic ─► senders, losses ─► Disturbed ─► end-to-end check
//! ```
//!
//! * [`Disturbed`] is a part of a receiving end. It disturbs messages between their arrival and the end-to-end
//!   check: `delay`, `drop`, `duplicate`, `reorder`, `corrupt`. A receiver in lockstep counts its message as arrived,
//!   even if it never gets it.
//! * [`Falsified`] is a part of a sending end. It changes messages before they are protected: `freeze`,
//!   `bias`, `stale`, `clock-step`.
//!
//! A port has such a part only where a fault can come to act. In one process the scenario decides that at the start.
//! Between processes the launcher can send a fault at any time: there a part asks one flag per message.

mod activation;
mod channel;
mod sender;
#[cfg(test)]
mod tests;

pub(super) use activation::Faults;
pub use activation::{FaultStatistics, Injected, concerned};
pub(super) use channel::Disturbed;
pub(super) use sender::Falsified;
