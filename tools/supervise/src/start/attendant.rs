//! A process of the group beside the services: the recorder, the bridge, the replayer, a node of a user's graph.

use crate::root::{RunRoot, open_lock, wipe};
use crate::start::processes::{DONE, end_within, this_program};
use crate::{Error, MachineError};
use runtime::{enroll_listener, inherit_only};
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, ChildStdin, ExitCode, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Name of the one that serves viewers: in lockstep no sender waits for it.
pub const BRIDGE: &str = "bridge";

/// Such a process, and the JSON lines on its standard streams.
#[derive(Debug)]
pub struct Attendant {
    child: Child,
    input: Option<ChildStdin>,
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
        Self::spawn_as(name, name, arguments, root, group)
    }

    /// The same under another name in `ps`, behind `timegap-`.
    pub fn spawn_as(
        shown: &str,
        name: &str,
        arguments: &[&OsStr],
        root: &RunRoot,
        group: i32,
    ) -> Result<Self, Error> {
        let mut command = this_program(&["service", name])?;
        command
            .arg0(format!("timegap-{shown}"))
            .arg(root.path())
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .process_group(group);
        inherit_only(&mut command, Some(root.lock()));
        let error = MachineError::cannot(format!("start the {shown}"));
        let mut child = command.spawn().map_err(&error)?;
        if name != BRIDGE {
            enroll_listener(root.prefix(), child.id())?;
        }
        let input = child.stdin.take();
        let out = child.stdout.take().expect("piped");
        let (sender, lines) = channel();
        std::thread::Builder::new()
            .name(format!("{shown}-out"))
            .spawn(move || {
                for line in BufReader::new(out).lines().map_while(Result::ok) {
                    if sender.send(line).is_err() {
                        return;
                    }
                }
            })
            .map_err(error)?;
        Ok(Self { child, input, lines })
    }

    /// Sends it a message. The process may be gone.
    pub fn send(&mut self, message: &impl Serialize) {
        let line = serde_json::to_string(message).expect("link messages are plain data");
        if let Some(input) = &mut self.input
            && writeln!(input, "{line}").is_err()
        {
            self.input = None;
        }
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

    pub fn pid(&self) -> i32 {
        i32::try_from(self.child.id()).expect("process ids are positive and fit")
    }

    pub fn kill(&mut self) {
        // It may be gone by now.
        let _ = self.child.kill();
    }

    /// Stops it, or lets it go on.
    pub fn stop(&mut self, is_stopped: bool) {
        let signal = if is_stopped { Signal::STOP } else { Signal::CONT };
        if !self.is_gone()
            && let Some(pid) = Pid::from_raw(self.pid())
        {
            // Not waited for yet: the id cannot be another's.
            let _ = kill_process(pid, signal);
        }
    }

    /// True once the process is gone.
    pub fn is_gone(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_some())
    }

    /// Waits until the process is gone; kills it after `grace`.
    pub fn end(&mut self, grace: Duration) -> Option<ExitStatus> {
        // The end of its input ends it.
        self.input = None;
        end_within(&mut self.child, grace)
    }
}

impl Drop for Attendant {
    fn drop(&mut self) {
        self.end(Duration::ZERO);
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
        if line == DONE {
            return ExitCode::SUCCESS;
        }
        group = line.parse().ok().and_then(Pid::from_raw);
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
