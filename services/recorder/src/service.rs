//! The recorder's process: taps all topics, and lets a thread of its own write.
//!
//! Taking messages and writing them are apart: memory absorbs a slow disk, not the short buffers of the topics. When
//! that memory is full as well, the topics' own rules hold. In lockstep the senders wait. In realtime the oldest
//! messages are lost, and counted.

use crate::bag;
use crate::batch::Taps;
use crate::counter::Counter;
use crate::link::{FromRecorder, Report, Start, ToRecorder, orders, say};
use crate::sequencer::{Placed, Sequencer};
use crate::{Metadata, Recording, Tally, TopicTally, Writer};
use mcap::{McapError, Summary};
use runtime::{Group, Guest, Mode, RuntimeError, log_warnings, monotonic_ns};
use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::fs::File;
use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two looks at the topics in lockstep, where senders wait for room.
const LOCKSTEP_POLL: Duration = Duration::from_millis(1);
/// The same in realtime, in periods of the plant: a topic's buffer holds fifty.
const REALTIME_POLL: u32 = 5;
/// Most bytes that wait for the disk.
const MOST_QUEUED: usize = 64 << 20;
/// Longest that a message waits before it is handed to the system; in lockstep, simulated time.
const FLUSH_PERIOD: Duration = Duration::from_secs(1);

/// Becomes the recorder of a run. `arguments` are the run's root and the file to write.
pub fn run(arguments: &[OsString]) -> ExitCode {
    attend(arguments, |root, file| record(root, Path::new(file)).map(Some))
}

