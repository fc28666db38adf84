//! Counts and times of a service, in one file of shared memory that outlives its processes.
//!
//! ```text
//! Figures of a process: counts and histograms of all, cycles of this one ─► file ──► Figures of launcher, standby
//! OwnAccount: what this process counted ─────────────► file of its own ──► LastAccount of the launcher
//! ```
//!
//! The service's file is a [`State`]. Each of its parts gets memory when a process opens it. The files are removed with
//! everything else that carries the run's prefix.

pub mod account;
pub mod figures;
pub mod statistics;

use figures::Names;
use statistics::Buckets;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Most histograms, and most counts, of a service: a plant with an emergency brake has 32 histograms.
const SLOTS: usize = 40;
/// Processes whose cycles are shown: the active one, a standby, and those that have just ended.
const PROCESSES: usize = 8;

/// The struct in a service's file.
#[repr(C)]
struct State {
    names: Names,
    histograms: [Buckets; SLOTS],
}

/// Largest size of a service's file, bytes.
pub(crate) const MOST_BYTES: usize = size_of::<State>();

/// Path of the file of `service` in the run with this prefix.
fn path(prefix: &str, service: impl Display) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.counts"))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{Group, Mode, Timetable};
    use messages::Service;

    /// A run whose file of the plant's counts is removed with it.
    pub(crate) struct Run(pub(crate) Group);

    impl Run {
        pub(crate) fn new(name: &str) -> Self {
            Self(Group {
                root: "/tmp".into(),
                prefix: format!("timegap_counts-{name}-{}_", std::process::id()),
                mode: Mode::Realtime,
                standby: Vec::new(),
                timetable: Timetable { step_ns: 1, strides: [1; Service::ALL.len()], last_step: 1 },
                patience_ns: 1,
                scenario: String::new(),
            })
        }
    }

    impl Drop for Run {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(path(&self.0.prefix, Service::Plant));
        }
    }
}
