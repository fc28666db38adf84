//! Counts and histograms of a service that go on over all its processes.
//!
//! A process that is killed cannot report, and percentiles of two processes cannot be added. So the processes of a
//! service share a file in shared memory, one after the other:
//!
//! ```text
//! page 0: names of histograms | names of counts | counts    pages 1 to 4: buckets of the first histogram    ...
//! ```
//!
//! A process records there and nowhere else: whatever ends it, at most the cycle that was running is missing. A standby
//! records nothing until it takes over. A name is a hash, 0 for a free place. It takes its place by compare-and-swap,
//! because the active process and its standby open the file at the same time. A histogram gets memory when it is opened.

use super::Counters;
use super::statistics::{BUCKETS, Latencies};
use crate::words::{PAGE_BYTES, SharedWords, WORDS, open_existing_own, open_own};
use crate::{Group, RuntimeError};
use messages::Service;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use xxhash_rust::xxh3::xxh3_64;

/// Name of the histogram that every service has: actual minus scheduled begin of its cycles.
pub const RELEASE_JITTER: &str = "release_jitter";
/// Most histograms, and most counts, of a service: a plant with an emergency brake has 32 histograms.
const SLOTS: usize = 40;
/// Beginning of the names of counts and of the counts, words.
const COUNT_NAMES: usize = SLOTS;
const COUNTS: usize = 2 * SLOTS;
/// Pages of a histogram.
const HISTOGRAM_PAGES: usize = BUCKETS.div_ceil(WORDS);
/// Largest size of a service's file, bytes.
pub(crate) const MOST_BYTES: usize = (1 + SLOTS * HISTOGRAM_PAGES) * PAGE_BYTES;

const _: () = assert!(COUNTS + SLOTS <= WORDS);

fn path(prefix: &str, service: Service) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.kept"))
}

/// The counts and histograms of a service: in realtime those of all its processes, else this process's own.
#[derive(Debug, Default)]
pub struct Figures(Option<Kept>);

impl Figures {
    /// Opens those of a process of `service`.
    pub(crate) fn open(group: &Group, service: Service) -> Result<Self, RuntimeError> {
        let path = path(&group.prefix, service);
        let error = RuntimeError::setup(path.display().to_string());
        open_own(&path).and_then(Kept::of).map(Some).map(Self).map_err(error)
    }

    /// Opens those of the processes of `service`, which may all be gone; empty figures if there is no file.
    #[must_use]
    pub fn last(group: &Group, service: Service) -> Self {
        let file = open_existing_own(&path(&group.prefix, service));
        Self(file.and_then(Kept::of).ok())
    }

    /// Sets whether this process records: a standby does not.
    pub(crate) fn set_recording(&self, records: bool) {
        if let Some(kept) = &self.0 {
            kept.records.store(records, Ordering::Relaxed);
        }
    }

    /// The count of this name.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for it.
    pub fn count(&self, name: &str) -> Result<Count, RuntimeError> {
        let Some(kept) = &self.0 else { return Ok(Count::default()) };
        let slot = kept.slot(COUNT_NAMES, name).map_err(RuntimeError::setup(name.to_owned()))?;
        let (words, records) = (Arc::clone(&kept.names), Arc::clone(&kept.records));
        Ok(Count(Place::Kept(Counters::new(words, COUNTS + slot, records))))
    }

    /// The histogram of this name.
    ///
    /// # Errors
    /// As [`Self::count`].
    pub fn latencies(&self, name: &str) -> Result<Latencies, RuntimeError> {
        let Some(kept) = &self.0 else { return Ok(Latencies::with_room()) };
        let words = kept.slot(0, name).and_then(|slot| kept.buckets(slot));
        let words = words.map_err(RuntimeError::setup(name.to_owned()))?;
        Ok(Latencies::kept(Counters::new(Arc::new(words), 0, Arc::clone(&kept.records))))
    }
}

/// The file of a service.
#[derive(Debug)]
struct Kept {
    file: File,
    names: Arc<SharedWords>,
    /// False while the process stands by.
    records: Arc<AtomicBool>,
}

impl Kept {
    fn of(file: File) -> io::Result<Self> {
        let names = Arc::new(SharedWords::of(&file, 0, 1)?);
        Ok(Self { file, names, records: Arc::new(AtomicBool::new(true)) })
    }

    fn buckets(&self, slot: usize) -> io::Result<SharedWords> {
        SharedWords::of(&self.file, 1 + slot * HISTOGRAM_PAGES, HISTOGRAM_PAGES)
    }

