//! One SUMO for several egos, each of which is a run of its own.
//!
//! ```text
//! timegap --egos 3 ─┬─ sumo --num-clients 3 ◄──────────┐ a step when all have asked for it,
//!                   ├─ timegap run (a group, or one process), ego 1 ─┤ in the order of the egos
//!                   ├─ timegap run, ego 2 ─────────────┤
//!                   └─ timegap run, ego 3 ─────────────┘
//! ```
//!
//! SUMO itself keeps the egos in step, so that the runs know nothing of each other. An ego enters when the one before it
//! has left room, and its run begins then.

use std::io;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::ProgramError;
use crate::process::{Process, arguments};

/// Environment variable by which a run knows its [`Seat`]: port and number. It is no key of a scenario, since a kept
/// scenario outlives the port.
const SEAT: &str = "TIMEGAP_SUMO";

/// Longest wait of an ego until the one before it has left room, s: it starts from rest.
pub const ROOM_S: f64 = 10.0;
/// Time between two looks at SUMO while the egos drive.
const LOOK: Duration = Duration::from_millis(20);

/// A place at a SUMO that several egos share.
#[derive(Clone, Copy, Debug)]
pub struct Seat {
    /// Port on which SUMO listens.
    pub port: u16,
    /// The ego's number, from 1 on.
    pub number: u32,
}

impl Seat {
    /// The seat that this process was given.
    pub fn given() -> Option<Self> {
        let text = std::env::var(SEAT).ok()?;
        let (port, number) = text.split_once(' ')?;
        Some(Self { port: port.parse().ok()?, number: number.parse().ok()? })
    }
}

/// The command of this process without some options, each `--NAME VALUE` or `--NAME=VALUE`.
///
/// # Errors
/// If the system does not know this program's file.
pub fn this_command(without: &[&str]) -> io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    let mut words = std::env::args_os().skip(1);
    while let Some(word) = words.next() {
        let text = word.to_string_lossy();
        match without.contains(&text.split('=').next().unwrap_or_default()) {
            true if !text.contains('=') => drop(words.next()),
            true => {}
            false => drop(command.arg(&word)),
        }
    }
    Ok(command)
}

/// SUMO for several egos, each of which connects by itself.
#[derive(Debug)]
pub struct Shared {
    process: Process,
    port: u16,
}

impl Shared {
    /// Starts SUMO, which waits for `egos` clients before its first step.
    ///
    /// # Errors
    /// [`ProgramError`] if the program is missing or cannot start.
    pub fn start(
        (config, seed): (&Path, u64),
        egos: u32,
        prepare: impl FnOnce(&mut Command),
    ) -> Result<Self, ProgramError> {
        eprintln!("note: SUMO listens on all interfaces while several egos share it");
        let prepared = |command: &mut Command| {
            prepare(command);
            Ok(())
        };
        let (process, port) = Process::start(&arguments(config, seed, egos), prepared)?;
        Ok(Self { process, port })
    }

    /// Runs a program for each ego, and waits for all. Their standard outputs come back in the order of the egos.
    ///
    /// # Errors
    /// [`ProgramError`] if a run cannot start, or SUMO fails before they are over.
    pub fn drive(
        mut self,
        runs: impl IntoIterator<Item = io::Result<Command>>,
    ) -> Result<Vec<Output>, ProgramError> {
        let refuse = ProgramError::start("the run of an ego");
        let (mut pids, mut waits) = (Vec::new(), Vec::new());
        for (run, number) in runs.into_iter().zip(1..) {
            let mut run = run.map_err(&refuse)?;
            run.env(SEAT, format!("{} {number}", self.port)).stdin(Stdio::null());
            let run = run.stdout(Stdio::piped()).spawn().map_err(&refuse)?;
            pids.push(Pid::from_child(&run));
            waits.push(std::thread::spawn(move || run.wait_with_output()));
        }
        let mut failure = None;
        while !waits.iter().all(JoinHandle::is_finished) {
            // It ends with status 0 when its last client has left.
            let is_gone = failure.is_none() && self.process.is_gone();
            if is_gone && !self.process.end().is_ok_and(|status| status.success()) {
                failure = Some(self.process.ended("beside the egos"));
                // Those that wait for it would wait on.
                for pid in &pids {
                    let _ = kill_process(*pid, Signal::TERM);
                }
            }
            std::thread::sleep(LOOK);
        }
        let outputs = waits.into_iter().map(|wait| wait.join().expect("it does not panic"));
        let outputs = outputs.collect::<io::Result<_>>().map_err(refuse)?;
        failure.map_or(Ok(outputs), Err)
    }
}
