//! Ends of a process of the group, with their consequences. This table is the whole of it:
//!
//! | what happens | seen by | `services[].exit` | in realtime | in lockstep |
//! | --- | --- | --- | --- | --- |
//! | it ends before all are ready, or does not get ready in time | the end of its output, `--ready-timeout` | | no run, no results: status 3, of a program of the user's 2 | the same |
//! | it reports at the run's end and leaves | its report | `ok` | the run goes on to its end | the same |
//! | it reports or leaves with status 0 before that | its report, the end of its output | `left before the run's end` | aborted; with `restart = "always"` replaced | aborted |
//! | SIGTERM, SIGINT, SIGKILL, a crash by a signal | the end of its output | `killed by SIG…` | replaced | aborted |
//! | it panics or leaves with another status | the end of its output | `exit status N` | replaced | aborted |
//! | it hangs, spins or is stopped | no sign of life for `heartbeat_timeout_ms` and a period | `hung` | killed, replaced | aborted after 10 s |
//! | its standby took over while it was stopped or hung | no cycle for `standby_timeout_ms` and a period | | killed, unless it has ended already; the next standby is started | |
//! | its standby ends, or hangs | the end of its output, no cycle | | the next standby is started | |
//! | it does not get the processor | the scheduler's own account of it | | waited for, said as "starved by the machine" | waited for |
//! | it floods its output | the bytes of text beside its messages | `flooded its output` | killed, replaced | aborted |
//! | it closes its output but lives on | the end of its output | `closed its output` | killed, replaced | aborted |
//! | it was replaced and does not get ready | 2 s | `not ready in time` | killed, replaced | |
//! | it does not report at the run's end | 3 s | `did not report` | aborted | the same |
//!
//! With a standby "replaced" means: by the standby, at once, and the next standby is started. "Replaced" is within
//! `[supervision]`'s budget. Beyond it the plant is ordered to stop in lane. The outcome is `safe_stop` once the
//! vehicle stands. It is `aborted` if the run ends before that, and never `completed`. The run ends at once as
//! `aborted` when
//! the plant itself is beyond its budget or its policy is `never`. The figures are those of the last cycle that the
//! plant kept.

use std::fmt;
use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;

/// End of one process of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// With status 0 after its report, or after an order to end.
    Ok,
    /// By itself with status 0, before the run's end.
    Early,
    Status(i32),
    /// By this signal, which the launcher did not send.
    Signal(i32),
    /// Killed for lack of a sign of life.
    Hung,
    /// Killed for what it wrote.
    Flooded,
    /// Killed because it lived on without its output.
    OutputClosed,
    /// Killed because it was not ready in time.
    NotReady,
    /// Replaced by its standby: it left by itself or was killed.
    Replaced,
    /// Killed because it did not report at the end.
    Unreported,
}

impl Exit {
    /// Meaning of an exit status by itself, for a process that was to end.
    pub fn of(status: ExitStatus) -> Self {
        match (status.code(), status.signal()) {
            (Some(0), _) => Self::Ok,
            (Some(code), _) => Self::Status(code),
            (None, signal) => Self::Signal(signal.unwrap_or(0)),
        }
    }

    /// True if it is a failure, for which `restart = "on-failure"` starts the next process.
    pub fn is_failure(self) -> bool {
        !matches!(self, Self::Ok | Self::Early)
    }
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ok => f.write_str("ok"),
            Self::Early => f.write_str("left before the run's end"),
            Self::Status(code) => write!(f, "exit status {code}"),
            Self::Signal(signal) => match signal_hook::low_level::signal_name(*signal) {
                Some(name) => write!(f, "killed by {name}"),
                None => write!(f, "killed by signal {signal}"),
            },
            Self::Hung => f.write_str("hung"),
            Self::Flooded => f.write_str("flooded its output"),
            Self::OutputClosed => f.write_str("closed its output"),
            Self::NotReady => f.write_str("not ready in time"),
            Self::Replaced => f.write_str("replaced by the standby"),
            Self::Unreported => f.write_str("did not report"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuses_are_distinguished() {
        assert_eq!(Exit::of(ExitStatus::from_raw(0)), Exit::Ok);
        assert_eq!(Exit::of(ExitStatus::from_raw(3 << 8)).to_string(), "exit status 3");
        assert_eq!(Exit::of(ExitStatus::from_raw(9)).to_string(), "killed by SIGKILL");
        assert!(Exit::of(ExitStatus::from_raw(15)).is_failure());
        assert!(!Exit::Early.is_failure() && !Exit::Ok.is_failure());
    }
}
