//! Work beside a loop: what takes longer than a cycle may, in a thread that is not real-time.
//!
//! A loop asks at a release, and the answer takes effect a fixed time later, at the release that is
//! due then: in lockstep that release waits for it, so that the same run gives the same bytes; in
//! realtime it takes what is there, and an answer that is not is late. The loop only ever *tries* the
//! two locks of the handover, which the thread holds for a copy, and allocates nothing.

use super::{Mode, Release, Runtime, RuntimeError, monotonic_ns};
use crate::report::PlanningReport;
use crate::statistics::Latencies;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// A thread that answers questions of type `Q` with `A`.
#[derive(Debug)]
pub struct Beside<Q, A> {
    shared: Arc<Shared<Q, A>>,
    thread: Option<JoinHandle<()>>,
    mode: Mode,
    delay_ns: i64,
    /// When the answer to the open question takes effect, run time in ns.
    due_ns: Option<i64>,
    counted_late: bool,
    asked: u64,
    late: u64,
    worked: Latencies,
}

#[derive(Debug)]
struct Shared<Q, A> {
    question: Mutex<Option<Q>>,
    asked: Condvar,
    answer: Mutex<Option<(A, i64)>>,
    answered: Condvar,
    closed: AtomicBool,
}

impl<Q: Send + 'static, A: Send + 'static> Beside<Q, A> {
    /// Starts the thread `name`, which does `work`. Call it before [`Runtime::begin`]: the thread
    /// must not inherit the loop's place on a core. Answers take effect `delay_ns` after the question.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] when there can be no thread.
    pub fn start(
        runtime: &Runtime,
        name: &str,
        delay_ns: i64,
        work: impl FnMut(&Q) -> A + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let shared = Arc::new(Shared {
            question: Mutex::new(None),
            asked: Condvar::new(),
            answer: Mutex::new(None),
            answered: Condvar::new(),
            closed: AtomicBool::new(false),
        });
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name(name.into())
            .spawn(move || theirs.serve(work))
            .map_err(|error| RuntimeError::Setup(format!("thread {name}: {error}")))?;
        Ok(Self {
            shared,
            thread: Some(thread),
            mode: runtime.clock().mode(),
            delay_ns,
            due_ns: None,
            counted_late: false,
            asked: 0,
            late: 0,
            worked: Latencies::default(),
        })
    }

    /// Whether a question is open.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.due_ns.is_some()
    }

    /// Asks. The question comes back when one is open already, or when the thread holds the handover.
    ///
    /// # Errors
    /// The question, to be asked again at the next release.
    pub fn ask(&mut self, release: &Release, question: Q) -> Result<(), Q> {
        if self.is_busy() {
            return Err(question);
        }
        match self.lock(&self.shared.question) {
            Some(mut slot) => *slot = Some(question),
            None => return Err(question),
        }
        self.shared.asked.notify_one();
        self.due_ns = Some(release.scheduled_ns + self.delay_ns);
        self.counted_late = false;
        self.asked += 1;
        Ok(())
    }

    /// The answer that takes effect at this release, if there is one.
    pub fn answer(&mut self, release: &Release) -> Option<A> {
        if self.due_ns.is_none_or(|due_ns| release.scheduled_ns < due_ns) {
            return None;
        }
        let answer = match self.mode {
            Mode::Realtime => self.lock(&self.shared.answer).and_then(|mut slot| slot.take()),
            Mode::Lockstep => self.wait(),
        };
        let Some((answer, worked_ns)) = answer else {
            self.late += u64::from(!self.counted_late);
            self.counted_late = true;
            return None;
        };
        self.worked.record_ns(worked_ns);
        self.due_ns = None;
        Some(answer)
    }

    /// What became of the questions so far.
    #[must_use]
    pub fn report(&self) -> PlanningReport {
        PlanningReport {
            asked: self.asked,
            late: self.late,
            deadline_us: self.delay_ns as f64 / 1e3,
            plan_us: self.worked.percentiles_us(),
        }
    }

    /// In realtime the loop does not wait, not even for a copy.
    fn lock<'a, T>(&self, slot: &'a Mutex<T>) -> Option<MutexGuard<'a, T>> {
        match self.mode {
            Mode::Realtime => slot.try_lock().ok(),
            Mode::Lockstep => Some(slot.lock().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Waits for the answer; `None` if the thread died over it.
    fn wait(&self) -> Option<(A, i64)> {
        const LOOK: Duration = Duration::from_millis(100);
        let mut slot = self.shared.answer.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if let Some(answer) = slot.take() {
                return Some(answer);
            }
            if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
                return None;
            }
            let waited = self.shared.answered.wait_timeout(slot, LOOK);
            slot = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl<Q, A> Shared<Q, A> {
    fn serve(&self, mut work: impl FnMut(&Q) -> A) {
        while let Some(question) = self.next() {
            let begun = monotonic_ns();
            let answer = work(&question);
            let worked_ns = monotonic_ns() - begun;
            *self.answer.lock().unwrap_or_else(PoisonError::into_inner) = Some((answer, worked_ns));
            self.answered.notify_one();
        }
    }

    fn next(&self) -> Option<Q> {
        let mut slot = self.question.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if self.closed.load(Ordering::Acquire) {
                return None;
            }
            if let Some(question) = slot.take() {
                return Some(question);
            }
            slot = self.asked.wait(slot).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<Q, A> Drop for Beside<Q, A> {
    fn drop(&mut self) {
        // Under the lock, so that a thread about to wait sees it.
        let slot = self.shared.question.lock().unwrap_or_else(PoisonError::into_inner);
        self.shared.closed.store(true, Ordering::Release);
        drop(slot);
        self.shared.asked.notify_one();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so.
            let _ = thread.join();
        }
    }
}
