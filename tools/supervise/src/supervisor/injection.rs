//! Faults of a run under way: those of processes that are due, and those from outside.

use super::Supervisor;
use crate::Error;
use crate::events::Answer;
use crate::faults::disturbance::Disturbance;
use crate::faults::{Act, LiveProcess};
use crate::refusal::absent;
use crate::succession::Phase;
use drive::log::DriveLog;
use messages::Service;
use runtime::{Injected, Mode, ToService, concerned};
use rustix::process::Signal;
use scenario::faults::{Effect, Fault, Helper};
use std::collections::BTreeMap;

impl Supervisor<'_> {
    /// Applies the faults of processes that are due.
    pub(super) fn apply_faults(&mut self, log: &DriveLog, now_ns: i64) {
        let living: BTreeMap<Service, LiveProcess> = (self.roster.iter())
            .filter(|member| member.report.is_none())
            .filter_map(|member| {
                let starting_since_ns = match member.phase() {
                    Phase::Running => None,
                    Phase::Starting { since_ns } => Some(since_ns),
                    Phase::Vacant { .. } | Phase::Waiting { .. } | Phase::GivenUp => return None,
                };
                let incarnation = member.incarnation();
                Some((member.role, LiveProcess { incarnation, starting_since_ns }))
            })
            .collect();
        let due = self.faults.due(now_ns, log.ego(), |service| living.get(&service).copied());
        for (index, act) in due {
            let mut disturbance = None;
            let mut while_starting = false;
            match act {
                Act::Kill(service) => {
                    while_starting = living[&service].starting_since_ns.is_some();
                    self.roster.of(service).process().kill();
                }
                Act::KillHelper(Helper::Recorder) => {
                    if let Some(recording) = &mut self.recording {
                        recording.kill();
                    }
                }
                Act::KillHelper(Helper::Janitor) => self.roster.janitor.0.kill(),
                // It is this process.
                Act::KillHelper(Helper::Launcher) => {
                    let _ = rustix::process::kill_process(rustix::process::getpid(), Signal::KILL);
                }
                Act::Stop(service) => self.roster.of(service).process().signal(Signal::STOP),
                Act::Continue(service) => {
                    self.roster.of(service).process().signal(Signal::CONT);
                    continue;
                }
                Act::Hog(core) => {
                    disturbance = self.disturb(Disturbance::hog(self.roster.root, core))
                }
                Act::Memory(mib) => {
                    disturbance = self.disturb(Disturbance::memory(self.roster.root, mib))
                }
            }
            let done_ns = self.roster.now_ns();
            self.faults.done(index, done_ns, disturbance, while_starting);
        }
    }

    fn disturb(&self, started: Result<Disturbance, Error>) -> Option<Disturbance> {
        started.inspect_err(|error| tracing::warn!("{error}")).ok()
    }

    /// Takes a fault from outside.
    pub(super) fn inject(&mut self, fault: Fault, log: &DriveLog, now_ns: i64) -> Answer {
        let lockstep = self.launch.mode == Mode::Lockstep;
        let refused = |message: String| Answer { ok: false, message };
        let is_of_processes = matches!(fault.effect, Effect::Process(_));
        if is_of_processes && lockstep {
            return refused("the run is in lockstep: faults of processes need realtime".into());
        }
        if let Some(absent) = absent(&fault, &self.launch.scenario) {
            return refused(absent.to_string());
        }
        let begin_ns = if lockstep {
            self.roster.group.timetable.step_ns
                * i64::try_from(log.reached()).expect("runs are finite")
        } else {
            now_ns
        };
        let begin_ns = begin_ns.saturating_add(fault.begin.known_ns().unwrap_or(0));
        let number = self.faults.plan(fault.clone(), Some(begin_ns));
        let message = format!("{} at {:.3} s", fault.effect.kind(), begin_ns as f64 / 1e9);
        if !is_of_processes {
            let takes_part = |service: &Service| self.launch.scenario.services().contains(service);
            let concerned: Vec<_> = concerned(&fault).into_iter().filter(takes_part).collect();
            let injected = Injected { number, begin_ns, fault };
            for service in concerned {
                self.roster.of(service).order(&ToService::Inject(injected.clone()));
            }
            self.roster.injected.push(injected);
        }
        Answer { ok: true, message }
    }
}
