//! The counts of one process, as its service keeps them.

use super::account::Account;
use super::figures::Figures;
use super::file::CountsFile;
use crate::{Group, RuntimeError};
use messages::Service;

/// A process's side of its service's counts: in realtime in the service's file, else in its own memory.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    figures: Figures,
    file: Option<CountsFile>,
    account: Option<Account>,
}

impl Counts {
    /// Opens the file of `service`. The process has no account yet.
    pub(crate) fn open(group: &Group, service: Service) -> Result<Self, RuntimeError> {
        let file = CountsFile::open(group, service)?;
        let figures = Figures::of(CountsFile::open(group, service)?)?;
        Ok(Self { figures, file: Some(file), account: None })
    }

    /// Begins the account of process `incarnation`; without a file there is none.
    pub(crate) fn begin_account(&mut self, incarnation: u32) -> Result<(), RuntimeError> {
        self.account = match &self.file {
            Some(file) => Some(Account::begin(file, incarnation)?),
            None => None,
        };
        Ok(())
    }

    /// The named counts and histograms.
    pub(crate) fn figures(&self) -> &Figures {
        &self.figures
    }

    /// The account, once it has begun.
    pub(crate) fn account(&self) -> Option<&Account> {
        self.account.as_ref()
    }
}
