//! The reader of a service's counts: for the launcher, and for a standby that watches the active process.

use super::account::{Account, LastAccount, Progress};
use super::figures::Figures;
use super::file::CountsFile;
use crate::Group;
use messages::Service;

/// The counts of a service in the run of `group`, as another process reads them. They are empty if the service made no
/// file.
///
/// The service's processes may all be gone.
#[derive(Debug)]
pub struct CountsReader {
    figures: Figures,
    file: Option<CountsFile>,
}

impl CountsReader {
    /// Opens the file of `service`.
    #[must_use]
    pub fn of(group: &Group, service: Service) -> Self {
        let file = || CountsFile::existing(group, service);
        let figures = file().and_then(|file| Figures::of(file).ok()).unwrap_or_default();
        Self { figures, file: file() }
    }

    /// The named counts and histograms of all its processes.
    #[must_use]
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// The progress of process `incarnation`; `None` if it keeps no account.
    #[must_use]
    pub fn progress(&self, incarnation: u32) -> Option<Progress> {
        Account::of(self.file.as_ref()?, incarnation).map(Progress::of)
    }

    /// The counts of process `incarnation`, which is gone; `None` if it kept no account. They are taken once.
    #[must_use]
    pub fn take_account(&self, incarnation: u32) -> Option<LastAccount> {
        Account::of(self.file.as_ref()?, incarnation).map(Account::take)
    }
}
