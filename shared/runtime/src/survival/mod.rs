//! Survival of a process's end: state that outlives it, epochs and standbys that replace it.
//!
//! ```text
//! process ──► Counts: one file a service ──► read by the launcher and by a standby
//!         ──► Checkpoint: state ───────────► read by the next process
//!
//! Gate: may this process speak?  ◄── Peers: one epoch a service   ◄── Standby: takes the epoch over
//! ```

pub mod checkpoint;
pub mod end_word;
pub mod fence;
pub mod standby;

use crate::counts::account::OwnAccount;
use crate::counts::figures::Figures;
use fence::{Gate, Peers};
use messages::Service;
use standby::Standby;
use std::rc::Rc;

/// Parts by which a service survives the end of a process.
#[derive(Debug)]
pub(crate) struct Survival {
    pub(crate) figures: Figures,
    /// What this process counted, for the launcher.
    pub(crate) account: Option<OwnAccount>,
    pub(crate) gate: Rc<Gate>,
    pub(crate) standby: Option<Standby>,
    /// Cycles and skipped releases of the time as a standby.
    silent: (u64, u64),
}

impl Survival {
    /// The survival of process `incarnation` of `service`, which counts in `figures`.
    pub(crate) fn new(
        figures: Figures,
        peers: Option<Peers>,
        service: Service,
        incarnation: u32,
    ) -> Self {
        let gate = Rc::new(Gate::of(peers, service, incarnation));
        Self { figures, account: None, gate, standby: None, silent: (0, 0) }
    }

    /// Ends the time as a standby, in which `cycles` were run and `skipped` releases left out.
    pub(crate) fn become_active(&mut self, cycles: u64, skipped: u64) {
        self.standby = None;
        self.silent = (cycles, skipped);
        self.figures.set_recording(true);
    }

    /// The cycles and skipped releases of the active process, without those of the standby.
    pub(crate) fn counted(&self, cycles: u64, skipped: u64) -> (u64, u64) {
        (cycles - self.silent.0, skipped - self.silent.1)
    }
}

#[cfg(test)]
mod process_tests;
