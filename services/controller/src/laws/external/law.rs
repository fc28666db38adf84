//! The law: a question and an answer at each release, and the backup where there is no answer.

use super::backup::{Backup, Reason};
use super::idle;
use super::record::{Bounds, Program, Refused, accept, question};
use crate::law::ProgramReport;
use crate::law::{Hosted, HostedError, Input, Law, Output};
use messages::{LawAnswer, Service};
use runtime::hosted::{Life, Plan, Proof, Reply};
use scenario::Scenario;
use std::time::Duration;

/// A law that a program of the user's computes.
pub struct External {
    program: Option<Program>,
    bounds: Bounds,
    backup: Backup,
    /// Other runs of this thread may use the program before and after this one.
    is_shared: bool,
    counts: ProgramReport,
    /// Fault of the first refused answer.
    refusal: Option<String>,
}

impl External {
    pub(super) fn new(plan: Plan, bounds: Bounds, backup: Backup) -> Self {
        let proof = Proof {
            question: question(&Input { period_s: 0.1, ..Input::default() }, 1, true),
            check: |answer: &LawAnswer| match answer.request_mps2 {
                request if request.is_finite() => Ok(()),
                request => Err(format!("request_mps2 = {request}, expected a finite number")),
            },
            service: Service::Controller,
        };
        Self {
            program: Some(Program::new(plan, proof)),
            bounds,
            backup,
            is_shared: false,
            counts: ProgramReport::default(),
            refusal: None,
        }
    }

    /// The program, which only the end of the law takes.
    fn program(&mut self) -> &mut Program {
        self.program.as_mut().expect("the law lives")
    }

    fn drive_by_backup(&mut self, reason: Reason, input: &Input, output: &mut Output) {
        match reason {
            Reason::Late => self.counts.late += 1,
            Reason::NoProgram => self.counts.absent += 1,
            Reason::Refused => self.counts.refused += 1,
            Reason::Answered => {}
        }
        self.backup.drive(reason, self.bounds, input, output);
    }
}

impl Drop for External {
    fn drop(&mut self) {
        if let Some(program) = self.program.take_if(|program| self.is_shared && program.is_idle()) {
            idle::put(program);
        }
    }
}

impl Hosted for External {
    fn share(&mut self) {
        self.is_shared = true;
    }

    fn start(&mut self) -> Result<(), HostedError> {
        let is_shared = self.is_shared;
        let program = self.program();
        if is_shared
            && !program.is_started()
            && let Some(waiting) = idle::take(&program.plan)
        {
            *program = waiting;
        }
        program.start().map_err(HostedError::new)
    }

    fn begin_realtime(&mut self, scenario: &Scenario) {
        self.program().lend(scenario);
    }

    fn step_within(
        &mut self,
        left: Option<Duration>,
        input: &Input,
        output: &mut Output,
    ) -> Result<(), HostedError> {
        let asked = self.program().ask(left, |number, reset| question(input, number, reset));
        match asked.map_err(HostedError::new)? {
            Reply::Answer(answer) => match accept(&answer, self.bounds, output) {
                Ok(()) => {
                    self.counts.answers += 1;
                    self.backup.rest();
                    output.mode_reason = Reason::Answered as u32;
                }
                Err(Refused(what)) => {
                    self.refusal.get_or_insert(what);
                    self.drive_by_backup(Reason::Refused, input, output);
                }
            },
            Reply::Late => self.drive_by_backup(Reason::Late, input, output),
            Reply::Absent => self.drive_by_backup(Reason::NoProgram, input, output),
        }
        Ok(())
    }

    fn report(&self) -> ProgramReport {
        let Some(program) = &self.program else { return self.counts.clone() };
        let Life { starts, mut failures, given_up } = program.life();
        if let Some(what) = &self.refusal {
            failures.insert(0, format!("{} answered {what}", program.plan.subject()));
        }
        ProgramReport { starts, failures, given_up, ..self.counts.clone() }
    }
}

impl Law for External {
    fn reset(&mut self) {
        self.program().forget();
        self.backup.rest();
    }

    /// As in simulated time; the backup drives where the program fails.
    fn step(&mut self, input: &Input, output: &mut Output) {
        let started = self.program().is_started() || self.start().is_ok();
        if !started || self.step_within(None, input, output).is_err() {
            self.drive_by_backup(Reason::NoProgram, input, output);
        }
    }

    fn request_bounds_mps2(&self) -> (f64, f64) {
        (self.bounds.least_mps2, self.bounds.most_mps2)
    }

    fn hosted(&mut self) -> Option<&mut dyn Hosted> {
        Some(self)
    }
}
