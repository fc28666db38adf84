//! `[[faults]]`: what goes wrong, when, and for how long.
//!
//! A fault of a process is carried out by the launcher, one of a channel between a message's arrival and
//! the receiver's check, one of a sender before the message is protected. `file` reads the table.

mod begin;
mod effect;
mod file;
mod kind;
mod topic;

pub use begin::{Begin, Condition, STANDSTILL_MPS};
pub use effect::{
    ChannelFault, Disturbance, Effect, Extent, Falsification, Helper, ProcessFault, SenderFault,
    Target,
};
pub use file::read;
pub(super) use file::{keys_of, of_table, take_from, written};
pub use kind::Kind;
pub use topic::{BiasedField, NoSuchTopic, TopicName};

use serde::{Deserializer, Serialize};

/// Most faults in one scenario.
pub const MAX_FAULTS: usize = 64;

/// The list within a scenario, whose table has been taken out before: only the key's name is known there.
pub(super) fn taken<'de, D: Deserializer<'de>>(_: D) -> Result<Vec<Fault>, D::Error> {
    Ok(Vec::new())
}

/// A fault.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// When it begins.
    #[serde(flatten)]
    pub begin: Begin,
    /// What happens.
    #[serde(flatten)]
    pub effect: Effect,
}
