//! The measured processes: this program again, with one job.

use super::paired::UNCOUNTED;
use super::setup::{Load, Mechanism, failed};
use super::wake::{DONE, METRONOME, READY, Sink, Source};
use runtime::scheduling::{Granted, Policy, Request, apply};
use runtime::statistics::Latencies;
use runtime::{SharedWords, monotonic_ns, sleep_until};
use rustix::process::{Pid, Signal, getppid, set_parent_process_death_signal};
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use supervise::{Error, MachineError, UsageError};

pub mod metronome {
    /// Ticks without counting.
    pub const WARM: u32 = 0;
    pub const COUNT: u32 = 1;
    /// Reports and ends.
    pub const STOP: u32 = 2;
}

/// Wake-ups in blocks, each in one of several ways.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Turns {
    pub ways: Vec<Mechanism>,
    /// Number of each block's way.
    pub order: Vec<usize>,
    /// Counted wake-ups in a block.
    pub wakes: u32,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Task {
    /// Sleeps until absolute instants and records its lateness.
    Metronome,
    /// Wakes the sink.
    Source(Turns),
    /// Waits for wake-ups, and writes the samples of every block to [`BLOCKS_FILE`].
    Sink(Turns),
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

/// Measurements of a job.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    pub granted: Granted,
    pub latencies: Latencies,
    /// Scheduled releases or wake-ups.
    pub cycles: u64,
    /// Wake-ups that did not arrive one by one.
    pub misses: u64,
    /// Bytes copied between the sender's writing and the reader's reading.
    pub copied_bytes: u64,
}

impl Outcome {
    /// The outcome of a process without measurements of its own.
    pub fn of_cycles(granted: Granted, cycles: u64) -> Self {
        Self { granted, latencies: Latencies::default(), cycles, misses: 0, copied_bytes: 0 }
    }
}

/// File below the stage's root with the samples of all blocks.
pub const BLOCKS_FILE: &str = "bench-blocks.json";

/// Does a job on the stage at `root` and prints its outcome.
pub fn run(root: &Path, job: &str) -> Result<ExitCode, Error> {
    let job: Job = serde_json::from_str(job)
        .map_err(|why| UsageError::at("timegap service bench", why, "a job of `timegap bench`"))?;
    // This process ends with the benchmark.
    set_parent_process_death_signal(Some(Signal::KILL))
        .map_err(failed("follow its parent process"))?;
    if getppid() != Pid::from_raw(job.parent.cast_signed()) {
        return Err(Error::Interrupted);
    }
    let outcome = match &job.task {
        Task::Load(kind) => {
            schedule(&job);
            busy(*kind)
        }
        Task::Metronome => metronome_job(&job),
        Task::Source(turns) => source(&job, root, turns),
        Task::Sink(turns) => sink(&job, root, turns),
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

pub fn page(name: &str) -> Result<SharedWords, MachineError> {
    SharedWords::map(name).map_err(failed("share memory"))
}

/// Counts like the control loop: a release in the past is skipped, and lateness counts from each scheduled
/// instant.
fn metronome_job(job: &Job) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let granted = schedule(job);
    let state = &page[METRONOME];
    let mut latencies = Latencies::default();
    page[READY].store(1, Ordering::Release);
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

/// The instant of the next wake-up. A late source skips missed ones, since only the way to the sink is
/// measured.
fn following(last: i64, period_ns: i64) -> i64 {
    let over = (monotonic_ns() - last).max(0) / period_ns;
    last + (over + 1) * period_ns
}

fn source(job: &Job, root: &Path, turns: &Turns) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let granted = schedule(job);
    let mut source = Source::open(&turns.ways, root, &page)?;
    let mut cycles = 0;
    for (number, &way) in (1_u32..).zip(&turns.order) {
        while page[READY].load(Ordering::Acquire) < number {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        let mut next = monotonic_ns() + job.period_ns;
        for _ in 0..UNCOUNTED + turns.wakes {
            while monotonic_ns() < next {
                sleep_until(next);
            }
            source.wake(way)?;
            cycles += 1;
            next = following(next, job.period_ns);
        }
        page[DONE].store(number, Ordering::Release);
        source.ring(way)?;
    }
    Ok(Outcome::of_cycles(granted, cycles))
}

fn sink(job: &Job, root: &Path, turns: &Turns) -> Result<Outcome, Error> {
    let page = page(&job.page)?;
    let granted = schedule(job);
    let mut sink = Sink::open(&turns.ways, root, &page)?;
    let due = UNCOUNTED + turns.wakes;
    let (mut all, mut cycles, mut misses) = (Vec::new(), 0, 0);
    for (number, &way) in (1_u32..).zip(&turns.order) {
        let mut samples: Vec<u32> = Vec::with_capacity(turns.wakes as usize);
        let mut came = 0;
        // Leftovers of an earlier block in a buffer are older than this.
        let begun = monotonic_ns();
        page[READY].store(number, Ordering::Release);
        loop {
            let before = came;
            let was_done = page[DONE].load(Ordering::Acquire) >= number;
            sink.wait(way, |sent_ns| {
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
    std::fs::write(&path, text).map_err(Error::path("write", &path))?;
    let copied_bytes = sink.copied_bytes();
    Ok(Outcome { misses, copied_bytes, ..Outcome::of_cycles(granted, cycles) })
}

/// Size of the copied buffers: larger than caches.
const BUFFER_BYTES: usize = 64 << 20;

/// Keeps the core busy until the process is killed.
fn busy(load: Load) -> ! {
    match load {
        Load::Idle => loop {
            std::thread::park();
        },
        Load::Cpu => {
            let mut state = 1_u64;
            loop {
                // Each multiplication depends on the previous one: the core never waits for memory.
                state = black_box(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
            }
        }
        Load::Memory => {
            let (mut from, mut to) = (vec![1_u8; BUFFER_BYTES], vec![0_u8; BUFFER_BYTES]);
            loop {
                to.copy_from_slice(black_box(&from));
                from.copy_from_slice(black_box(&to));
            }
        }
    }
}
