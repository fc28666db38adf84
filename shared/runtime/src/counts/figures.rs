//! Counts and histograms of a service that go on over all its processes.
//!
//! A process that is killed cannot report, and percentiles of two processes cannot be added. So the processes of a
//! service record in one file, one after the other, and nowhere else. When a process ends in any way, at most its
//! running cycle is missing. A standby records nothing until it takes over.
//!
//! A name is a hash, 0 for a free place. It takes its place by compare-and-swap, because the active process and its
//! standby open the file at the same time. A histogram gets memory when it is opened.

#![allow(unsafe_code, reason = "a struct of atomic numbers in shared memory")]

use super::statistics::{Buckets, Latencies};
use super::{PROCESSES, SLOTS, State, path};
use crate::words::{Atomics, Shared, open_existing_own, open_own};
use crate::{Group, RuntimeError};
use std::fmt::Display;
use std::fs::File;
use std::io;
use std::mem::offset_of;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use xxhash_rust::xxh3::xxh3_64;

/// Name of the histogram that every service has: actual minus scheduled start of its cycles.
pub const RELEASE_JITTER: &str = "release_jitter";

/// Hashes of the names in a service's file; 0 for a free place. And the counts.
#[repr(C, align(4096))]
#[derive(Debug)]
pub(super) struct Names {
    histograms: [AtomicU64; SLOTS],
    counts: [AtomicU64; SLOTS],
    values: [AtomicU64; SLOTS],
    /// Processes by their incarnation, counted from 1, and their cycles. Those of a standby are among them.
    processes: [AtomicU64; PROCESSES],
    cycles: [AtomicU64; PROCESSES],
}

// SAFETY: words alone.
unsafe impl Atomics for Names {}

/// The counts and histograms of a service: in realtime those of all its processes, else this process's own.
///
/// Another process reads them with the same type. The service's processes may all be gone.
#[derive(Debug)]
pub struct Figures {
    /// The service's file; `None` for figures of this process alone.
    file: Option<File>,
    names: Arc<Shared<Names>>,
    /// False while the process stands by.
    records: Arc<AtomicBool>,
    /// Process whose cycles it shows.
    shown: Option<u32>,
}

impl Default for Figures {
    fn default() -> Self {
        Self::new(None, Shared::private())
    }
}

impl Figures {
    /// Those of a process of `service`, or of anything else that counts under that name in the run. It makes the file if
    /// there is none.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for it.
    pub fn open(group: &Group, service: impl Display) -> Result<Self, RuntimeError> {
        let path = path(&group.prefix, service);
        let figures = open_own(&path).and_then(Self::in_file);
        figures.map_err(RuntimeError::setup(path.display().to_string()))
    }

    /// Those of `service` in the run of `group`, as another process reads them. They are empty if the service made no
    /// file.
    pub fn of(group: &Group, service: impl Display) -> Self {
        let file = open_existing_own(&path(&group.prefix, service));
        file.and_then(Self::in_file).unwrap_or_default()
    }

    fn in_file(file: File) -> io::Result<Self> {
        let names = Shared::of(&file, offset_of!(State, names))?;
        Ok(Self::new(Some(file), names))
    }

    fn new(file: Option<File>, names: Shared<Names>) -> Self {
        Self { file, names: Arc::new(names), records: Arc::new(true.into()), shown: None }
    }

    /// Sets whether this process records: a standby does not.
    pub(crate) fn set_recording(&self, records: bool) {
        self.records.store(records, Ordering::Relaxed);
    }

    /// Shows others from now on that this is process `incarnation`, and its cycles.
    pub fn begin(&mut self, incarnation: u32) {
        self.shown = Some(incarnation);
        self.show_progress(0);
    }

    /// Shows others that this process, which has begun, has done `cycles`.
    pub fn show_progress(&self, cycles: u64) {
        let Some(incarnation) = self.shown else { return };
        let place = incarnation as usize % PROCESSES;
        self.names.cycles[place].store(cycles, Ordering::Relaxed);
        self.names.processes[place].store(u64::from(incarnation) + 1, Ordering::Release);
    }

    /// The progress of process `incarnation`; `None` if it shows no cycles.
    pub fn progress(&self, incarnation: u32) -> Option<Progress> {
        let (names, place) = (Arc::clone(&self.names), incarnation as usize % PROCESSES);
        let shown = names.processes[place].load(Ordering::Acquire);
        (shown == u64::from(incarnation) + 1).then_some(Progress { names, place })
    }

