//! A process of the group beside the services: the recorder, the bridge, the replayer.

use crate::root::{RunRoot, open_lock, wipe};
use crate::start::processes::{DONE, Process, this_program};
use crate::{Error, MachineError};
use runtime::{enroll_listener, inherit_only};
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, Signal, kill_process_group};
use serde::de::DeserializeOwned;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Name of the one that serves viewers: in lockstep no sender waits for it.
pub const BRIDGE: &str = "bridge";

/// Such a process, and the JSON lines that it writes. It ends with its handle.
#[derive(Debug)]
pub struct Attendant {
    pub process: Process,
    lines: Receiver<String>,
}

impl Attendant {
    /// Starts this program again as `timegap service NAME ROOT ARGUMENTS...`. Its process group is `group`, or a new
    /// one for 0.
    pub fn spawn(
        name: &str,
        arguments: &[&OsStr],
        root: &RunRoot,
        group: i32,
    ) -> Result<Self, Error> {
        let mut command = this_program(&["service", name])?;
        command
            .arg0(format!("timegap-{name}"))
            .arg(root.path())
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .process_group(group);
        inherit_only(&mut command, Some(root.lock()));
        let started = Self::start(command, name, group)?;
        if name != BRIDGE {
            enroll_listener(root.prefix(), started.process.pid().unsigned_abs())?;
        }
        Ok(started)
    }

    /// Starts `command`, whose standard output is piped, in process group `group`. Errors have the name.
    pub fn start(mut command: Command, name: &str, group: i32) -> Result<Self, MachineError> {
        let error = MachineError::cannot(format!("start the {name}"));
        let mut child = command.spawn().map_err(&error)?;
        let out = child.stdout.take().expect("piped");
        let (sender, lines) = channel();
        let hand_on = move || {
            // The receiver may be gone.
            let lines = BufReader::new(out).lines().map_while(Result::ok);
            lines.for_each(|line| drop(sender.send(line)));
        };
        let named = std::thread::Builder::new().name(format!("{name}-out"));
        named.spawn(hand_on).map_err(error)?;
        Ok(Self { process: Process::of(child, group), lines })
    }

    /// Its next message, if it comes in time.
    pub fn receive<T: DeserializeOwned>(&mut self, within: Duration) -> Option<T> {
        let deadline = Instant::now() + within;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let line = self.lines.recv_timeout(left).ok()?;
            // Other lines come from a panic or a library and are of no use here.
            if let Ok(message) = serde_json::from_str(&line) {
                return Some(message);
            }
        }
    }
}

impl Drop for Attendant {
    fn drop(&mut self) {
        self.process.end(Duration::ZERO);
    }
}

/// Time that services get to end by themselves once the launcher is gone.
const GRACE: Duration = Duration::from_secs(2);

/// Runs the janitor of the run at `root`. It reads lines from the launcher until [`DONE`] or the launcher's death. The
/// first line is the number of the services' process group.
pub fn run(root: &Path) -> ExitCode {
    // Opened while the run certainly exists.
    let Ok(lock) = open_lock(root) else { return ExitCode::FAILURE };
    let mut group = None;
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let order = line.parse().ok();
        if order == Some(DONE) {
            return ExitCode::SUCCESS;
        }
        group = order.and_then(Pid::from_raw);
    }
    let died = Instant::now();
    while flock(&lock, FlockOperation::NonBlockingLockExclusive).is_err() {
        if died.elapsed() > GRACE
            && let Some(group) = group.take()
        {
            // A stopped or hung service: it cannot end itself.
            let _ = kill_process_group(group, Signal::KILL);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    wipe(root);
    ExitCode::SUCCESS
}