/// Becomes a process beside a run that takes its messages away. `arguments` are the run's root, and what `follow` gets
/// beside it. The launcher gets the report, or why there is none.
pub fn attend<E: Display>(
    arguments: &[OsString],
    follow: impl FnOnce(&Path, &OsStr) -> Result<Option<Report>, E>,
) -> ExitCode {
    let [root, target] = arguments else {
        eprintln!("this is a service of timegap: start it with `timegap run`");
        return ExitCode::from(2);
    };
    log_warnings();
    match follow(Path::new(root), target) {
        Ok(report) => {
            report.into_iter().for_each(|report| say(&FromRecorder::Report(report)));
            ExitCode::SUCCESS
        }
        Err(reason) => {
            say(&FromRecorder::Failed(reason.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn record(root: &Path, path: &Path) -> Result<Report, RuntimeError> {
    let group = Group::read(root)?;
    let scenario = group.scenario()?;
    let taps = Guest::join(&group, "recorder").and_then(Taps::open)?;
    bag::remove_beside(path);
    let not_made = |reason| RuntimeError::Setup(path.display().to_string(), reason);
    let file = File::create(path).map_err(not_made)?;
    let orders = orders()?;
    let start = begin(&taps, &orders)?;
    let sequencer =
        Sequencer::new(group.mode, scenario.services().iter().map(|service| service.to_wire()));
    let metadata = start.metadata(&scenario, group.mode);
    let no_thread = |reason| RuntimeError::Setup("a thread that writes".into(), reason);
    let disk = Disk::begin(file, metadata).map_err(no_thread)?;
    let tally = follow(&group, &taps, &orders, &start, &disk, sequencer)?;
    let ended = disk.end(&tally);
    let bytes = std::fs::metadata(path).map_or(0, |file| file.len());
    let tally = if ended.is_err() { kept(path, &tally) } else { tally };
    let listed = |summary| bag::write_beside(path, &summary).map_err(|error| error.to_string());
    Ok(Report { tally, bytes, failed: ended.and_then(listed).err() })
}

/// Connects to the senders when their ports exist, and waits for the common start.
///
/// # Errors
/// [`RuntimeError::Stopped`] if the run ends before, [`RuntimeError::Topic`].
pub fn begin(taps: &Taps, orders: &Receiver<ToRecorder>) -> Result<Start, RuntimeError> {
    loop {
        match orders.recv() {
            // A receiver that has not looked is not connected. Nothing was sent yet.
            Ok(ToRecorder::Connect) => drop(taps.take()?),
            Ok(ToRecorder::Start(start)) => return Ok(start),
            Ok(ToRecorder::Finish) | Err(_) => return Err(RuntimeError::Stopped),
        }
        say(&FromRecorder::Ready);
    }
}

/// Takes messages until the order to finish, and those that were sent before it.
fn follow(
    group: &Group,
    taps: &Taps,
    orders: &Receiver<ToRecorder>,
    start: &Start,
    disk: &Disk,
    mut sequencer: Sequencer,
) -> Result<Tally, RuntimeError> {
    let step = Duration::from_nanos(group.timetable.step_ns.unsigned_abs());
    let poll = match group.mode {
        Mode::Lockstep => LOCKSTEP_POLL,
        Mode::Realtime => REALTIME_POLL * step,
    };
    let mut counter = Counter::default();
    let mut finishing = false;
    loop {
        let mut nothing = true;
        if disk.has_room() {
            let batch = taps.take()?;
            let now_ns = monotonic_ns() - start.start_ns;
            nothing = batch.is_empty();
            for (topic, bytes) in batch.messages() {
                counter.count(topic, bytes);
                sequencer.add(topic, bytes, now_ns);
            }
            disk.put(sequencer.ready(now_ns));
        }
        if finishing && nothing && disk.has_room() {
            disk.put(sequencer.rest());
            return Ok(counter.tally());
        }
        match orders.recv_timeout(poll) {
            Ok(ToRecorder::Finish) | Err(RecvTimeoutError::Disconnected) => finishing = true,
            Ok(ToRecorder::Connect | ToRecorder::Start(_)) | Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

/// Tally of a file whose end could not be written. It gives the content, and that the rest is lost.
fn kept(path: &Path, sent: &Tally) -> Tally {
    let in_file =
        Recording::open(path).map_or_else(|_| Tally::default(), |file| file.survey().tally);
    let topics = sent.topics.iter().map(|(name, sent)| {
        let messages = in_file.topics.get(name).map_or(0, |topic| topic.messages);
        let lost = sent.messages.saturating_add(sent.lost).saturating_sub(messages);
        (name.clone(), TopicTally { messages, lost })
    });
    Tally { topics: topics.collect(), incarnations: sent.incarnations.clone() }
}

enum Work {
    Messages(Vec<Placed>),
    End(Tally),
}

/// The thread that writes, and the queue before it.
struct Disk {
    work: Sender<Work>,
    queued: Arc<AtomicUsize>,
    thread: JoinHandle<Result<Summary, McapError>>,
}

impl Disk {
    fn begin(file: File, metadata: Metadata) -> io::Result<Self> {
        let (work, queue) = channel();
        let queued = Arc::new(AtomicUsize::new(0));
        let written = Arc::clone(&queued);
        let thread = std::thread::Builder::new()
            .name("disk".into())
            .spawn(move || write(file, &metadata, &queue, &written))?;
        Ok(Self { work, queued, thread })
    }

    /// True unless as much waits as may wait. A disk that failed takes everything.
    fn has_room(&self) -> bool {
        self.thread.is_finished() || self.queued.load(Ordering::Relaxed) < MOST_QUEUED
    }

    fn put(&self, messages: Vec<Placed>) {
        self.queued.fetch_add(size(&messages), Ordering::Relaxed);
        // After a failure, which `end` reports, messages are dropped: no sender must wait for them.
        let _ = self.work.send(Work::Messages(messages));
    }

    /// Writes the rest and the end.
    fn end(self, tally: &Tally) -> Result<Summary, String> {
        // As above.
        let _ = self.work.send(Work::End(tally.clone()));
        match self.thread.join() {
            Ok(Ok(summary)) => Ok(summary),
            Ok(Err(McapError::Io(error))) => Err(error.to_string()),
            Ok(Err(error)) => Err(error.to_string()),
            Err(_) => Err("the writing thread panicked".into()),
        }
    }
}

/// Memory that `messages` use, bytes.
fn size(messages: &[Placed]) -> usize {
    messages.iter().map(|message| message.bytes.len()).sum()
}

fn write(
    file: File,
    metadata: &Metadata,
    queue: &Receiver<Work>,
    queued: &AtomicUsize,
) -> Result<Summary, McapError> {
    let mut writer = Writer::begin(file, metadata)?;
    let mut flushed = Instant::now();
    loop {
        match queue.recv_timeout(FLUSH_PERIOD.saturating_sub(flushed.elapsed())) {
            Ok(Work::Messages(messages)) => {
                for message in &messages {
                    writer.message(message.topic, message.log_time_ns, &message.bytes)?;
                }
                queued.fetch_sub(size(&messages), Ordering::Relaxed);
            }
            Ok(Work::End(tally)) => return writer.finish(&tally),
            Err(RecvTimeoutError::Timeout) => {}
            // The other thread gave up; what is here is kept.
            Err(RecvTimeoutError::Disconnected) => {
                return writer.flush().map(|()| Summary::default());
            }
        }
        if flushed.elapsed() >= FLUSH_PERIOD {
            // In lockstep the content decides where the file is flushed: its bytes repeat.
            if metadata.mode == Mode::Realtime {
                writer.flush()?;
            }
            flushed = Instant::now();
        }
    }
}
