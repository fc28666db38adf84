//! A word in shared memory that the kernel marks as soon as a process begins to end.
//!
//! A pidfd shows an end when the kernel has given back the process's memory. That is 1.4 ms after a SIGKILL if 160 MB
//! are locked. The kernel walks a thread's list of robust futexes before that (set_robust_list(2)). It sets a bit in
//! each word that holds the thread's id, and wakes a waiter. A thread that does nothing else keeps one such word for
//! its process, and ends with it alone.

#![allow(unsafe_code, reason = "no crate registers a robust futex that is not a mutex")]

use crate::RuntimeError;
use crate::machine::scheduling::set_fifo_of;
use crate::words::{RunWords, Shared};
use messages::Service;
use rustix::thread::{futex, gettid};
use std::mem::offset_of;
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::sync_channel;

/// A word in which the kernel marks its owner's end; `FUTEX_WAITERS` and `FUTEX_OWNER_DIED` of linux/futex.h.
const WAITERS: u32 = 0x8000_0000;
const OWNER_DIED: u32 = 0x4000_0000;

/// `struct robust_list` of linux/futex.h.
#[repr(C)]
struct Entry {
    next: *const Entry,
}

/// `struct robust_list_head` of linux/futex.h, and the one entry of its list.
#[repr(C)]
struct List {
    head: Entry,
    /// Offset from an entry to its futex, bytes.
    futex_offset: libc::c_long,
    pending: *const Entry,
    entry: Entry,
}

/// Length of `struct robust_list_head`, bytes.
const HEAD_BYTES: usize = offset_of!(List, entry);

/// Lets the kernel mark the end of this process, a service's `incarnation`. A thread of this priority does it; 0 is an
/// ordinary one.
pub(crate) fn announce(
    words: &Arc<Shared<RunWords>>,
    (service, incarnation): (Service, u32),
    priority: u8,
) -> Result<(), RuntimeError> {
    let words = Arc::clone(words);
    let (sender, owned) = sync_channel(1);
    std::thread::Builder::new()
        .name("end".into())
        .stack_size(64 * 1024)
        .spawn(move || {
            set_fifo_of(gettid().as_raw_pid(), priority);
            own(words.end(service, incarnation));
            // The other end waits.
            let _ = sender.send(());
            loop {
                std::thread::park();
            }
        })
        .map_err(RuntimeError::setup("the thread that marks a process's end"))?;
    // The thread does nothing that fails.
    let _ = owned.recv();
    Ok(())
}

/// Makes the calling thread the owner of `word` until its end. The word stays 0 if the kernel does not
/// keep such lists.
fn own(word: &AtomicU32) {
    let list = Box::into_raw(Box::new(List {
        head: Entry { next: ptr::null() },
        futex_offset: 0,
        pending: ptr::null(),
        entry: Entry { next: ptr::null() },
    }));
    // SAFETY: the list is made here and never freed: the kernel reads it at the thread's end. It is a circle of the
    // head and one entry, whose futex is `word`. The list that is replaced is the C library's, of robust mutexes,
    // of which the callers lock none.
    let code = unsafe {
        let (head, entry) = (&raw const (*list).head, &raw const (*list).entry);
        (*list).head.next = entry;
        (*list).entry.next = head;
        let from_entry = ptr::from_ref(word).addr().wrapping_sub(entry.addr());
        (*list).futex_offset = from_entry.cast_signed() as libc::c_long;
        libc::syscall(libc::SYS_set_robust_list, list, HEAD_BYTES)
    };
    let owner = WAITERS | gettid().as_raw_pid().cast_unsigned();
    word.store(if code == 0 { owner } else { 0 }, Ordering::SeqCst);
}

/// Waits for the end of a service's process; false if the process does not announce its end.
pub(crate) fn wait(words: &RunWords, service: Service, incarnation: u32) -> bool {
    let word = words.end(service, incarnation);
    loop {
        let owner = word.load(Ordering::SeqCst);
        if owner == 0 || owner & OWNER_DIED != 0 {
            return owner != 0;
        }
        // The word is read again after every wait.
        let _ = futex::wait(word, futex::Flags::empty(), owner, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::KNOWN;

    /// Maps a page of its own; its name is removed at once.
    fn page() -> Shared<RunWords> {
        let prefix = format!("timegap-test-end-word-{}", gettid().as_raw_pid());
        let words = RunWords::map(&prefix).expect("shared memory");
        std::fs::remove_file(format!("/dev/shm/{prefix}wake")).expect("it is there");
        words
    }

    #[test]
    fn the_kernel_marks_the_word_of_a_thread_that_ends_and_wakes_who_waits() {
        let page = Arc::new(page());
        let (of_owner, of_waiter) = (Arc::clone(&page), Arc::clone(&page));
        let (owned, is_owned) = sync_channel(1);
        let (end, may_end) = sync_channel::<()>(1);
        let owner = std::thread::spawn(move || {
            own(of_owner.end(Service::Controller, 3));
            owned.send(()).expect("the test waits");
            may_end.recv().expect("the test ends it");
        });
        is_owned.recv().expect("it owns the word");
        let waiter = std::thread::spawn(move || wait(&of_waiter, Service::Controller, 3));
        assert_eq!(page.end(Service::Controller, 3).load(Ordering::SeqCst) & OWNER_DIED, 0);
        end.send(()).expect("it waits");
        owner.join().expect("no panic");
        assert!(waiter.join().expect("no panic"), "it waited for the end");
        assert!(wait(&page, Service::Controller, 3), "the end stays told");
    }

    #[test]
    fn without_an_owner_there_is_nothing_to_wait_for_and_words_of_processes_in_a_row_differ() {
        let page = page();
        assert!(!wait(&page, Service::Plant, 0));
        for service in Service::ALL {
            page.of(service).epoch.store(1, Ordering::SeqCst);
            for incarnation in 0..KNOWN as u32 {
                let word = page.end(service, incarnation);
                assert_eq!(word.swap(1, Ordering::SeqCst), 0, "{service:?} {incarnation}");
            }
        }
    }
}
