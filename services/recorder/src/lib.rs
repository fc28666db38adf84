//! Recordings: everything that went over a run's topics, in a file that other tools read as well.
//!
//! A recording is an [MCAP](https://mcap.dev) file of profile `ros2`. The payload of a message is the four bytes `00
//! 01 00 00` (little-endian CDR) and the struct's own bytes. They *are* its CDR body: `messages` checks that at
//! compile time. Nothing is converted, neither on the way in nor out. The schemas are ROS 2 message definitions made
//! from the same layouts ([`schema`]).
//!
//! * [`run`]: the process that records a run while it goes on
//! * [`Taps`], [`Encoder`]: the messages of a run in progress, as a viewer reads them
//! * [`Writer`]: crash-safe, what was flushed survives any end of the process
//! * [`Recording`]: a file, read as a stream as far as it goes, with what is missing said
//! * [`recover`]: the readable part of a broken file as a whole one
//! * [`replay`]: the process that sends recorded inputs to a controller again
//! * [`schema`]: the layouts as ROS 2, Python and C definitions
//!
//! Log times are publication times on the wall's clock; in lockstep, simulated time from [`SIMULATED_START_NS`] on. A
//! file is in their order. Beside our messages it holds the road in standard ROS 2 types, for viewers; readers here
//! pass over them.

pub mod bag;
mod batch;
mod cdr;
mod counter;
mod damage;
mod definitions;
mod encoder;
mod link;
mod metadata;
mod outline;
mod reader;
mod records;
mod replayer;
mod scene;
pub mod schema;
mod sequencer;
mod service;
mod source;
mod takes;
mod writer;

pub use batch::{Batch, Taps};
pub use damage::{Damage, ReadError};
pub use encoder::{Channel, Encoder};
pub use link::{FromRecorder, Report, Start, ToRecorder, orders, say};
pub use mcap::Summary;
pub use metadata::{FigureName, Host, LawNames, Metadata, SIMULATED_START_NS, Tally, TopicTally};
pub use reader::{Recording, Survey};
pub use records::{Record, Records, Timed};
pub use replayer::{FromReplayer, ToReplayer, replay};
pub use service::{attend, begin, run};
pub use takes::{Cycle, Take};
pub use writer::{Writer, recover};

/// Name of the recording in a run's directory of results.
pub const FILE: &str = "recording.mcap";
