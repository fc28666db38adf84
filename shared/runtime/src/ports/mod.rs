//! Typed ends of a topic, with stamps, counts and digests.

pub mod members;
pub mod observer;
pub mod player;
mod publisher;
mod subscriber;
mod tally;
pub mod tap;

pub use publisher::Publisher;
pub(super) use publisher::{Backlog, Outlet};
pub(super) use subscriber::Expected;
pub use subscriber::Subscriber;
pub(super) use tally::Tally;
