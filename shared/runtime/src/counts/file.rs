//! The file in shared memory in which a service counts.
//!
//! ```text
//! page 0         names of histograms | names of counts | counts
//! pages 1 to 8   accounts: one page a process, in turn
//! pages 9 to 12  buckets and extremes of the first histogram
//! ...            four pages for each further histogram
//! ```
//!
//! A page gets memory when a process opens it. The file is removed with everything else that carries the run's prefix.

use super::statistics::KEPT_WORDS;
use crate::words::{PAGE_BYTES, SharedWords, WORDS, open_existing_own, open_own};
use crate::{Group, RuntimeError};
use messages::Service;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Most histograms, and most counts, of a service: a plant with an emergency brake has 32 histograms.
pub(super) const SLOTS: usize = 40;
/// Pages for accounts. A service has at most three processes whose account still counts: the active one, a standby, and
/// one that has just ended.
const ACCOUNTS: usize = 8;
const FIRST_ACCOUNT: usize = 1;
const FIRST_HISTOGRAM: usize = FIRST_ACCOUNT + ACCOUNTS;
/// Pages of a histogram.
const HISTOGRAM_PAGES: usize = KEPT_WORDS.div_ceil(WORDS);
/// Largest size of a service's file, bytes.
pub(crate) const MOST_BYTES: usize = (FIRST_HISTOGRAM + SLOTS * HISTOGRAM_PAGES) * PAGE_BYTES;

/// A service's file.
#[derive(Debug)]
pub(super) struct CountsFile(File);

/// Path of the file of `service` in the run with this prefix.
fn path(prefix: &str, service: Service) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.counts"))
}

impl CountsFile {
    /// Opens the file, or makes it.
    pub(super) fn open(group: &Group, service: Service) -> Result<Self, RuntimeError> {
        let path = path(&group.prefix, service);
        open_own(&path).map(Self).map_err(RuntimeError::setup(path.display().to_string()))
    }

    /// Opens the file that a process of the service made; `None` if there is none.
    pub(super) fn existing(group: &Group, service: Service) -> Option<Self> {
        open_existing_own(&path(&group.prefix, service)).ok().map(Self)
    }

    /// The page of names and counts.
    pub(super) fn names(&self) -> io::Result<SharedWords> {
        SharedWords::of(&self.0, 0, 1)
    }

    /// The page for the account of process `incarnation`.
    pub(super) fn account(&self, incarnation: u32) -> io::Result<SharedWords> {
        SharedWords::of(&self.0, FIRST_ACCOUNT + incarnation as usize % ACCOUNTS, 1)
    }

    /// The words of histogram `slot`.
    pub(super) fn histogram(&self, slot: usize) -> io::Result<SharedWords> {
        SharedWords::of(&self.0, FIRST_HISTOGRAM + slot * HISTOGRAM_PAGES, HISTOGRAM_PAGES)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{Mode, Timetable};

    /// A run whose file of the plant's counts is removed with it.
    pub(in super::super) struct Run(pub Group);

    impl Run {
        pub(in super::super) fn new(name: &str) -> Self {
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
