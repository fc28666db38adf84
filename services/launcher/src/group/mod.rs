//! A process group: its private corner of the machine, its processes, its end.
//!
//! ```text
//! RunRoot::create ─ janitor ─ spawn services ─ all ready ─ start ─ events … ─ all reported ─ end ─ wipe
//! ```
//!
//! The launcher holds a lock on the run's root and every service inherits it. The lock is free when
//! the last of them is gone, however they went: the janitor, a process of its own, waits for that
//! when the launcher dies, and removes what the run left. What even the janitor could not remove, the
//! next run does.

mod attendant;
mod drive;
mod events;
mod janitor;
mod processes;
mod recording;
mod root;
mod supervisor;

pub use drive::{Drive, DriveStep, PowertrainStep};
pub use janitor::run as run_janitor;
pub use recording::RecordingSummary;
pub use supervisor::{Ended, GroupOutcome, Launch, launch};
