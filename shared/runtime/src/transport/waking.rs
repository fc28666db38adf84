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
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Wakes those who wait for a topic in other processes.
#[derive(Debug)]
pub struct Waker {
    words: Rc<Shared<RunWords>>,
    topic: Topic,
}

impl Waker {
    pub(super) fn new(words: &Rc<Shared<RunWords>>, topic: Topic) -> Self {
        Self { words: Rc::clone(words), topic }
    }

    /// Wakes all who wait. To be called after the sample was sent.
    ///
    /// # Panics
    /// Never: the word is mapped.
    pub fn wake(&self) {
        wake(&self.words, self.topic);
    }
}

/// Wakes all who wait for `topic`.
pub(crate) fn wake(words: &RunWords, topic: Topic) {
    wake_word(words.wake(topic));
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

/// The state of a topic's word before a look at the topic.
#[derive(Clone, Copy, Debug)]
pub struct Ticket(u32);

/// Waits for a topic.
#[derive(Debug)]
pub struct Waiter(Way);

#[derive(Debug)]
enum Way {
    Futex {
        words: Rc<Shared<RunWords>>,
        topic: Topic,
    },
    /// By letting the other services of the thread go on.
    InProcess {
        /// The handle that gives the turn away.
        pause: Pause,
        /// No message will come any more.
        stalled: Rc<Cell<bool>>,
    },
}

impl Waiter {
    pub(super) fn new(words: &Rc<Shared<RunWords>>, topic: Topic) -> Self {
        Self(Way::Futex { words: Rc::clone(words), topic })
    }

    /// Waits in a run in one process. `stalled` is set when no message will come any more.
    pub(crate) fn in_process(pause: Pause, stalled: Rc<Cell<bool>>) -> Self {
        Self(Way::InProcess { pause, stalled })
    }

    /// To be taken before looking for a sample.
    pub fn ticket(&self) -> Ticket {
        match &self.0 {
            Way::Futex { words, topic } => Ticket(words.wake(*topic).load(Ordering::Acquire)),
            Way::InProcess { .. } => Ticket(0),
        }
    }

    /// Waits until a sender woke the topic's waiters since `ticket` was taken, at most for `timeout`. A signal ends the
    /// wait early, and so does another service's wait in this thread.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn wait(&self, ticket: Ticket, timeout: Duration) -> io::Result<()> {
        match &self.0 {
            Way::Futex { words, topic } => wait_word(words.wake(*topic), ticket.0, timeout),
            Way::InProcess { pause, .. } => {
                pause.wait();
                Ok(())
            }
        }
    }

    /// True if a wait is another service's turn in this thread.
    pub(crate) fn is_in_process(&self) -> bool {
        matches!(self.0, Way::InProcess { .. })
    }

    /// True if waiting longer is of no use.
    pub(crate) fn is_in_vain(&self) -> bool {
        matches!(&self.0, Way::InProcess { stalled, .. } if stalled.get())
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

        fn words(&self) -> Rc<Shared<RunWords>> {
            Rc::new(RunWords::map(&self.0).expect("shared memory"))
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
        let waiter = Waiter::new(&ours, Topic::Command);
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
        let waiter = Waiter::new(&words, Topic::Command);
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
            let (waker, waiter) = (Waker::new(&words, wake), Waiter::new(&words, wait));
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
