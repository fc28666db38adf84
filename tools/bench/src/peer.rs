//! The measured processes: this program again, with one job.

use super::load;
use super::outcome::Outcome;
use super::paired::{Blocks, UNCOUNTED};
use super::setup::{Load, Mechanism};
use super::wake::{Sink, Source};
use super::words;
use group::{Error, Failure, Status};
use runtime::scheduling::{Granted, Policy, Request, apply};
use runtime::statistics::Latencies;
use runtime::{SharedWords, monotonic_ns, sleep_until};
use rustix::io::Errno;
use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

pub mod metronome {
    /// Ticks without counting.
    pub const WARM: u32 = 0;
    pub const COUNT: u32 = 1;
    /// Reports and ends.
    pub const STOP: u32 = 2;
}

/// First wake-ups, not counted: pages and caches are still cold.
const WARM_UP: u64 = 10;

#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Task {
    /// Sleeps until absolute instants and records its lateness.
    Metronome,
    /// Wakes the sink this many times.
    Source(Mechanism, u64),
    /// Waits for wake-ups.
    Sink(Mechanism),
    /// Wakes the sink in two ways in turn.
    PairedSource(Blocks),
    /// Waits for wake-ups of two kinds, and writes the samples of every block to [`BLOCKS_FILE`].
    PairedSink(Blocks),
    /// Keeps the core busy.
    Load(Load),
}

/// A job: a task with its core and priority.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    pub task: Task,
    /// Parent process; the job ends with it.
    pub parent: u32,
    /// Name of the shared page of words.
    pub page: String,
    /// Priority under `SCHED_FIFO`; `None` for time-sharing.
    pub priority: Option<u8>,
    pub core: usize,
    pub period_ns: i64,
}

/// File below the stage's root with the samples of all blocks.
pub const BLOCKS_FILE: &str = "bench-blocks.json";