    pub fn count(&self, name: &str) -> Result<Count, RuntimeError> {
        let slot = slot(&self.names.counts, name).map_err(RuntimeError::setup(name.to_owned()))?;
        Ok(Count { names: Arc::clone(&self.names), slot, records: Arc::clone(&self.records) })
    }

    pub fn latencies(&self, name: &str) -> Result<Latencies, RuntimeError> {
        let buckets = slot(&self.names.histograms, name).and_then(|slot| match &self.file {
            Some(file) => {
                Shared::of(file, offset_of!(State, histograms) + slot * size_of::<Buckets>())
            }
            None => Ok(Shared::private()),
        });
        let buckets = buckets.map_err(RuntimeError::setup(name.to_owned()))?;
        Ok(Latencies::of(buckets, Arc::clone(&self.records)))
    }
}

/// The progress of a process, as another one sees it.
#[derive(Debug)]
pub struct Progress {
    names: Arc<Shared<Names>>,
    place: usize,
}

impl Progress {
    /// Cycles that it has done, silent ones included.
    pub fn cycles(&self) -> u64 {
        self.names.cycles[self.place].load(Ordering::Relaxed)
    }
}

/// The place of `name` among these.
fn slot(names: &[AtomicU64], name: &str) -> io::Result<usize> {
    // Never 0, which is not a name.
    let hash = xxh3_64(name.as_bytes()) | 1;
    let take = |place: &AtomicU64| {
        let was = place.compare_exchange(0, hash, Ordering::Relaxed, Ordering::Relaxed);
        was.map_or_else(|taken| taken == hash, |_| true)
    };
    names.iter().position(take).ok_or_else(|| io::ErrorKind::StorageFull.into())
}

/// A count that goes on over all processes of a service in realtime.
#[derive(Debug)]
pub struct Count {
    names: Arc<Shared<Names>>,
    slot: usize,
    records: Arc<AtomicBool>,
}

impl Count {
    pub fn add(&mut self, more: u64) {
        if self.records.load(Ordering::Relaxed) {
            self.names.values[self.slot].fetch_add(more, Ordering::Relaxed);
        }
    }

    pub fn get(&self) -> u64 {
        self.names.values[self.slot].load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::tests::Run;
    use messages::Service;

    fn open(run: &Run) -> Figures {
        Figures::open(&run.0, Service::Plant).expect("shared memory")
    }

    fn last(run: &Run, name: &str) -> (Latencies, u64) {
        let last = Figures::of(&run.0, Service::Plant);
        let count = last.count(name).expect("room").get();
        (last.latencies(name).expect("room"), count)
    }

    #[test]
    fn the_records_of_three_processes_are_one_distribution() {
        let run = Run::new("three");
        let mut alone = Latencies::default();
        for process in 0..3_i64 {
            let counts = open(&run);
            let kept = &counts;
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
        assert_eq!(last(&run, "law"), (alone, 0));
        assert_eq!((last(&run, "late").1, last(&run, "jitter").0.count()), (21, 0));
    }

    #[test]
    fn a_standby_records_nothing_before_it_takes_over() {
        let run = Run::new("standby");
        let (active, standby) = (open(&run), open(&run));
        standby.set_recording(false);
        let figures = |kept: &Figures| (kept.latencies("law").expect("room"), kept.count("late"));
        let ((mut law, late), (mut silent, silent_late)) = (figures(&active), figures(&standby));
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
    fn another_process_sees_the_cycles_of_each_process() {
        let run = Run::new("progress");
        let reader = open(&run);
        for incarnation in 0..40 {
            let mut counts = open(&run);
            counts.show_progress(7);
            assert!(reader.progress(incarnation).is_none(), "it has not begun");
            counts.begin(incarnation);
            let progress = reader.progress(incarnation).expect("it has begun");
            assert_eq!(progress.cycles(), 0);
            counts.show_progress(9);
            assert_eq!(progress.cycles(), 9);
        }
        assert!(reader.progress(3).is_none(), "another process has its place");
        assert_eq!(reader.progress(39).map(|progress| progress.cycles()), Some(9));
        assert_eq!(reader.progress(38).map(|progress| progress.cycles()), Some(9));
        assert!(Figures::of(&run.0, Service::Controller).progress(0).is_none());
    }

    #[test]
    fn a_service_that_recorded_nothing_has_no_figures() {
        assert_eq!(last(&Run::new("none"), "law"), (Latencies::default(), 0));
        let run = Run::new("full");
        let counts = open(&run);
        let kept = &counts;
        for name in 0..SLOTS {
            kept.count(&name.to_string()).expect("room");
        }
        assert!(kept.count("one more").is_err() && kept.count("0").is_ok());
    }
}
