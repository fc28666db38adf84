//! Counts and times of a service, in memory that outlives its processes.
//!
//! ```text
//! Account:   counts of one process, a page of its own      ─┐
//! Figures:   counts and histograms of all its processes     ├─► read by the launcher
//! Counters:  words of that memory that count, or stand still┘   while the process is a standby
//! ```

pub mod account;
mod counters;
pub mod figures;
pub mod statistics;

use counters::Counters;