/// Reason why a process of the benchmark cannot start.
#[derive(Debug, thiserror::Error)]
pub enum PeerError {
    /// Its argument is not a job.
    #[error("a process of `timegap bench`: {0}")]
    Job(#[source] serde_json::Error),
    /// It would outlive the benchmark.
    #[error("cannot follow the parent process: {0}")]
    Parent(#[source] Errno),
    /// The page of words cannot be opened.
    #[error("cannot share memory: {0}")]
    Page(#[source] io::Error),
}

impl Failure for PeerError {
    fn status(&self) -> Status {
        match self {
            Self::Job(_) => Status::Usage,
            Self::Parent(_) | Self::Page(_) => Status::Machine,
        }
    }
}

/// Does a job on the stage at `root` and prints its outcome.
pub fn run(root: &Path, job: &str) -> Result<ExitCode, Error> {
    let job: Job = serde_json::from_str(job).map_err(PeerError::Job)?;
    // This process ends with the benchmark.
    set_parent_process_death_signal(Some(Signal::KILL)).map_err(PeerError::Parent)?;
    if getppid() != Pid::from_raw(job.parent.cast_signed()) {
        return Err(Error::Interrupted);
    }
    let outcome = match job.task {
        Task::Load(kind) => {
            schedule(&job);
            load::run(kind)
        }
        Task::Metronome => metronome_job(&job),
        Task::Source(mechanism, count) => source(&job, root, mechanism, count),
        Task::Sink(mechanism) => sink(&job, root, mechanism),
        Task::PairedSource(blocks) => paired_source(&job, root, blocks),
        Task::PairedSink(blocks) => paired_sink(&job, root, blocks),
    }?;
    println!("{}", serde_json::to_string(&outcome).expect("plain data"));
    Ok(ExitCode::SUCCESS)
}

fn schedule(job: &Job) -> Granted {
    apply(&Request {
        policy: job.priority.map_or(Policy::Other, Policy::Fifo),
        core: Some(job.core),
        lock_memory: !matches!(job.task, Task::Load(_)),
    })
}

pub fn page(name: &str) -> Result<SharedWords, PeerError> {
    SharedWords::map(name).map_err(PeerError::Page)
}

/// Counts like the control loop: a release in the past is skipped, and lateness counts from each scheduled
/// instant.
fn metronome_job(job: &Job) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let granted = schedule(job);
    let state = page.word(words::METRONOME);
    let mut latencies = Latencies::default();
    page.word(words::READY).store(1, Ordering::Release);
    let mut scheduled = monotonic_ns() + job.period_ns;
    loop {
        while monotonic_ns() < scheduled {
            sleep_until(scheduled);
        }
        let state = state.load(Ordering::Relaxed);
        if state == metronome::STOP {
            let cycles = latencies.count();
            return Ok(Outcome { latencies, ..Outcome::of_cycles(granted, cycles) });
        }
        let now = monotonic_ns();
        while now - scheduled >= 0 {
            if state == metronome::COUNT {
                latencies.record_ns(now - scheduled);
            }
            scheduled += job.period_ns;
        }
    }
}

fn source(job: &Job, root: &Path, mechanism: Mechanism, count: u64) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let mut source = Source::open(&[mechanism], root, &page)?;
    while page.word(words::READY).load(Ordering::Acquire) == 0 {
        std::thread::sleep(std::time::Duration::from_micros(200));
    }
    let granted = schedule(job);
    let mut next = monotonic_ns() + job.period_ns;
    for _ in 0..count {
        while monotonic_ns() < next {
            sleep_until(next);
        }
        source.wake(mechanism)?;
        next = following(next, job.period_ns);
    }
    let done = u32::try_from(count + 1).unwrap_or(u32::MAX);
    page.word(words::DONE).store(done, Ordering::Release);
    source.wake_for_the_end(mechanism)?;
    Ok(Outcome::of_cycles(granted, count))
}

/// The instant of the next wake-up. A late source skips missed ones, since only the way to the sink is
/// measured.
fn following(last: i64, period_ns: i64) -> i64 {
    let over = (monotonic_ns() - last).max(0) / period_ns;
    last + (over + 1) * period_ns
}

fn paired_source(job: &Job, root: &Path, blocks: Blocks) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    // First, so that the threads of a compared library inherit it.
    let granted = schedule(job);
    let mut source = Source::open(&blocks.arms, root, &page)?;
    let mut cycles = 0;
    for (number, arm) in (1_u32..).zip(blocks.order()) {
        let by = blocks.arms[arm];
        while page.word(words::BLOCK_READY).load(Ordering::Acquire) < number {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        let mut next = monotonic_ns() + job.period_ns;
        for _ in 0..UNCOUNTED + blocks.wakes {
            while monotonic_ns() < next {
                sleep_until(next);
            }
            source.wake(by)?;
            cycles += 1;
            next = following(next, job.period_ns);
        }
        page.word(words::BLOCK_DONE).store(number, Ordering::Release);
        source.wake_for_the_end(by)?;
    }
    Ok(Outcome::of_cycles(granted, cycles))
}

fn paired_sink(job: &Job, root: &Path, blocks: Blocks) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let granted = schedule(job);
    let mut sink = Sink::open(&blocks.arms, root, &page)?;
    let due = UNCOUNTED + blocks.wakes;
    let (mut all, mut cycles, mut misses) = (Vec::new(), 0, 0);
    for (number, arm) in (1_u32..).zip(blocks.order()) {
        let mut samples: Vec<u32> = Vec::with_capacity(blocks.wakes as usize);
        let mut came = 0;
        // Leftovers of an earlier block in a buffer are older than this.
        let begun = monotonic_ns();
        page.word(words::BLOCK_READY).store(number, Ordering::Release);
        loop {
            let before = came;
            let was_done = page.word(words::BLOCK_DONE).load(Ordering::Acquire) >= number;
            sink.wait(blocks.arms[arm], |sent_ns| {
                if sent_ns >= begun {
                    came += 1;
                    if came > UNCOUNTED {
                        let ns = (monotonic_ns() - sent_ns).max(0);
                        samples.push(u32::try_from(ns).unwrap_or(u32::MAX));
                    }
                }
            })?;
            // Messages that overflowed during a stall of the sink are lost.
            if came >= due || (was_done && came == before) {
                break;
            }
        }
        cycles += u64::from(came);
        misses += u64::from(due.saturating_sub(came));
        all.push(samples);
    }
    let path = root.join(BLOCKS_FILE);
    let text = serde_json::to_string(&all).expect("plain data");
    std::fs::write(&path, text).map_err(|reason| Error::Path { action: "write", path, reason })?;
    Ok(Outcome { misses, ..Outcome::of_cycles(granted, cycles) })
}

fn sink(job: &Job, root: &Path, mechanism: Mechanism) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let mut sink = Sink::open(&[mechanism], root, &page)?;
    let granted = schedule(job);
    page.word(words::READY).store(1, Ordering::Release);
    let mut latencies = Latencies::default();
    let mut cycles = 0;
    loop {
        let before = cycles;
        let was_done = page.word(words::DONE).load(Ordering::Acquire) != 0;
        sink.wait(mechanism, |sent_ns| {
            cycles += 1;
            if cycles > WARM_UP {
                latencies.record_ns(monotonic_ns() - sent_ns);
            }
        })?;
        let done = page.word(words::DONE).load(Ordering::Acquire);
        // Messages that overflowed during a stall of the sink are lost.
        let last = cycles + 1 >= u64::from(done) || (was_done && cycles == before);
        if done != 0 && last {
            let misses = u64::from(done - 1).saturating_sub(cycles);
            let copied_bytes = sink.copied_bytes();
            return Ok(Outcome { granted, latencies, cycles, misses, copied_bytes });
        }
    }
}
