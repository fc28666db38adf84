//! The replayer's process: sends the samples that a recorded controller used, as they were.

use crate::ReadError;
use crate::Recording;
use crate::link::{orders, say};
use crate::takes::{INPUTS, Take, inputs};
use messages::{Origin, Topic};
use runtime::{Group, Guest, RuntimeError, Tapped, log_warnings};
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Releases whose samples are sent ahead of their cycles: fewer than a topic's buffer holds.
const AHEAD: usize = 16;
/// Time between two looks at the cycles.
const POLL: Duration = Duration::from_micros(50);

/// A line from the launcher to the replayer. The end of the input is an order to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ToReplayer {
    Start,
}

/// A line from the replayer to the launcher.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FromReplayer {
    /// All ports are open.
    Ready,
    /// It cannot go on.
    Failed(String),
}

/// Becomes the replayer of a run. `arguments` are the run's root, the recording, which restart of the
/// controller to serve and for how many cycles.
pub fn replay(arguments: &[OsString]) -> ExitCode {
    let [root, file, numbers @ ..] = arguments else { return refuse() };
    let numbers: Vec<u64> =
        numbers.iter().map_while(|number| number.to_str()?.parse().ok()).collect();
    let [incarnation, cycles] = numbers[..] else { return refuse() };
    let Ok(incarnation) = u32::try_from(incarnation) else { return refuse() };
    log_warnings();
    let take = Take { incarnation, cycles, ..Take::default() };
    match play(Path::new(root), Path::new(file), &take) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            say(&FromReplayer::Failed(reason.to_string()));
            ExitCode::FAILURE
        }
    }
}

/// Reason why a recording cannot be played.
#[derive(Debug, thiserror::Error)]
enum PlayError {
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    #[error(transparent)]
    Recording(#[from] ReadError),
}

fn refuse() -> ExitCode {
    eprintln!("the replayer is a service of timegap: start it with `timegap recording replay`");
    ExitCode::from(2)
}

fn play(root: &Path, file: &Path, take: &Take) -> Result<(), PlayError> {
    let group = Group::read(root)?;
    let recording = Recording::open(file)?;
    let guest = Guest::join(&group, "replayer")?;
    let ports = INPUTS.map(|topic| guest.player(topic));
    let ports = ports.into_iter().collect::<Result<Vec<_>, _>>()?;
    let answers = guest.tap(Topic::Diagnostics)?;
    let input = orders()?;
    say(&FromReplayer::Ready);
    if input.recv().is_err() {
        return Ok(());
    }
    let mut last = [Origin::NONE; INPUTS.len()];
    let mut answered = 0;
    for (sent, cycle) in recording.cycles(take).enumerate() {
        while sent >= answered + AHEAD {
            answered += taken(&answers)?;
            if sent >= answered + AHEAD {
                std::thread::sleep(POLL);
            }
        }
        let used = inputs(&cycle.diagnostics.header.origins).into_iter().zip(&mut last);
        for ((port, sample), (origin, last)) in ports.iter().zip(&cycle.samples).zip(used) {
            if let Some(sample) = sample
                && origin != *last
            {
                port.send(sample)?;
                *last = origin;
            }
        }
    }
    // The controller waits for room until its messages are taken.
    loop {
        taken(&answers)?;
        match input.recv_timeout(Duration::from_millis(1)) {
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => return Ok(()),
            Ok(ToReplayer::Start) | Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
        }
    }
}

/// Takes the diagnostics that arrived, one for each cycle, and counts them.
fn taken(answers: &Tapped) -> Result<usize, PlayError> {
    let mut count = 0;
    while answers.take(|_| {})? {
        count += 1;
    }
    Ok(count)
}
