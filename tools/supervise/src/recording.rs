//! The processes beside a run that take its messages away: the recorder, and the bridge to a viewer. Whatever happens
//! to them, the run goes on, and it says so.

use crate::MachineError;
use crate::root::RunRoot;
use crate::start::attendant::{Attendant, BRIDGE};
use drive::{Exit, RecordingSummary};
use recorder::{FigureName, FromRecorder, LawNames, Recording, Start, ToRecorder};
use scenario::Scenario;
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

/// Time that such a process gets to be ready, and to write what it still holds at the end.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time that a bridge gets to take leave of its viewers.
const LEAVE: Duration = Duration::from_secs(2);

/// Meaning of the numbers of the scenario's law.
pub fn law_names(scenario: &Scenario) -> LawNames {
    let Some(formulation) = controller::laws::formulation(scenario) else {
        return LawNames::default();
    };
    let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let figure = |figure: &controller::law::Figure| FigureName {
        name: figure.name.to_owned(),
        unit: figure.unit.to_owned(),
    };
    LawNames {
        modes: names(formulation.modes),
        reasons: names(formulation.reasons),
        figures: formulation.figures.iter().map(figure).collect(),
    }
}

#[derive(Debug)]
pub struct Listener {
    name: &'static str,
    /// The recorder's file, or the bridge's address.
    target: OsString,
    attendant: Option<Attendant>,
    failed: Option<String>,
    /// A fault of the scenario ended it: its end is expected.
    was_killed: bool,
}

impl Listener {
    /// Starts it in the services' process group.
    pub fn spawn(name: &'static str, target: OsString, root: &RunRoot, group: i32) -> Self {
        let (attendant, failed) = match Attendant::spawn(name, &[&target], root, group) {
            Ok(attendant) => (Some(attendant), None),
            Err(error) => (None, Some(error.to_string())),
        };
        Self { name, target, attendant, failed, was_killed: false }
    }

    /// Makes it connect to all services, which must be ready, and waits until it did. A run begins without its
    /// recorder, but not without its bridge.
    pub fn connect(&mut self) -> Result<(), MachineError> {
        let Some(attendant) = &mut self.attendant else { return Ok(()) };
        attendant.process.order(&ToRecorder::Connect);
        let reason = match attendant.receive(PATIENCE) {
            Some(FromRecorder::Ready) => return Ok(()),
            Some(FromRecorder::Failed(reason)) => reason,
            Some(FromRecorder::Report(_)) | None => "it did not get ready".into(),
        };
        if self.name == BRIDGE {
            return Err(MachineError(format!("the bridge: {reason}")));
        }
        self.give_up(reason);
        Ok(())
    }

    /// Sends it the common start.
    pub fn begin(&mut self, start: &Start) {
        if let Some(attendant) = &mut self.attendant {
            attendant.process.order(&ToRecorder::Start(start.clone()));
        }
    }

    /// Ends it, when it has handed on what has been sent.
    pub fn dismiss(mut self) {
        if let Some(attendant) = &mut self.attendant {
            attendant.process.end(LEAVE);
        }
    }

    /// Kills it, as a fault does.
    pub fn kill(&mut self) {
        if let Some(attendant) = &mut self.attendant {
            attendant.process.kill();
            self.was_killed = true;
        }
    }

    /// True, once, when it died: its buffers must be removed, or senders wait for it.
    pub fn has_died(&mut self) -> bool {
        let Some(attendant) = &mut self.attendant else { return false };
        if attendant.process.poll().is_none() {
            return false;
        }
        let reason = match attendant.receive(Duration::ZERO) {
            Some(FromRecorder::Failed(reason)) => reason,
            _ => Exit::of(attendant.process.end(Duration::ZERO).0).to_string(),
        };
        self.give_up(reason);
        true
    }

    /// Lets the recorder write what has been sent, and ends it.
    pub fn finish(mut self) -> RecordingSummary {
        let reported = self.attendant.as_mut().and_then(|attendant| {
            attendant.process.order(&ToRecorder::Finish);
            attendant.receive(PATIENCE)
        });
        let (tally, failed) = match reported {
            Some(FromRecorder::Report(report)) => (Some(report.tally), report.failed),
            Some(FromRecorder::Failed(reason)) => (None, Some(reason)),
            Some(FromRecorder::Ready) | None => {
                (None, self.failed.take().or_else(|| Some("the recorder does not answer".into())))
            }
        };
        if let Some(mut attendant) = self.attendant.take() {
            // One that did not answer is not waited for again.
            attendant.process.end(if tally.is_some() { PATIENCE } else { Duration::ZERO });
        }
        let messages = tally.as_ref().map(recorder::Tally::messages);
        let path = PathBuf::from(self.target);
        let in_file = || Recording::open(&path).map_or(0, |file| file.records().count() as u64);
        RecordingSummary {
            messages: messages.unwrap_or_else(in_file),
            lost: tally.as_ref().map(recorder::Tally::lost),
            bytes: std::fs::metadata(&path).map_or(0, |file| file.len()),
            failed,
            path,
        }
    }

    fn give_up(&mut self, reason: String) {
        if !self.was_killed {
            tracing::warn!("the {} is gone, the run continues without it: {reason}", self.name);
        }
        self.attendant = None;
        self.failed = Some(reason);
    }
}
