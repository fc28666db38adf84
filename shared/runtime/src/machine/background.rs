//! Work beside a loop that takes longer than a cycle may, in a thread that is not real-time.
//!
//! A loop asks at a release. The answer takes effect a fixed time later, at the release that is due then. In realtime
//! that release takes an answer that is there; a missing one is late. The thread holds the two locks of the handover for
//! a copy. The loop only ever *tries* them, and allocates nothing. In lockstep the work is done on request, so that the
//! same run gives the same bytes. Its time does not count there.

use crate::counts::statistics::{Latencies, Percentiles};
use crate::{Count, Figures, Mode, Release, Runtime, RuntimeError, monotonic_ns};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;

/// Counts of a [`BackgroundWorker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkerReport {
    pub asked: u64,
    /// Answers that were not there when they were due.
    pub late: u64,
    /// Time after which an answer is due, µs.
    pub deadline_us: f64,
    /// Time that an answer took, on the wall clock in both modes.
    pub worked_us: Option<Percentiles>,
}

type Work<Q, A> = Box<dyn FnMut(&Q) -> A>;

/// A thread that answers questions of type `Q` with `A`.
pub struct BackgroundWorker<Q, A> {
    shared: Arc<Shared<Q, A>>,
    thread: Option<JoinHandle<()>>,
    /// The work, where the loop's own thread does it at once.
    inline: Option<Work<Q, A>>,
    delay_ns: i64,
    /// Time when the answer to the open question takes effect, run time in ns.
    due_ns: Option<i64>,
    counted_late: bool,
    asked: Count,
    late: Count,
    worked: Latencies,
}

struct Shared<Q, A> {
    question: Mutex<Option<Q>>,
    asked: Condvar,
    answer: Mutex<Option<(A, i64)>>,
    closed: AtomicBool,
}

impl<Q: Send + 'static, A: Send + 'static> BackgroundWorker<Q, A> {
    /// Starts the thread `name`, which does `work`. Call it before [`Runtime::begin`]: the thread
    /// must not inherit the loop's place on a core. Answers take effect `delay_ns` after the question.
    pub fn start(
        runtime: &Runtime,
        name: &str,
        delay_ns: i64,
        work: impl FnMut(&Q) -> A + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        Self::new(runtime.clock().mode, runtime.figures(), name, delay_ns, work)
    }

    fn new(
        mode: Mode,
        figures: &Figures,
        name: &str,
        delay_ns: i64,
        work: impl FnMut(&Q) -> A + Send + 'static,
    ) -> Result<Self, RuntimeError> {
        let (question, answer) = (Mutex::new(None), Mutex::new(None));
        let (asked, closed) = (Condvar::new(), AtomicBool::new(false));
        let shared = Arc::new(Shared { question, asked, answer, closed });
        let (mut thread, mut inline): (_, Option<Work<Q, A>>) = (None, None);
        match mode {
            Mode::Realtime => {
                let theirs = Arc::clone(&shared);
                let begun = std::thread::Builder::new().name(name.into());
                let begun = begun.spawn(move || theirs.serve(work));
                thread = Some(begun.map_err(RuntimeError::setup(format!("thread {name}")))?);
            }
            Mode::Lockstep => inline = Some(Box::new(work)),
        }
        Ok(Self {
            shared,
            thread,
            inline,
            delay_ns,
            due_ns: None,
            counted_late: false,
            asked: figures.count("asked")?,
            late: figures.count("late_plans")?,
            worked: figures.latencies("plan")?,
        })
    }

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
        match (&mut self.inline, self.shared.question.try_lock()) {
            (Some(work), _) => self.shared.put(timed(work, &question)),
            (None, Ok(mut slot)) => *slot = Some(question),
            (None, Err(_)) => return Err(question),
        }
        self.shared.asked.notify_one();
        self.due_ns = Some(release.scheduled_ns + self.delay_ns);
        self.counted_late = false;
        self.asked.add(1);
        Ok(())
    }

    /// The answer that takes effect at this release, if there is one.
    pub fn answer(&mut self, release: &Release) -> Option<A> {
        if self.due_ns.is_none_or(|due_ns| release.scheduled_ns < due_ns) {
            return None;
        }
        let answer = self.shared.answer.try_lock().ok().and_then(|mut slot| slot.take());
        let Some((answer, worked_ns)) = answer else {
            self.late.add(u64::from(!self.counted_late));
            self.counted_late = true;
            return None;
        };
        self.worked.record_ns(worked_ns);
        self.due_ns = None;
        Some(answer)
    }

    pub fn report(&self) -> WorkerReport {
        WorkerReport {
            asked: self.asked.get(),
            late: self.late.get(),
            deadline_us: self.delay_ns as f64 / 1e3,
            worked_us: self.worked.percentiles_us(),
        }
    }
}

