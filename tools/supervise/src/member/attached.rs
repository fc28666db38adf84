//! One process of a service, from its start until its exit status is taken.

use crate::member::silence::{Meaning, Share, Silence};
use crate::start::processes::Process;
use drive::{Exit, StandbyCost};
use runtime::{Figures, Group, Progress};
use std::time::Duration;

/// A process and what is known of it.
#[derive(Debug)]
pub struct Attached {
    /// Index of the process in its service.
    pub incarnation: u32,
    pub process: Process,
    /// Reason for which the launcher killed it, or its end during the run.
    pub cause: Option<Exit>,
    /// It has reported, before the run's end.
    pub has_told: bool,
    /// Its end was noted, and what it left was taken.
    pub is_settled: bool,
    silence: Silence,
    /// Signs of life of a standby: it sends nothing.
    progress: Option<Progress>,
    /// Its use when it began to stand by, and that run time, ns.
    stands_by_since: Option<(Used, i64)>,
}

/// Use of a process so far.
#[derive(Clone, Copy, Debug)]
struct Used {
    processor_ns: u64,
}

impl Attached {
    /// A process that has just been started.
    pub fn new(incarnation: u32, process: Process) -> Self {
        Self {
            incarnation,
            process,
            cause: None,
            has_told: false,
            is_settled: false,
            silence: Silence::default(),
            progress: None,
            stands_by_since: None,
        }
    }

    /// It takes part in the run from now on.
    pub fn begin(&mut self, now_ns: i64) {
        self.silence = Silence::from(now_ns);
        self.progress = None;
    }

    pub fn stand_by(&mut self, group: &Group, service: messages::Service, now_ns: i64) {
        self.begin(now_ns);
        // Without its page it looks hung, and is replaced.
        self.progress = Figures::of(group, service).progress(self.incarnation);
        self.stands_by_since = Used::of(self.process.pid()).map(|used| (used, now_ns));
    }

    /// Kills it; it is said to have ended so.
    pub fn kill(&mut self, cause: Exit) {
        self.cause.get_or_insert(cause);
        self.process.kill();
    }

    /// Its end; if it lives on after `grace` it is killed and has ended as `overdue`.
    pub fn exit(&mut self, grace: Duration, overdue: Exit) -> Exit {
        let (status, killed) = self.process.end(grace);
        match (self.cause, Exit::of(status)) {
            (Some(cause), _) => cause,
            (None, _) if killed => overdue,
            (None, exit) => exit,
        }
    }

    /// The end of a process that closed its output before the run's end. It is killed if it lives on after `grace`.
    pub fn exit_in_run(&mut self, grace: Duration) -> Exit {
        let exit = match self.exit(grace, Exit::OutputClosed) {
            Exit::Ok => Exit::Early,
            other => other,
        };
        self.cause = Some(exit);
        exit
    }

    /// Run time of the last sign of life, ns.
    pub fn heard_ns(&self) -> i64 {
        self.silence.heard_ns()
    }

    /// Notes a sign of life at `now_ns` with `cycles` done; it counts only with progress.
    pub fn sign_of_life(&mut self, cycles: u64, now_ns: i64) {
        self.silence.broken(cycles, now_ns);
    }

    pub fn look_at_progress(&mut self, now_ns: i64) {
        if let Some(progress) = &self.progress {
            let cycles = progress.cycles();
            self.sign_of_life(cycles, now_ns);
        }
    }

    /// Counts the time without a sign of life from `now_ns` on.
    pub fn reset_silence(&mut self, now_ns: i64) {
        self.silence.reset(now_ns);
    }

    /// True if it hangs: no sign of life for more than `limit_ns`, although the machine gave it the processor. If it
    /// did not, the time is added to `starved_ms`.
    pub fn is_hung(&mut self, now_ns: i64, limit_ns: i64, starved_ms: &mut f64) -> bool {
        let pid = self.process.pid();
        match self.silence.meaning(now_ns, limit_ns, || Share::of(pid)) {
            Meaning::Lives => false,
            Meaning::Hung => true,
            Meaning::Starved(silent_ns) => {
                *starved_ms += silent_ns as f64 / 1e6;
                false
            }
        }
    }

    /// Its cost as a standby; `None` for another process, or if the kernel does not show it.
    pub fn standby_cost(&self, now_ns: i64) -> Option<StandbyCost> {
        let (before, since_ns) = self.stands_by_since?;
        let now = Used::of(self.process.pid())?;
        let elapsed_ns = now_ns - since_ns;
        (elapsed_ns > 0).then(|| StandbyCost {
            cpu_percent: 100.0 * now.processor_ns.saturating_sub(before.processor_ns) as f64
                / elapsed_ns as f64,
            private_kib: private_kib(self.process.pid()),
        })
    }
}

impl Used {
    fn of(pid: i32) -> Option<Self> {
        let threads = std::fs::read_dir(format!("/proc/{pid}/task")).ok()?;
        let of_thread = |thread: std::fs::DirEntry| {
            let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
            text.split_whitespace().next()?.parse::<u64>().ok()
        };
        Some(Self { processor_ns: threads.flatten().filter_map(of_thread).sum() })
    }
}

/// Memory of its own, KiB; 0 if the kernel does not show it.
fn private_kib(pid: i32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).unwrap_or_default();
    let private = text.lines().filter(|line| line.starts_with("Private_"));
    private.filter_map(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok()).sum()
}
