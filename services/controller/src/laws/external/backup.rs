//! The road controller that drives where a law of the user's has no answer.

use super::record::Bounds;
use crate::law::{Input, Law, Output, Quality};
use messages::LAW_MODES;

/// Mode of the backup, behind the law's own.
const MODE: u32 = LAW_MODES as u32;

/// Reasons of the mode, by the formulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    Answered,
    Late,
    NoProgram,
    Refused,
}

pub(super) struct Backup {
    law: Box<dyn Law>,
    /// It drove at the last release.
    drives: bool,
}

impl Backup {
    pub(super) fn new(law: Box<dyn Law>) -> Self {
        Self { law, drives: false }
    }

    /// The law drives again.
    pub(super) fn rest(&mut self) {
        self.drives = false;
    }

    /// Drives at one release, from the initial state where it takes over.
    pub(super) fn drive(
        &mut self,
        reason: Reason,
        bounds: Bounds,
        input: &Input,
        output: &mut Output,
    ) {
        if !self.drives {
            self.law.reset();
        }
        self.drives = true;
        self.law.step(input, output);
        for request in &mut output.plan_mps2[..output.plan_len] {
            *request = bounds.bring_in(*request);
        }
        // Its own modes and figures would be taken for the law's.
        *output = Output {
            plan_mps2: output.plan_mps2,
            plan_len: output.plan_len,
            mode: MODE,
            mode_reason: reason as u32,
            quality: Quality::Backup,
            solver_iterations: output.solver_iterations,
            ..Output::default()
        };
    }
}
