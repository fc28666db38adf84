//! Counts and times of a service, in one file of shared memory that outlives its processes.
//!
//! ```text
//! ServiceCounts ─┬─ Figures: counts and histograms of all processes ┬─► file ──► ServiceCounts of launcher, standby
//! of a process   └─ cycles of this process ─────────────────────────┘
//! OwnAccount: what this process counted ─────► file of its own ──► LastAccount of the launcher
//! ```
//!
//! The service's file is a [`State`]. Each of its parts gets memory when a process opens it. The files are removed with
//! everything else that carries the run's prefix.

pub mod account;
pub mod figures;
pub mod statistics;

use crate::words::{open_existing_own, open_own};
use crate::{Group, RuntimeError};
use figures::{Figures, Names, Progress};
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

/// The counts of a service: in realtime those in its file, else the calling process's own.
///
/// Another process reads them with the same type. The service's processes may all be gone.
#[derive(Debug, Default)]
pub struct ServiceCounts {
    figures: Figures,
    /// Process whose cycles it shows.
    shown: Option<u32>,
}

/// Path of the file of `service` in the run with this prefix.
fn path(prefix: &str, service: impl Display) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.counts"))
}

impl ServiceCounts {
    /// The counts of a process of `service`, or of anything else that counts under that name in the run. It makes the
    /// file if there is none.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for it.
    pub fn open(group: &Group, service: impl Display) -> Result<Self, RuntimeError> {
        let path = path(&group.prefix, service);
        let figures = open_own(&path).and_then(Figures::of);
        let figures = figures.map_err(RuntimeError::setup(path.display().to_string()))?;
        Ok(Self { figures, shown: None })
    }

    /// The counts of `service` in the run of `group`, as another process reads them. They are empty if the service made
    /// no file.
    pub fn of(group: &Group, service: impl Display) -> Self {
        let file = open_existing_own(&path(&group.prefix, service));
        Self { figures: file.and_then(Figures::of).unwrap_or_default(), shown: None }
    }

    /// The named counts and histograms of all processes of the service.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// Shows others from now on that this is process `incarnation`, and its cycles.
    pub fn begin(&mut self, incarnation: u32) {
        self.shown = Some(incarnation);
        self.figures.show(incarnation, 0);
    }

    /// Shows others that this process, which has begun, has done `cycles`.
    pub fn show_progress(&self, cycles: u64) {
        if let Some(incarnation) = self.shown {
            self.figures.show(incarnation, cycles);
        }
    }

    /// The progress of process `incarnation`; `None` if it shows no cycles.
    pub fn progress(&self, incarnation: u32) -> Option<Progress> {
        self.figures.progress(incarnation)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{Mode, Timetable};
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
                scenario: Vec::new(),
            })
        }
    }

    impl Drop for Run {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(path(&self.0.prefix, Service::Plant));
        }
    }
}
