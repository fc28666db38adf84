//! The stage of measurements: a run's root of their own, with the processes on it.

use super::paired::{Compared, Comparison, PAIRS_IN_SESSION, WAKES, histogram, order, paired};
use super::peer::{self, BLOCKS_FILE, Job, Outcome, Task, Turns, metronome};
use super::setup::{Conditions, Load, Mechanism, Placement, Scheduling, failed};
use super::wake;
use runtime::scheduling::usable_cores;
use runtime::{Group, Mode, SharedWords, Timetable};
use rustix::event::{EventfdFlags, eventfd};
use std::os::fd::OwnedFd;
use std::os::unix::process::CommandExt;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use supervise::{Attendant, Error, Janitor, RunRoot, check_room, this_program};

/// Priorities as of a group's services: the source runs before the sink.
const SOURCE_PRIORITY: u8 = 81;
const SINK_PRIORITY: u8 = 80;
/// The metronome has the highest priority: it measures the machine without our processes.
const METRONOME_PRIORITY: u8 = 90;
/// Time for a process to become ready.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time between two looks at a process that is ending.
const LOOK: Duration = Duration::from_millis(2);
/// Shared memory for the largest payloads, bytes.
const ROOM: u64 = 64 << 20;

/// A process of the benchmark, killed with its handle.
#[derive(Debug)]
pub struct Peer {
    attendant: Attendant,
    interrupted: Arc<AtomicBool>,
}

impl Peer {
    /// End of the process, if it has ended: true if it was successful.
    fn ended(&mut self) -> Option<bool> {
        self.attendant.process.poll().map(|status| status.success())
    }

    /// The outcome of its job, once it has ended. Its errors are on standard error.
    pub fn finish(mut self) -> Result<Outcome, Error> {
        loop {
            let has_ended = self.ended().is_some();
            // Its last line may still be on its way.
            let wait = if has_ended { PATIENCE } else { LOOK };
            if let Some(outcome) = self.attendant.receive(wait) {
                return Ok(outcome);
            }
            if has_ended {
                return Err(failed("measure")("a process ended without its outcome").into());
            }
            if self.interrupted.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
        }
    }
}

/// The group of a benchmark: realtime, without an end and without restarts.
pub(crate) fn group_below(root: &RunRoot) -> Group {
    let strides = [1; messages::Service::ALL.len()];
    let timetable = Timetable { step_ns: 1_000_000, strides, last_step: u64::MAX };
    root.group(Mode::Realtime, timetable, Vec::new(), String::new())
}

/// The root, its page of words and the cores.
#[derive(Debug)]
pub struct Stage {
    root: Option<RunRoot>,
    janitor: Option<Janitor>,
    page_name: String,
    page: SharedWords,
    cores: Vec<usize>,
    interrupted: Arc<AtomicBool>,
}

impl Stage {
    /// A new stage. Once `interrupted` is set, waiting for its processes fails.
    pub fn create(interrupted: Arc<AtomicBool>) -> Result<Self, Error> {
        check_room(ROOM)?;
        let root = RunRoot::create()?;
        let janitor = Janitor::spawn(&root)?;
        group_below(&root).write()?;
        let page_name = format!("{}bench", root.prefix());
        let page = peer::page(&page_name)?;
        let (root, janitor) = (Some(root), Some(janitor));
        Ok(Self { root, janitor, page_name, page, cores: usable_cores(), interrupted })
    }

    /// Cores that the benchmark may use.
    pub fn cores(&self) -> &[usize] {
        &self.cores
    }

    pub fn placed(&self, placement: Placement) -> (usize, usize) {
        let last = self.cores.last().copied().unwrap_or(0);
        match placement {
            Placement::SameCore => (last, last),
            Placement::TwoCores => (self.cores.first().copied().unwrap_or(0), last),
        }
    }

    /// One busy process on every core; they end with the handles.
    pub fn load(&self, load: Load) -> Result<Vec<Peer>, Error> {
        if load == Load::Idle {
            return Ok(Vec::new());
        }
        self.cores.iter().map(|&core| self.spawn(Task::Load(load), None, core, 1, None)).collect()
    }

    /// Lets a source wake a sink this many times. Returns the sink's outcome.
    pub fn wake(
        &self,
        mechanism: Mechanism,
        conditions: Conditions,
        period_us: u32,
        wakes: u32,
    ) -> Result<Outcome, Error> {
        let turns = Turns { ways: vec![mechanism], order: vec![0], wakes };
        let (samples, sink, _) = self.between(turns, conditions, period_us)?;
        Ok(Outcome { latencies: histogram(samples.iter().flatten()), ..sink })
    }

