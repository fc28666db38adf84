//! Counts and times of a service, in one file of shared memory that outlives its processes.
//!
//! ```text
//! process ──► Counts ─┬─ Account: counts of this process ──────────────┐
//!                     └─ Figures: counts and histograms of all of them ┴─► file ──► CountsReader: launcher, standby
//! ```
//!
//! Words of the file that count ([`Counters`]) stand still while a process is a standby.

pub mod account;
mod counters;
pub mod figures;
pub(crate) mod file;
pub(crate) mod own;
pub mod reader;
pub mod statistics;

use counters::Counters;
