//! Members of the group: which process is which restart of which service, and which processes only listen.
//!
//! The launcher enters every process that it starts, and itself, in the words that the run's processes share. A
//! consumer looks up the sender of each message. In lockstep a sender looks a listener up before it waits for it. A
//! process of the same user that opens a topic on its own is not a member. Its messages are not used, and no sender
//! waits for it.

use crate::RuntimeError;
use crate::words::{KNOWN, RunWords, Shared};
use messages::Service;
use std::path::Path;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Enters process `pid` as restart `incarnation` of `service` of the run whose shared memory has this prefix.
pub fn enroll(
    prefix: &str,
    service: Service,
    incarnation: u32,
    pid: u32,
) -> Result<(), RuntimeError> {
    let words = map(prefix)?;
    let of = words.of(service);
    let place = free_place(&of.processes);
    of.ends[place].store(0, Ordering::Relaxed);
    of.processes[place].store(process(incarnation, pid), Ordering::Release);
    Ok(())
}

/// Enters process `pid` as one that listens to the run: in lockstep senders wait for it.
pub fn enroll_listener(prefix: &str, pid: u32) -> Result<(), RuntimeError> {
    let listeners = &map(prefix)?.listeners;
    listeners[free_place(listeners)].store(process(0, pid), Ordering::Release);
    Ok(())
}

fn map(prefix: &str) -> Result<Shared<RunWords>, RuntimeError> {
    RunWords::map(prefix).map_err(RuntimeError::setup("the list of members in shared memory"))
}

/// A process as the words have it; 0 is a free place.
fn process(incarnation: u32, pid: u32) -> u64 {
    u64::from(incarnation) << 32 | u64::from(pid)
}

/// A free place, or that of the oldest process that is gone.
fn free_place(known: &[AtomicU64; KNOWN]) -> usize {
    let is_gone = |place: &usize| {
        let pid = known[*place].load(Ordering::Relaxed) as u32;
        !Path::new("/proc").join(pid.to_string()).exists()
    };
    let gone = (0..KNOWN).filter(is_gone);
    gone.min_by_key(|&place| known[place].load(Ordering::Relaxed)).unwrap_or(0)
}

impl RunWords {
    /// True if process `pid` is restart `incarnation` of the service with number `source`.
    pub(crate) fn is_member(&self, source: u32, incarnation: u32, pid: u32) -> bool {
        let sought = process(incarnation, pid);
        Service::by_number(source).is_some_and(|service| {
            self.of(service).processes.iter().any(|known| known.load(Ordering::Acquire) == sought)
        })
    }

    /// The word in which the kernel marks the end of restart `incarnation` of `service`.
    pub(crate) fn end(&self, service: Service, incarnation: u32) -> &AtomicU32 {
        let of = self.of(service);
        let is_it = |known: &AtomicU64| {
            let known = known.load(Ordering::Acquire);
            known != 0 && known >> 32 == u64::from(incarnation)
        };
        let place = of.processes.iter().position(is_it);
        &of.ends[place.unwrap_or(incarnation as usize % KNOWN)]
    }

    /// True if process `pid` is any service of the group, or one of its listeners.
    pub(crate) fn is_in_group(&self, pid: u32) -> bool {
        let services = Service::ALL.into_iter().flat_map(|service| &self.of(service).processes);
        services.chain(&self.listeners).any(|known| known.load(Ordering::Acquire) as u32 == pid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_processes_that_were_entered_are_members() {
        let prefix = format!("timegap_members-{}_", std::process::id());
        let members = map(&prefix).expect("shared memory");
        assert!(!members.is_member(4, 0, 17), "nothing was entered yet");
        // As many as a long run with many restarts has; this test itself is one that lives.
        let living = std::process::id();
        enroll(&prefix, Service::Plant, 0, living).expect("ours");
        enroll(&prefix, Service::Controller, 0, living).expect("ours");
        let gone = 0x4000_0000;
        for k in 1..10_000 {
            enroll(&prefix, Service::Controller, k, gone + k).expect("ours");
        }
        assert!(members.is_member(1, 0, living), "it lives");
        assert!(members.is_member(4, 0, living), "it lives beside many that are gone");
        assert!(members.is_member(4, 9_999, gone + 9_999), "it was there until just now");
        assert!(members.is_member(4, 9_990, gone + 9_990));
        assert!(!members.is_member(4, 9_950, gone + 9_950), "others have its place");
        assert!(!members.is_member(4, 9_998, gone + 9_999) && !members.is_member(1, 0, gone));
        assert!(!members.is_member(4, 10_000, gone + 10_000));
        assert!(!members.is_member(99, 0, living), "no service has the number");
        enroll_listener(&prefix, gone + 77).expect("ours");
        assert!(members.is_in_group(gone + 77) && members.is_in_group(gone + 9_999));
        assert!(!members.is_in_group(gone + 10_078) && !members.is_in_group(7));
        assert!((0..8).all(|source| !members.is_member(source, 0, gone + 77)), "it sends nothing");
        std::fs::remove_file(format!("/dev/shm/{prefix}wake")).expect("ours");
    }
}
