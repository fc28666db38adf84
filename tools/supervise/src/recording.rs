//! The recorder's process beside a run: whatever happens to it, the run goes on and the summary
//! says so.

use crate::root::RunRoot;
use crate::start::attendant::Attendant;
use drive::{Exit, RecordingSummary};
use messages::Service;
use recorder::{FigureName, FromRecorder, LawNames, Recording, Start, ToRecorder};
use runtime::Program;
use runtime::scheduling::Granted;
use scenario::Scenario;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Time that the recorder gets to be ready, and to write what it still holds at the end.
const PATIENCE: Duration = Duration::from_secs(10);

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
pub struct RecorderProcess {
    path: PathBuf,
    process: Option<Attendant>,
    failed: Option<String>,
    /// A fault of the scenario ended it: its end is expected.
    was_killed: bool,
}

impl RecorderProcess {
    /// Starts recording to `path` in the services' process group.
    pub fn spawn(path: &Path, root: &RunRoot, group: i32) -> Self {
        let spawned = Attendant::spawn("recorder", &[path.as_os_str()], root, group);
        let (process, failed) = match spawned {
            Ok(process) => (Some(process), None),
            Err(error) => (None, Some(error.to_string())),
        };
        Self { path: path.to_owned(), process, failed, was_killed: false }
    }

    /// Makes it connect to all services, which must be ready, and waits until it did.
    pub fn connect(&mut self) {
        let Some(process) = &mut self.process else { return };
        process.send(&ToRecorder::Connect);
        match process.receive(PATIENCE) {
            Some(FromRecorder::Ready) => {}
            Some(FromRecorder::Failed(reason)) => self.give_up(reason),
            Some(FromRecorder::Report(_)) | None => self.give_up("it did not get ready".into()),
        }
    }

    /// Sends it the common start, the granted scheduling, the user's programs, and the meaning of the law's numbers.
    pub fn begin(
        &mut self,
        start_ns: i64,
        scheduling: BTreeMap<String, Granted>,
        programs: &BTreeMap<Service, Program>,
        law: LawNames,
    ) {
        if let Some(process) = &mut self.process {
            let programs = programs.iter();
            let programs =
                programs.map(|(service, program)| (service.name().into(), program.clone()));
            let programs = programs.collect();
            process.send(&ToRecorder::Start(Start { start_ns, scheduling, programs, law }));
        }
    }

    /// Kills it, as a fault does.
    pub fn kill(&mut self) {
        if let Some(process) = &mut self.process {
            process.kill();
            self.was_killed = true;
        }
    }

    /// True, once, when the recorder died: its buffers must be removed, or senders wait for it.
    pub fn has_died(&mut self) -> bool {
        let Some(process) = &mut self.process else { return false };
        if !process.is_gone() {
            return false;
        }
        let reason = match process.receive(Duration::ZERO) {
            Some(FromRecorder::Failed(reason)) => reason,
            _ => process
                .end(Duration::ZERO)
                .map_or_else(String::new, |status| Exit::of(status).to_string()),
        };
        self.give_up(reason);
        true
    }

    /// Lets it write what has been sent, and ends it.
    pub fn finish(mut self) -> RecordingSummary {
        let reported = self.process.as_mut().and_then(|process| {
            process.send(&ToRecorder::Finish);
            process.receive(PATIENCE)
        });
        let (tally, failed) = match reported {
            Some(FromRecorder::Report(report)) => (Some(report.tally), report.failed),
            Some(FromRecorder::Failed(reason)) => (None, Some(reason)),
            Some(FromRecorder::Ready) | None => {
                (None, self.failed.take().or_else(|| Some("the recorder does not answer".into())))
            }
        };
        if let Some(mut process) = self.process.take() {
            // One that did not answer is not waited for again.
            process.end(if tally.is_some() { PATIENCE } else { Duration::ZERO });
        }
        let messages = tally.as_ref().map(recorder::Tally::messages);
        let in_file =
            || Recording::open(&self.path).map_or(0, |file| file.records().count() as u64);
        RecordingSummary {
            messages: messages.unwrap_or_else(in_file),
            lost: tally.as_ref().map(recorder::Tally::lost),
            bytes: std::fs::metadata(&self.path).map_or(0, |file| file.len()),
            failed,
            path: self.path,
        }
    }

    fn give_up(&mut self, reason: String) {
        if !self.was_killed {
            tracing::warn!("the recorder is gone, the run continues without it: {reason}");
        }
        self.process = None;
        self.failed = Some(reason);
    }
}
