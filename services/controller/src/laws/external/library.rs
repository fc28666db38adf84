//! A law in a shared library, in this process. It is as fast and as close as a law of timegap's own.
//!
//! Its answers pass the same checks as a program's. An answer that no vehicle can follow is refused, and the backup
//! drives in its place. Requests are brought within the bounds, and late cycles are counted. A library that never
//! returns or crashes takes the process with it.

use super::backup::{Backup, Reason};
use super::bounds::Bounds;
use super::record::{Refused, accept, question};
use crate::law::{Hosted, HostedError, Input, Law, Output};
use crate::report::ProgramReport;
use bytemuck::Zeroable;
use messages::LawAnswer;
use runtime::LawLibrary;
use std::time::Duration;

/// The law.
pub struct Library {
    library: LawLibrary,
    name: String,
    bounds: Bounds,
    backup: Backup,
    forget: bool,
    counts: ProgramReport,
}

impl Library {
    pub(super) fn new(library: LawLibrary, name: &str, bounds: Bounds, backup: Backup) -> Self {
        Self {
            library,
            name: name.to_owned(),
            bounds,
            backup,
            forget: true,
            counts: ProgramReport { starts: 1, ..ProgramReport::default() },
        }
    }
}

impl Hosted for Library {
    fn step_within(
        &mut self,
        _left: Option<Duration>,
        input: &Input,
        output: &mut Output,
    ) -> Result<(), HostedError> {
        let question = question(input, self.counts.answers + self.counts.refused + 1, self.forget);
        self.forget = false;
        let mut answer = LawAnswer::zeroed();
        self.library.step(&question, &mut answer);
        match accept(&answer, self.bounds, output) {
            Ok(()) => {
                self.counts.answers += 1;
                self.backup.rest();
            }
            Err(Refused(what)) => {
                self.counts.refused += 1;
                if self.counts.failures.is_empty() {
                    self.counts.failures.push(format!("the law `{}` answered {what}", self.name));
                }
                self.backup.drive(Reason::Refused, self.bounds, input, output);
            }
        }
        Ok(())
    }

    fn report(&self) -> ProgramReport {
        self.counts.clone()
    }
}

impl Law for Library {
    fn reset(&mut self) {
        self.forget = true;
        self.backup.rest();
    }

    fn step(&mut self, input: &Input, output: &mut Output) {
        // It cannot fail: what is refused is the backup's.
        let _ = self.step_within(None, input, output);
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        (self.bounds.least_mps2, self.bounds.most_mps2)
    }

    fn hosted(&mut self) -> Option<&mut dyn Hosted> {
        Some(self)
    }
}