    /// The place of `name` among the names that begin at this word.
    fn slot(&self, names: usize, name: &str) -> io::Result<usize> {
        let hash = hash(name);
        let take = |slot: &usize| {
            let word = self.names.word(names + *slot);
            match word.compare_exchange(0, hash, Ordering::Relaxed, Ordering::Relaxed) {
                Ok(_) => true,
                Err(taken) => taken == hash,
            }
        };
        (0..SLOTS).find(take).ok_or_else(|| io::ErrorKind::StorageFull.into())
    }
}

/// Never 0, which is no name.
fn hash(name: &str) -> u32 {
    xxh3_64(name.as_bytes()) as u32 | 1
}

/// A count that goes on over all processes of a service in realtime. It wraps at 2³².
#[derive(Debug, Default)]
pub struct Count(Place);

#[derive(Debug)]
enum Place {
    Own(u64),
    Kept(Counters),
}

impl Default for Place {
    fn default() -> Self {
        Self::Own(0)
    }
}

impl Count {
    /// Adds `more`.
    pub fn add(&mut self, more: u64) {
        match &mut self.0 {
            Place::Own(count) => *count += more,
            Place::Kept(counter) => counter.add(0, more as u32),
        }
    }

    /// The count.
    #[must_use]
    pub fn get(&self) -> u64 {
        match &self.0 {
            Place::Own(count) => *count,
            Place::Kept(counter) => counter.get(0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, Timetable};

    /// A run whose files are removed with it.
    struct Run(Group);

    impl Run {
        fn new(name: &str) -> Self {
            Self(Group {
                root: "/tmp".into(),
                prefix: format!("timegap_kept-{name}-{}_", std::process::id()),
                mode: Mode::Realtime,
                standby: Vec::new(),
                timetable: Timetable { step_ns: 1, strides: [1; Service::ALL.len()], last_step: 1 },
                patience_ns: 1,
                scenario: Vec::new(),
            })
        }

        fn open(&self) -> Figures {
            Figures::open(&self.0, Service::Plant).expect("shared memory")
        }

        fn last(&self, name: &str) -> (Latencies, u64) {
            let last = Figures::last(&self.0, Service::Plant);
            (last.latencies(name).expect("room"), last.count(name).expect("room").get())
        }
    }

    impl Drop for Run {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(path(&self.0.prefix, Service::Plant));
        }
    }

    #[test]
    fn what_three_processes_recorded_is_one_distribution() {
        let run = Run::new("three");
        let mut alone = Latencies::default();
        for process in 0..3_i64 {
            let kept = run.open();
            // Each opens its histograms in an order of its own.
            let names = if process == 1 { ["law", "jitter"] } else { ["jitter", "law"] };
            let mut opened = names.map(|name| kept.latencies(name).expect("room"));
            let law = &mut opened[usize::from(names[1] == "law")];
            let mut late = kept.count("late").expect("room");
            for k in 0..1_000 {
                let ns = (process + 1) * k * k * 37;
                law.record_ns(ns);
                alone.record_ns(ns);
            }
            late.add(7);
            assert_eq!(law.percentiles_us(), alone.percentiles_us(), "those before it too");
        }
        assert_eq!(run.last("law"), (alone, 0));
        assert_eq!((run.last("late").1, run.last("jitter").0.count()), (21, 0));
    }

    #[test]
    fn a_standby_records_nothing_before_it_takes_over() {
        let run = Run::new("standby");
        let (active, standby) = (run.open(), run.open());
        standby.set_recording(false);
        let open = |kept: &Figures| (kept.latencies("law").expect("room"), kept.count("late"));
        let ((mut law, late), (mut silent, silent_late)) = (open(&active), open(&standby));
        let (mut late, mut silent_late) = (late.expect("room"), silent_late.expect("room"));
        law.record_ns(1_000);
        late.add(1);
        silent.record_ns(9_000);
        silent_late.add(1);
        assert_eq!((silent.count(), silent_late.get()), (1, 1), "the active one's");
        standby.set_recording(true);
        silent.record_ns(9_000);
        silent_late.add(1);
        let max = law.percentiles_us().map(|p| (p.count, p.max.round()));
        assert_eq!((max, late.get()), (Some((2, 9.0)), 2));
    }

    #[test]
    fn of_a_service_that_kept_nothing_there_is_nothing() {
        assert_eq!(Run::new("none").last("law"), (Latencies::default(), 0));
        let run = Run::new("full");
        let kept = run.open();
        for name in 0..SLOTS {
            kept.count(&name.to_string()).expect("room");
        }
        assert!(kept.count("one more").is_err() && kept.count("0").is_ok());
    }
}
