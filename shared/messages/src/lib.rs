//! The messages, topics and services that all processes agree on, and the protection of each message.
//!
//! A message is `repr(C)` plain data without padding: SI units, x forward, y left, little-endian.
//!
//! ```text
//!  0             24                            64                   208            end
//! ┌──────────────┬─────────────────────────────┬────────────────────┬─────────────┐
//! │ protection   │ sequence, step, two stamps, │ stamps of 6 inputs │ own fields  │
//! │ CRC, counter │ incarnation, source         │ (`Origins`)        │ in SI units │
//! └──────────────┴─────────────────────────────┴────────────────────┴─────────────┘
//!  ◄──────────────────────── `Header` ──────────────────────────────►
//! ```
//!
//! | to find | look at |
//! | --- | --- |
//! | the topics, who sends and who receives them | [`Topic`]: one row each |
//! | the services, with all that is known before their code | [`Service`], [`Descriptor`]: one row each |
//! | the bytes of a message as data, with the meaning of each field | [`Layout`] |
//! | what detects a damaged, lost or repeated message | [`e2e`] |
//! | what a controller and a plant do without an input | [`level`] |
//! | what a program of the user's reads and answers as a law | [`LawInput`], [`LawAnswer`] |
//!
//! A sender fills a message in, protects it, and a receiver accepts or refuses it:
//!
//! ```
//! use bytemuck::{Zeroable, bytes_of, bytes_of_mut};
//! use messages::e2e::{Channel, Outcomes, profile7};
//! use messages::{Odometry, Service, Topic};
//!
//! let mut odometry = Odometry { speed_mps: 25.0, ..Odometry::zeroed() };
//! let data_id = Topic::Odometry.data_id(Service::Plant.to_wire());
//! profile7::protect(bytes_of_mut(&mut odometry), data_id, 1);
//!
//! let (mut channel, mut outcomes) = (Channel::default(), Outcomes::default());
//! assert!(channel.accept(bytes_of(&odometry), data_id, 0, &mut outcomes));
//! odometry.speed_mps = 26.0;
//! assert!(!channel.accept(bytes_of(&odometry), data_id, 0, &mut outcomes));
//! assert_eq!((outcomes.ok, outcomes.error), (1, 1));
//! ```
//!
//! The `truth/` topics carry the simulators' truth, and no fault changes it. The simulated sensors measure from them,
//! and the referee in the plant judges by them. No actuation depends on them.

mod brake;
mod control;
mod crowd;
pub mod e2e;
mod header;
mod health;
mod law;
mod layout;
pub mod level;
pub mod names;
mod numbered;
mod perception;
mod place;
mod plane;
mod radio;
mod service;
mod topic;
mod v2x;
mod vehicle;

pub use brake::*;
pub use control::*;
pub use crowd::*;
pub use header::{Header, Origin, Origins};
pub use health::*;
pub use law::*;
pub use layout::{Element, Field, Laid, Layout, SMALL_BYTES, Scalar, Shape};
pub use perception::*;
pub use place::{Place, Value};
pub use plane::*;
pub use radio::*;
pub use service::{Descriptor, Pace, Presence, Service, UnknownService};
pub use topic::{LAYOUT_VERSION, Message, Role, TOPICS, Topic};
pub use v2x::*;
pub use vehicle::*;