/// The answer to `question` and the time that it took, ns.
fn timed<Q, A>(work: &mut (impl FnMut(&Q) -> A + ?Sized), question: &Q) -> (A, i64) {
    let begun = monotonic_ns();
    let answer = work(question);
    (answer, monotonic_ns() - begun)
}

impl<Q, A> Shared<Q, A> {
    fn serve(&self, mut work: impl FnMut(&Q) -> A) {
        while let Some(question) = self.next() {
            self.put(timed(&mut work, &question));
        }
    }

    fn put(&self, answer: (A, i64)) {
        *self.answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(answer);
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

impl<Q, A> Drop for BackgroundWorker<Q, A> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    const DELAY_NS: i64 = 200;

    fn worker(
        mode: Mode,
        work: impl FnMut(&u32) -> u32 + Send + 'static,
    ) -> BackgroundWorker<u32, u32> {
        BackgroundWorker::new(mode, &Figures::default(), "work", DELAY_NS, work).expect("a thread")
    }

    fn release(scheduled_ns: i64) -> Release {
        Release {
            step: 0,
            time_s: 0.0,
            scheduled_ns,
            idle_ns: scheduled_ns,
            start_ns: scheduled_ns,
        }
    }

    #[test]
    fn in_lockstep_an_answer_takes_effect_exactly_when_it_is_due() {
        let slow = |x: &u32| {
            std::thread::sleep(Duration::from_millis(5));
            2 * x
        };
        let mut worker = worker(Mode::Lockstep, slow);
        let mut heard = Vec::new();
        for cycle in 0..6 {
            let release = release(100 * cycle);
            heard.push(worker.answer(&release));
            if !worker.is_busy() {
                worker.ask(&release, cycle as u32).expect("none is open");
            }
        }
        assert_eq!(heard, [None, None, Some(0), None, Some(4), None]);
        let report = worker.report();
        assert_eq!((report.asked, report.late), (3, 0));
        assert_eq!(report.worked_us.map(|took| took.count), Some(2));
    }

    #[test]
    fn in_realtime_a_late_answer_is_counted_once_and_taken_when_it_comes() {
        let (go, wait) = channel::<()>();
        let work = move |x: &u32| {
            let _ = wait.recv();
            *x
        };
        let mut worker = worker(Mode::Realtime, work);
        // The thread may just be looking for a question.
        while worker.ask(&release(0), 7).is_err() {}
        assert_eq!(worker.ask(&release(0), 8), Err(8), "one question at a time");
        assert_eq!([100, 200, 300].map(|ns| worker.answer(&release(ns))), [None; 3]);
        assert_eq!(worker.report().late, 1);
        go.send(()).expect("the thread waits");
        let answer = loop {
            if let Some(answer) = worker.answer(&release(400)) {
                break answer;
            }
        };
        assert_eq!((answer, worker.report().late), (7, 1));
    }

    #[test]
    fn a_thread_that_died_is_not_waited_for() {
        let mut worker = worker(Mode::Realtime, |x: &u32| 1 / (*x - *x));
        while worker.ask(&release(0), 7).is_err() {}
        assert_eq!(worker.answer(&release(200)), None);
    }
}
