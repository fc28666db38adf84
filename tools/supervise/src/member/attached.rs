//! One process of a service, from its start until its exit status is taken.

use crate::member::silence::{Meaning, Share, Silence};
use crate::start::processes::Process;
use drive::{Exit, StandbyCost};
use runtime::Progress;
use std::time::Duration;

/// Time between the end of a process's output and its own.
pub const LAST_MOMENT: Duration = Duration::from_millis(100);

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
    pub silence: Silence,
    /// Signs of life of a process that sends nothing, as a standby.
    progress: Option<Progress>,
    /// Its processor time when it began to stand by, and that run time, ns.
    stands_by_since: Option<(u64, i64)>,
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

    /// It takes part in the run from now on. Without heartbeats its `progress` shows that it lives.
    pub fn begin(&mut self, now_ns: i64, progress: Option<Progress>) {
        self.silence = Silence::from(now_ns);
        self.progress = progress;
    }

    /// The same as a standby. Without its page it looks hung, and is replaced.
    pub fn stand_by(&mut self, now_ns: i64, progress: Option<Progress>) {
        self.begin(now_ns, progress);
        self.stands_by_since = processor_ns(self.process.pid()).map(|used_ns| (used_ns, now_ns));
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

    /// The end of a process that closed its output before the run's end. It is killed if it lives on after [`LAST_MOMENT`].
    pub fn exit_in_run(&mut self) -> Exit {
        let exit = match self.exit(LAST_MOMENT, Exit::OutputClosed) {
            Exit::Ok => Exit::Early,
            other => other,
        };
        self.cause = Some(exit);
        exit
    }

    /// True if it hangs: no sign of life for more than `limit_ns`, although the machine gave it the processor. If it
    /// did not, the time is added to `starved_ms`.
    pub fn is_hung(&mut self, now_ns: i64, limit_ns: i64, starved_ms: &mut f64) -> bool {
        if let Some(progress) = &self.progress {
            self.silence.broken(progress.cycles(), now_ns);
        }
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
        let (before_ns, since_ns) = self.stands_by_since?;
        let used_ns = processor_ns(self.process.pid())?.saturating_sub(before_ns);
        let elapsed_ns = now_ns - since_ns;
        (elapsed_ns > 0).then(|| StandbyCost {
            cpu_percent: 100.0 * used_ns as f64 / elapsed_ns as f64,
            private_kib: private_kib(self.process.pid()),
        })
    }
}

/// Processor time of a process so far, ns.
fn processor_ns(pid: i32) -> Option<u64> {
    let threads = std::fs::read_dir(format!("/proc/{pid}/task")).ok()?;
    let of_thread = |thread: std::fs::DirEntry| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    };
    Some(threads.flatten().filter_map(of_thread).sum())
}

/// Memory of its own, KiB; 0 if the kernel does not show it.
fn private_kib(pid: i32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).unwrap_or_default();
    let private = text.lines().filter(|line| line.starts_with("Private_"));
    private.filter_map(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok()).sum()
}