    /// Runs a sink and a source to their end. Returns the samples of each block, ns, and both outcomes.
    fn between(
        &self,
        turns: Turns,
        conditions: Conditions,
        period_us: u32,
    ) -> Result<(Vec<Vec<u32>>, Outcome, Outcome), Error> {
        self.clear();
        let fifo = conditions.scheduling == Scheduling::Fifo;
        let (source_core, sink_core) = self.placed(conditions.placement);
        let counter = eventfd(0, EventfdFlags::CLOEXEC).map_err(failed("make an eventfd"))?;
        let spawn = |task, priority, core| {
            let counter = counter.try_clone().map_err(failed("pass an eventfd"))?;
            self.spawn(task, fifo.then_some(priority), core, period_us, Some(counter))
        };
        let mut sink = spawn(Task::Sink(turns.clone()), SINK_PRIORITY, sink_core)?;
        let mut source = spawn(Task::Source(turns), SOURCE_PRIORITY, source_core)?;
        while source.ended().is_none() && !self.interrupted.load(Ordering::Relaxed) {
            // A source without its sink would wait for ever.
            if sink.ended() == Some(false) {
                sink.finish()?;
                return Err(failed("measure")("the sink ended before its source").into());
            }
            std::thread::sleep(LOOK);
        }
        let source = source.finish()?;
        let sink = sink.finish()?;
        let path = self.root().path().join(BLOCKS_FILE);
        let text = std::fs::read_to_string(&path).map_err(failed("read the samples"))?;
        let samples = serde_json::from_str(&text).map_err(failed("read the samples"))?;
        Ok((samples, sink, source))
    }

    /// One session of a comparison, block by block; `None` if the kernel refused the scheduling.
    pub fn compare(
        &self,
        comparison: Comparison,
        conditions: Conditions,
        period_us: u32,
        session: u32,
    ) -> Result<Option<Compared>, Error> {
        let number = 100 * comparison as u64 + u64::from(session);
        let seed = u64::from(period_us) + 1_000_000 * number;
        let order = order(PAIRS_IN_SESSION, seed);
        let turns = Turns { ways: comparison.arms().into(), order: order.clone(), wakes: WAKES };
        let (samples, sink, source) = self.between(turns, conditions, period_us)?;
        let as_asked = |outcome: &Outcome| outcome.granted.granted == outcome.granted.requested;
        if !as_asked(&sink) || !as_asked(&source) {
            return Ok(None);
        }
        let (lost, pairs) = (sink.misses, paired(samples, &order));
        Ok(Some(Compared { comparison, conditions, period_us, lost, pairs }))
    }

    /// The root of its processes; others can join them there.
    pub fn root(&self) -> &RunRoot {
        self.root.as_ref().expect("there until the end")
    }

    /// Starts a metronome on the core of the placement's sink; it ticks without counting.
    pub fn metronome(
        &self,
        conditions: Conditions,
        period_us: u32,
    ) -> Result<Metronome<'_>, Error> {
        let (_, core) = self.placed(conditions.placement);
        self.metronome_on(core, conditions.scheduling, period_us)
    }

    /// The same on a core of its own choice.
    pub fn metronome_on(
        &self,
        core: usize,
        scheduling: Scheduling,
        period_us: u32,
    ) -> Result<Metronome<'_>, Error> {
        self.clear();
        let fifo = scheduling == Scheduling::Fifo;
        let priority = fifo.then_some(METRONOME_PRIORITY);
        let peer = self.spawn(Task::Metronome, priority, core, period_us, None)?;
        let begun = Instant::now();
        while self.page[wake::READY].load(Ordering::Acquire) == 0 {
            if begun.elapsed() > PATIENCE {
                return Err(failed("start the metronome")("it does not tick in time").into());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(Metronome { stage: self, peer })
    }

    /// The best scheduling that the kernel grants.
    pub fn reference(&self) -> Result<Scheduling, Error> {
        let (placement, scheduling) = (Placement::SameCore, Scheduling::Fifo);
        let conditions = Conditions { placement, scheduling, load: Load::Idle };
        let granted = self.metronome(conditions, 1_000)?.finish()?.granted;
        let got = granted.granted == granted.requested;
        Ok(if got { Scheduling::Fifo } else { Scheduling::Other })
    }

    fn clear(&self) {
        for word in [wake::COUNT, wake::READY, wake::DONE, wake::METRONOME] {
            self.page[word].store(0, Ordering::Release);
        }
    }

    fn spawn(
        &self,
        task: Task,
        priority: Option<u8>,
        core: usize,
        period_us: u32,
        stdin: Option<OwnedFd>,
    ) -> Result<Peer, Error> {
        let job = Job {
            task,
            parent: std::process::id(),
            page: self.page_name.clone(),
            priority,
            core,
            period_ns: i64::from(period_us) * 1000,
        };
        let job = serde_json::to_string(&job).expect("plain data");
        let mut command = this_program(&["service", "bench"])?;
        command
            .arg0("timegap-bench")
            .arg(self.root().path())
            .arg(job)
            .stdin(stdin.map_or_else(Stdio::null, Stdio::from))
            .stdout(Stdio::piped());
        let attendant = Attendant::start(command, "bench", 0)?;
        Ok(Peer { attendant, interrupted: Arc::clone(&self.interrupted) })
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        if let Some(root) = self.root.take() {
            root.remove();
        }
        if let Some(janitor) = self.janitor.take() {
            janitor.dismiss();
        }
    }
}

/// A process that only wakes up in time, as a reference for others.
#[derive(Debug)]
pub struct Metronome<'a> {
    stage: &'a Stage,
    peer: Peer,
}

impl Metronome<'_> {
    /// Starts or stops counting.
    pub fn count(&self, counts: bool) {
        let state = if counts { metronome::COUNT } else { metronome::WARM };
        self.stage.page[wake::METRONOME].store(state, Ordering::Relaxed);
    }

    pub fn finish(self) -> Result<Outcome, Error> {
        self.stage.page[wake::METRONOME].store(metronome::STOP, Ordering::Relaxed);
        self.peer.finish()
    }
}
