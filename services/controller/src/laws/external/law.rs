//! The law: a question and an answer at each release, and the backup where there is no answer.

use super::backup::{Backup, Reason};
use super::channel::{Channel, ChannelError};
use super::host::{Host, HostError, News};
use super::idle;
use super::process::Plan;
use super::record::{Bounds, Refused, accept, question};
use crate::law::ProgramReport;
use crate::law::{Hosted, HostedError, Input, Law, Output};
use scenario::Scenario;
use std::time::{Duration, Instant};

/// Part of the time to the deadline that is left to the backup and to the command's way.
const RESERVE: f64 = 0.1;
/// A law that a program of the user's computes.
pub struct External {
    plan: Plan,
    /// Time for which a program may owe an answer, in real time.
    silence: Duration,
    bounds: Bounds,
    backup: Backup,
    /// Other runs of this thread may use the program before and after this one.
    is_shared: bool,
    // The channel before the host: a program goes when its input ends.
    channel: Option<Box<Channel>>,
    host: Option<Host>,
    /// The program must clear its history.
    forget: bool,
    counts: ProgramReport,
    /// Fault of the first refused answer.
    refusal: Option<String>,
}

impl External {
    pub(super) fn new(plan: Plan, silence: Duration, bounds: Bounds, backup: Backup) -> Self {
        Self {
            plan,
            silence,
            bounds,
            backup,
            is_shared: false,
            channel: None,
            host: None,
            forget: true,
            counts: ProgramReport::default(),
            refusal: None,
        }
    }

    /// Takes the next program, if the host has one; waits for it if `patience` is given.
    fn look_for_program(&mut self, patience: Option<Duration>) -> Result<(), HostedError> {
        let Some(host) = &self.host else { return Ok(()) };
        let news = match patience {
            Some(patience) => host.news.recv_timeout(patience).ok(),
            None => host.news.try_recv().ok(),
        };
        match news {
            Some(News::Ready(channel)) => {
                (self.channel, self.forget) = (Some(channel), true);
                Ok(())
            }
            Some(News::Ended(why)) => Err(why),
            None => Ok(()),
        }
    }

    /// Describes the program's fault in a sentence; ends the program.
    fn explain(&mut self, error: ChannelError) -> HostedError {
        self.channel = None;
        let own = HostedError::new(error.clone());
        if let Some(host) = &self.host {
            host.explain(error);
            while let Ok(news) = host.news.recv() {
                if let News::Ended(why) = news {
                    return why;
                }
            }
        }
        own
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

    /// Asks, and waits for the answer until `deadline`.
    fn ask(&mut self, input: &Input, deadline: Instant) -> Result<Reply, ChannelError> {
        let Some(channel) = &mut self.channel else { return Ok(Reply::NoProgram) };
        // An answer to an earlier question comes too late to be used.
        if channel.unanswered_since().is_some() && channel.answer(Instant::now())?.is_none() {
            let owed =
                channel.unanswered_since().is_some_and(|since| since.elapsed() > self.silence);
            return match owed {
                true => Err(ChannelError::Silent { patience: self.silence }),
                false => Ok(Reply::Late),
            };
        }
        channel.ask(&question(input, channel.next_number(), self.forget))?;
        self.forget = false;
        Ok(match channel.answer(deadline)? {
            Some(answer) => Reply::Answer(Box::new(answer)),
            None => Reply::Late,
        })
    }
}

/// Result of a question.
enum Reply {
    Answer(Box<messages::LawAnswer>),
    Late,
    NoProgram,
}

impl Drop for External {
    fn drop(&mut self) {
        if self.is_shared
            && let (Some(channel), Some(host)) = (self.channel.take(), self.host.take())
            && channel.unanswered_since().is_none()
        {
            idle::put(self.plan.clone(), channel, host);
        }
    }
}

impl Hosted for External {
    fn share(&mut self) {
        self.is_shared = true;
    }

    fn start(&mut self) -> Result<(), HostedError> {
        if self.is_shared
            && self.host.is_none()
            && let Some((channel, host)) = idle::take(&self.plan)
        {
            (self.channel, self.host, self.forget) = (Some(channel), Some(host), true);
        }
        if self.host.is_none() {
            self.host = Some(Host::start(self.plan.clone()).map_err(HostedError::new)?);
            // The host's own watchdog is shorter.
            self.look_for_program(Some(2 * self.plan.patience + Duration::from_secs(5)))?;
        }
        match self.channel {
            Some(_) => Ok(()),
            None => Err(HostedError::new(HostError::Silent)),
        }
    }

    fn begin_realtime(&mut self, scenario: &Scenario) {
        if let Some(host) = &self.host {
            host.lend(scenario);
        }
    }

    fn step_within(
        &mut self,
        left: Option<Duration>,
        input: &Input,
        output: &mut Output,
    ) -> Result<(), HostedError> {
        if self.channel.is_none() && left.is_some() {
            // A host that has given up has said so in its report.
            let _ = self.look_for_program(None);
        }
        let patience = left.map_or(self.plan.patience, |left| left.mul_f64(1.0 - RESERVE));
        let heard = match self.ask(input, Instant::now() + patience) {
            Ok(heard) => heard,
            Err(error) if left.is_none() => return Err(self.explain(error)),
            Err(error) => {
                // Its input ends with the channel.
                self.channel = None;
                if let Some(host) = &self.host {
                    host.replace(error);
                }
                Reply::NoProgram
            }
        };
        match heard {
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
            Reply::Late if left.is_none() => {
                return Err(self.explain(ChannelError::Silent { patience }));
            }
            Reply::Late => self.drive_by_backup(Reason::Late, input, output),
            Reply::NoProgram => self.drive_by_backup(Reason::NoProgram, input, output),
        }
        Ok(())
    }

    fn report(&self) -> ProgramReport {
        let mut report = self.counts.clone();
        if let Some(host) = &self.host {
            let life = host.life.lock().expect("no holder panics");
            report.starts = life.starts;
            report.failures.clone_from(&life.failures);
            report.given_up = life.given_up;
        }
        if let Some(what) = &self.refusal {
            report.failures.insert(0, format!("{} answered {what}", self.plan.subject()));
        }
        report
    }
}

impl Law for External {
    fn reset(&mut self) {
        self.forget = true;
        self.backup.rest();
    }

    /// As in simulated time; the backup drives where the program fails.
    fn step(&mut self, input: &Input, output: &mut Output) {
        let started = self.host.is_some() || self.start().is_ok();
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
