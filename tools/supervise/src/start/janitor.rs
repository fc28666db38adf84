//! The process that cleans up after a launcher that was killed.

use crate::root::{open_lock, wipe};
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, Signal, kill_process_group};
use std::io::BufRead;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Time that services get to end by themselves once the launcher is gone.
const GRACE: Duration = Duration::from_secs(2);

/// Word of a launcher that has already cleaned up.
pub const DONE: &str = "done";

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
