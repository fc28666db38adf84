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
//! * [`Disturbed`] is a decorator of a receiving end. It disturbs messages between their arrival and the end-to-end
//!   check: `delay`, `drop`, `duplicate`, `reorder`, `corrupt`. A receiver in lockstep counts its message as arrived,
//!   even if it never gets it.
//! * [`Falsified`] is a decorator of a sending end. It changes messages before they are protected: `freeze`,
//!   `bias`, `stale`, `clock-step`.
//!
//! The ports do not depend on faults. Without faults a decorator asks one flag per message.

mod activation;
mod channel;
mod decorators;
mod sender;
#[cfg(test)]
mod tests;

pub use activation::{FaultStatistics, Injected, concerned};
pub(super) use activation::{Faults, Inbox};
pub(super) use decorators::{Disturbed, Falsified};
