//! Recordings: everything that went over a run's topics, in a file that other tools read as well.
//!
//! A recording is an [MCAP](https://mcap.dev) file of profile `ros2`. The payload of a message is
//! the four bytes `00 01 00 00` (little-endian CDR) and the struct's own bytes, which *are* its CDR
//! body: `messages` checks that at compile time. Nothing is converted, neither on the way in
//! nor out. The schemas are ROS 2 message definitions made from the same layouts ([`schema`]).
//!
//! * [`run`]: the process that records a run while it goes on
//! * [`Writer`]: crash-safe, what was flushed survives any end of the process
//! * [`Recording`]: a file in memory, read as far as it goes, with what is missing said
//! * [`recover`]: the readable part of a broken file as a whole one
//! * [`replay`]: the process that sends recorded inputs to a controller again
//! * [`schema`]: the layouts as ROS 2, Python and C definitions

mod batch;
mod counter;
mod damage;
mod link;
mod metadata;
mod reader;
mod recover;
mod replayer;
mod scan;
pub mod schema;
mod service;
mod takes;
mod writer;

pub use damage::{Damage, ReadError};
pub use link::{FromRecorder, Report, Start, ToRecorder};
pub use metadata::{Host, Metadata, Tally, TopicTally};
pub use reader::{Record, Recording, Timed};
pub use recover::{Recovered, recover};
pub use replayer::{FromReplayer, ToReplayer, replay};
pub use service::run;
pub use takes::Take;
pub use writer::Writer;

/// Name of the recording in a run's directory of results.
pub const FILE: &str = "recording.mcap";
