//! Typed ends of a topic. A message takes four steps from one to the other:
//!
//! ```text
//! Loan ─► the service writes ─► Seal ─► Deliver ─► Check ─► newest
//! memory    header, (false content),    shared      sender, (disturbed channel),
//! to write  protection, count           memory,     epoch, end-to-end, clock
//!                                       or memory
//! ```
//!
//! [`Loan`](crate::Loan) and what delivers belong to the carrier (`transport`). A [`Publisher`] seals, a [`Subscriber`] checks
//! ([`check`]). What stands in brackets acts only where faults do ([`crate::faults`]).

mod bystanders;
mod check;
pub mod members;
mod publisher;
mod registry;
mod subscriber;
mod tally;

pub use bystanders::{Observed, Observer, Played, Player, Tap, Tapped};
pub(super) use check::{Check, Expected};
pub use publisher::Publisher;
pub(super) use publisher::{Backlog, Protection, Seal};
pub(super) use registry::Ports;
pub use subscriber::Subscriber;
pub(super) use tally::{Counted, Tally};
