//! One run, and many at a time.
//!
//! ```text
//! Job ─┬─ memory: all services in the worker's thread ──────┬─► Done
//!      └─ shared memory: a process group (realtime, too) ───┘
//! ```
//!
//! An interrupt ends every run in progress and keeps further ones from beginning. Finished runs are kept.
//!
//! ```
//! use frame::batch::{Job, at_once};
//! use runtime::Mode;
//!
//! let scenario = supervise::open("following", &supervise::ScenarioOptions::default()).unwrap();
//! assert_eq!(Job::lockstep(scenario).mode, Mode::Lockstep);
//! assert_eq!(at_once(None, Mode::Realtime), 1, "realtime runs would measure each other");
//! ```

mod drive;
pub mod laws;
mod usage;
mod workers;

pub use drive::{Scratch, drive, lockstep, whole};
pub(crate) use drive::{drive_on, is_in_memory};
pub use usage::{Growth, leftovers};
pub use workers::{Interrupt, share};

use report::summary::Summary;
use runtime::{Carrier, Mode};
use scenario::Scenario;
use std::num::NonZeroUsize;
use std::time::Duration;
use supervise::{Drive, Error, GroupOptions};
use usage::Sample;

/// A run to be done.
#[derive(Clone, Debug)]
pub struct Job {
    pub scenario: Scenario,
    pub mode: Mode,
    /// Time between two samples of the resources of the run's processes; none: no samples.
    pub sample_every: Option<Duration>,
    /// Record the run, to a file that is removed with it.
    pub record: bool,
}

/// A run that was done.
#[derive(Debug)]
pub struct Done {
    pub summary: Summary,
    pub drive: Drive,
    /// Leftovers of the run; there should be none.
    pub leftovers: Vec<String>,
    /// Resources of its processes, sampled during the run.
    pub samples: Vec<Sample>,
}

impl Job {
    pub fn lockstep(scenario: Scenario) -> Self {
        Self { scenario, mode: Mode::Lockstep, sample_every: None, record: false }
    }
}

/// The carrier of a run's messages, as far as its clock and the options determine it.
fn carrier(group: &GroupOptions, mode: Mode) -> Carrier {
    let needs_processes = group.processes || mode == Mode::Realtime || !group.programs.is_empty();
    if needs_processes { Carrier::SharedMemory } else { Carrier::Memory }
}

/// Number of runs at once: the chosen one, else one for each core. In realtime it is one, since runs that share
/// cores would measure each other.
pub fn at_once(chosen: Option<NonZeroUsize>, mode: Mode) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    chosen.map_or_else(|| if mode == Mode::Realtime { 1 } else { cores() }, NonZeroUsize::get)
}

/// Refuses a scenario that its run would refuse, before any run begins.
pub fn check(scenario: &Scenario, mode: Mode, group: &GroupOptions) -> Result<(), Error> {
    group.programs()?;
    match carrier(group, mode) {
        Carrier::Memory => Ok(supervise::check_simulated(scenario)?),
        Carrier::SharedMemory => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn realtime_runs_have_the_machine_to_themselves_unless_asked() {
        assert_eq!(at_once(None, Mode::Realtime), 1);
        assert_eq!(at_once(NonZeroUsize::new(3), Mode::Realtime), 3);
        assert!(at_once(None, Mode::Lockstep) >= 1);
    }
}
