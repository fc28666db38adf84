//! Typed ends of a topic, with stamps, counts and digests.

mod publisher;
mod subscriber;
mod tally;

pub use publisher::Publisher;
pub(super) use publisher::{Backlog, Outlet};
pub(super) use subscriber::Expected;
pub use subscriber::Subscriber;
pub(super) use tally::Tally;
