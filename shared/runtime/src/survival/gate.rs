//! Whether a process's messages leave it: a standby keeps them back, a replaced process may not send.

use crate::survival::fence::{self, Fences};
use messages::Service;
use std::cell::Cell;
use std::sync::atomic::AtomicU32;

/// What becomes of a message that is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passage {
    /// It is sent.
    Open,
    /// It is kept, since the process is a standby.
    Held,
    /// It is dropped, since the process was replaced.
    Shut,
}

/// The gate of one process, shared by its ports.
#[derive(Debug)]
pub(crate) struct Gate {
    fences: Option<Fences>,
    service: Service,
    incarnation: u32,
    is_standby: Cell<bool>,
}

impl Gate {
    pub(crate) fn of(fences: Option<Fences>, service: Service, incarnation: u32) -> Self {
        Self { fences, service, incarnation, is_standby: Cell::new(false) }
    }

    /// Always open: of a sender without a standby.
    pub(crate) fn open(service: Service) -> Self {
        Self::of(None, service, 0)
    }

    /// The process is a standby from now on, or is none any more.
    pub(crate) fn set_standby(&self, is_standby: bool) {
        self.is_standby.set(is_standby);
    }

    /// True while the process is a standby.
    pub(crate) fn is_standby(&self) -> bool {
        self.is_standby.get()
    }

    /// The service's epoch; `None` where it has no standby.
    fn word(&self) -> Option<&AtomicU32> {
        self.fences.as_ref().and_then(|fences| fences.of_service(self.service))
    }

    /// Makes this process the active one, where it was started in the place of one that is gone; false if
    /// another process is it.
    pub(crate) fn claim(&self) -> bool {
        self.word().is_none_or(|word| fence::claim(word, self.incarnation))
    }

    /// What becomes of a message that is sent now.
    pub(crate) fn passage(&self) -> Passage {
        if self.is_standby() {
            return Passage::Held;
        }
        match self.word() {
            Some(word) if !fence::may_send(word, self.incarnation) => Passage::Shut,
            _ => Passage::Open,
        }
    }
}
