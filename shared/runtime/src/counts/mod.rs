//! Counts and times of a service, in one file of shared memory that outlives its processes.
//!
//! ```text
//! ServiceCounts ─┬─ OwnAccount: counts of this process ───────────┐
//! of a process   └─ Figures: counts and histograms of all of them ┴─► file ──► ServiceCounts of launcher, standby
//! ```
//!
//! The file is a [`State`]. Each of its parts gets memory when a process opens it. The file is removed with everything
//! else that carries the run's prefix.

pub mod account;
pub mod figures;
pub mod statistics;

use crate::words::{open_existing_own, open_own};
use crate::{Group, RuntimeError};
use account::{Account, LastAccount, OwnAccount, Progress};
use figures::{Figures, Names};
use statistics::Buckets;
use std::fmt::Display;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Most histograms, and most counts, of a service: a plant with an emergency brake has 32 histograms.
const SLOTS: usize = 40;
/// Accounts. A service has at most three processes whose account still counts: the active one, a standby, and one that
/// has just ended.
const ACCOUNTS: usize = 8;

/// The struct in a service's file.
#[repr(C)]
struct State {
    names: Names,
    accounts: [Account; ACCOUNTS],
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
    file: Option<File>,
    account: Option<OwnAccount>,
}

/// Path of the file of `service` in the run with this prefix.
fn path(prefix: &str, service: impl Display) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.counts"))
}

impl ServiceCounts {
    /// The counts of a process of `service`, or of anything else that counts under that name in the run. It makes the
    /// file if there is none, and has no account yet.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for it.
    pub fn open(group: &Group, service: impl Display) -> Result<Self, RuntimeError> {
        let path = path(&group.prefix, service);
        let made = || {
            let file = open_own(&path)?;
            Ok(Self { figures: Figures::of(file.try_clone()?)?, file: Some(file), account: None })
        };
        made().map_err(RuntimeError::setup(path.display().to_string()))
    }

    /// The counts of `service` in the run of `group`, as another process reads them. They are empty if the service made
    /// no file.
    pub fn of(group: &Group, service: impl Display) -> Self {
        let found = || {
            let file = open_existing_own(&path(&group.prefix, service)).ok()?;
            let figures = Figures::of(file.try_clone().ok()?).ok()?;
            Some(Self { figures, file: Some(file), account: None })
        };
        found().unwrap_or_default()
    }

    /// The named counts and histograms of all processes of the service.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// Begins the account of process `incarnation`; without a file there is none.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for it.
    pub fn begin_account(&mut self, incarnation: u32) -> Result<(), RuntimeError> {
        let begin = |file| OwnAccount::begin(file, incarnation);
        let account = self.file.as_ref().map(begin).transpose();
        self.account = account.map_err(RuntimeError::setup("the account in shared memory"))?;
        Ok(())
    }

    /// This process's account, once it has begun.
    pub(crate) fn account(&mut self) -> Option<&mut OwnAccount> {
        self.account.as_mut()
    }

    /// Shows others that this process has done `cycles`.
    pub fn show_progress(&mut self, cycles: u64) {
        if let Some(account) = &mut self.account {
            account.show_progress(cycles);
        }
    }

    /// The progress of process `incarnation`; `None` if it keeps no account.
    pub fn progress(&self, incarnation: u32) -> Option<Progress> {
        Account::of(self.file.as_ref()?, incarnation).map(Progress::of)
    }

    /// The counts of process `incarnation`, which is gone; `None` if it kept no account. They are taken once.
    #[must_use]
    pub fn take_account(&self, incarnation: u32) -> Option<LastAccount> {
        Account::of(self.file.as_ref()?, incarnation).map(|account| account.take())
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
