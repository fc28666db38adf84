//! Typed ends of a topic, with stamps, counts and digests.

mod checks;
mod intake;
pub mod members;
pub mod observer;
pub mod player;
mod publisher;
mod registry;
mod subscriber;
mod tally;
pub mod tap;

pub(super) use checks::{Checks, Expected};
pub(super) use intake::{Intake, Next, Wire};
pub use publisher::Publisher;
pub(super) use publisher::{Backlog, Outgoing, Outlet, Protection};
pub(super) use registry::Ports;
pub use subscriber::Subscriber;
pub(super) use tally::{Counted, Tally};
