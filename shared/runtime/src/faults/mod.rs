//! Faults of messages: on the channel and in the sender.
//!
//! Faults come from the scenario or, during the run, from the launcher. Whether a fault acts on a
//! message is decided by the run's seed, the fault and the message's own number alone, so that it is
//! the same for every receiver, on either clock.
//!
//! * [`ChannelFaults`] disturbs messages between their arrival and a receiver's end-to-end check: `delay`,
//!   `drop`, `duplicate`, `reorder`, `corrupt`;
//! * [`SenderFaults`] falsifies messages before they are protected: `freeze`, `bias`, `stale`, `clock-step`.
//!
//! Without faults a port asks one flag per message.

mod activation;
mod channel;
mod sender;
#[cfg(test)]
mod tests;

pub use activation::{FaultStatistics, Injected, concerned};
pub(super) use activation::{Faults, Inbox};
pub(super) use channel::ChannelFaults;
pub(super) use sender::SenderFaults;
