//! Waking of processes that wait for a topic: a futex beside iceoryx2.
//!
//! Each topic has a word in shared memory that counts its notifications. A process that waits reads the word
//! *before* it looks for a sample. It sleeps only as long as the word has not moved since:
//!
//! ```text
//! publisher:  send ─► word += 1 ─► FUTEX_WAKE (all)
//! consumer:   ticket = word ─► look ─► nothing there ─► FUTEX_WAIT while word == ticket
//! ```
//!
//! So no wake-up is lost: a sample sent after the look has moved the word. The word is all the state. A process that
//! dies leaves nothing to clean up, and one that is started again needs no connection.
//!
//! iceoryx2's own event service has a datagram socket for each listener and a set of bits. It does the same
//! at more than twice the cost; `timegap bench` measures both beside the bare futex.

use crate::in_process::coroutine::Pause;
use crate::words::{RunWords, Shared};
use messages::Topic;
use rustix::io::Errno;
use rustix::thread::futex;
use std::cell::Cell;
use std::io;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// The word of a topic, by which its sender wakes those who wait for it in other processes.
#[derive(Clone, Debug)]
pub struct Waker {
    words: Arc<Shared<RunWords>>,
    topic: Topic,
}

impl Waker {
    pub(crate) fn new(words: &Arc<Shared<RunWords>>, topic: Topic) -> Self {
        Self { words: Arc::clone(words), topic }
    }

    /// Wakes all who wait. To be called after the sample was sent.
    pub fn wake(&self) {
        wake_word(self.words.wake(self.topic));
    }

    /// The state of the word, to be taken before looking for a sample.
    pub fn ticket(&self) -> u32 {
        self.words.wake(self.topic).load(Ordering::Acquire)
    }

    /// Waits until a sender woke the topic's waiters since `ticket` was taken, at most for `timeout`. A signal ends the
    /// wait early.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn wait(&self, ticket: u32, timeout: Duration) -> io::Result<()> {
        wait_word(self.words.wake(self.topic), ticket, timeout)
    }
}

/// Means by which a receiver waits for a topic.
#[derive(Debug)]
pub(crate) enum Waiter {
    Futex(Waker),
    /// By letting the other services of the thread go on.
    InProcess {
        /// The handle that gives the turn away.
        pause: Pause,
        /// No message will come any more.
        stalled: Rc<Cell<bool>>,
    },
}

impl Waiter {
    pub(crate) fn ticket(&self) -> u32 {
        match self {
            Self::Futex(waker) => waker.ticket(),
            Self::InProcess { .. } => 0,
        }
    }

    /// As [`Waker::wait`]. Another service's wait in this thread ends it too.
    pub(crate) fn wait(&self, ticket: u32, timeout: Duration) -> io::Result<()> {
        match self {
            Self::Futex(waker) => waker.wait(ticket, timeout),
            Self::InProcess { pause, .. } => {
                pause.wait();
                Ok(())
            }
        }
    }

    /// True if a wait is another service's turn in this thread.
    pub(crate) fn is_in_process(&self) -> bool {
        matches!(self, Self::InProcess { .. })
    }

    /// True if waiting longer is of no use.
    pub(crate) fn is_in_vain(&self) -> bool {
        matches!(self, Self::InProcess { stalled, .. } if stalled.get())
    }
}

/// Moves a word in shared memory, and wakes all who wait for that.
///
/// # Panics
/// Never: the word is mapped.
pub fn wake_word(word: &AtomicU32) {
    word.fetch_add(1, Ordering::Release);
    futex::wake(word, futex::Flags::empty(), i32::MAX.unsigned_abs())
        .expect("waking fails only for addresses that are none");
}

/// Waits while a word holds `seen`, at most for `timeout`. A signal ends the wait early.
///
/// # Errors
/// If the system refuses.
pub fn wait_word(word: &AtomicU32, seen: u32, timeout: Duration) -> io::Result<()> {
    let timeout = timeout.try_into().map_err(|_| io::ErrorKind::InvalidInput)?;
    match futex::wait(word, futex::Flags::empty(), seen, Some(&timeout)) {
        Ok(()) | Err(Errno::AGAIN | Errno::TIMEDOUT | Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU64;
    use std::time::Instant;

    /// A page of this test's own, removed at its end.
    struct Page(String);

    impl Page {
        fn new(test: &str) -> Self {
            Self(format!("timegap_test-{}-{test}_", std::process::id()))
        }

        fn words(&self) -> Arc<Shared<RunWords>> {
            Arc::new(RunWords::map(&self.0).expect("shared memory"))
        }
    }

    impl Drop for Page {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(format!("/dev/shm/{}wake", self.0));
        }
    }

    #[test]
    fn a_wake_up_between_look_and_wait_is_not_lost() {
        let page = Page::new("between");
        let (ours, theirs) = (page.words(), page.words());
        let waiter = Waker::new(&ours, Topic::Command);
        let ticket = waiter.ticket();
        Waker::new(&theirs, Topic::Command).wake();
        let begun = Instant::now();
        waiter.wait(ticket, Duration::from_secs(60)).expect("a valid wait");
        assert!(begun.elapsed() < Duration::from_secs(30), "it waited for its timeout");
    }

    #[test]
    fn another_topic_wakes_no_waiter_and_the_timeout_ends_the_wait() {
        let page = Page::new("another");
        let words = page.words();
        let waiter = Waker::new(&words, Topic::Command);
        let ticket = waiter.ticket();
        Waker::new(&words, Topic::Odometry).wake();
        let begun = Instant::now();
        waiter.wait(ticket, Duration::from_millis(5)).expect("a valid wait");
        assert!(begun.elapsed() >= Duration::from_millis(4));
    }

    /// Two threads pass a count to and fro, each sleeping until the other has moved it. One lost wake-up would cost a
    /// timeout, which is counted.
    #[test]
    fn no_wake_up_of_many_is_lost() {
        const TURNS: u64 = 20_000;
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let page = Page::new("many");
        let play = |page: &Page, wake: Topic, wait: Topic, mine: u64| {
            let words = page.words();
            let (waker, waiter) = (Waker::new(&words, wake), Waker::new(&words, wait));
            let mut timeouts = 0;
            loop {
                let ticket = waiter.ticket();
                match COUNT.load(Ordering::SeqCst) {
                    TURNS.. => return timeouts,
                    count if count % 2 == mine => {
                        COUNT.store(count + 1, Ordering::SeqCst);
                        waker.wake();
                    }
                    _ => {
                        let begun = Instant::now();
                        waiter.wait(ticket, Duration::from_secs(5)).expect("a valid wait");
                        timeouts += u64::from(begun.elapsed() >= Duration::from_secs(5));
                    }
                }
            }
        };
        let timeouts = std::thread::scope(|scope| {
            let other = scope.spawn(|| play(&page, Topic::Spat, Topic::Map, 1));
            play(&page, Topic::Map, Topic::Spat, 0) + other.join().expect("no panic")
        });
        assert_eq!(timeouts, 0);
    }
}
