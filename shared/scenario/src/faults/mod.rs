//! `[[faults]]`: what goes wrong, when, and for how long.
//!
//! A kind of fault is one row in `effect.rs`. The launcher carries out a fault of a process. A fault of a channel acts
//! between a message's arrival and the receiver's check. A fault of a sender acts before the message is protected.
//! `file` reads a fault's table and writes it.
//!
//! ```
//! use scenario::faults::{self, Kind, Target};
//!
//! let keys = "kind = \"drop\"\ntopic = \"radar/tracks\"\nfor_s = 0.5".parse().expect("TOML");
//! let fault = faults::read(keys)?;
//! assert_eq!(fault.effect.kind(), Kind::Drop);
//! assert_eq!(fault.effect.target(), Target::Topic(messages::Topic::RadarTracks));
//! # Ok::<(), scenario::Problem>(())
//! ```

mod begin;
mod effect;
mod file;
mod rows;
mod topic;

pub use begin::{Begin, Condition, STANDSTILL_MPS};
pub use effect::{
    ChannelFault, Disturbance, Effect, Extent, Falsification, Helper, Kind, ProcessFault,
    SenderFault, Target,
};
pub(super) use file::take_from;
pub use file::{keys_of, read};
pub use topic::{BiasedField, TopicName};

use serde::{Deserialize, Serialize};

/// Most faults in one scenario.
pub const MAX_FAULTS: usize = 64;

/// A fault whose keys were checked: [`read`] takes those from outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    #[serde(flatten)]
    pub effect: Effect,
    #[serde(flatten)]
    pub begin: Begin,
}
