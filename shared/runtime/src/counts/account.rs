//! The account of one process: its counts so far, in shared memory that outlives it. A process that dies cannot report,
//! and its messages were sent all the same.
//!
//! The service writes the account at the end of each cycle (some hundred stores, no system call). The launcher reads it
//! when the process is gone without a report.

#![allow(unsafe_code, reason = "a struct of atomic numbers in shared memory")]

use super::{ACCOUNTS, State};
use crate::faults::{FaultStatistics, Faults};
use crate::ports::Counted;
use crate::report::{ReceivedTopic, SentTopic};
use crate::words::{Atomics, Shared};
use bytemuck::{Pod, Zeroable};
use messages::TOPICS;
use messages::e2e::Outcomes;
use scenario::faults::MAX_FAULTS;
use std::fs::File;
use std::io;
use std::mem::offset_of;
use std::sync::atomic::{AtomicU64, Ordering};

#[repr(C, align(4096))]
#[derive(Debug)]
pub(super) struct Account {
    /// Incarnation of the process, counted from 1; 0: the account is free.
    owner: AtomicU64,
    /// All cycles, also those of a standby.
    progress: AtomicU64,
    /// [`Sums`], word by word.
    sums: [AtomicU64; size_of::<Sums>() / 8],
}

// SAFETY: words alone.
unsafe impl Atomics for Account {}

/// The counts of a process.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sums {
    cycles: u64,
    skipped: u64,
    topics: [OfTopic; TOPICS.len()],
    faults: [OfFault; 2 * MAX_FAULTS],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct OfTopic {
    /// 1 if the process sends on the topic, or receives from it.
    sends: u64,
    receives: u64,
    sent: u64,
    received: u64,
    lost: u64,
    e2e: Outcomes,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct OfFault {
    /// Number, counted from 1; 0 marks the end of the faults.
    number: u64,
    begun_ns: i64,
    messages: u64,
    undetected: u64,
}

/// Counts of a process when it died.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LastAccount {
    /// Cycles run.
    pub cycles: u64,
    /// Releases left out.
    pub skipped: u64,
    /// Topics published.
    pub sent: Vec<SentTopic>,
    /// Topics received.
    pub received: Vec<ReceivedTopic>,
    /// Effects of faults on the messages of its ports.
    pub faults: Vec<FaultStatistics>,
}

/// The number by which process `incarnation` owns its account.
fn owner(incarnation: u32) -> u64 {
    u64::from(incarnation) + 1
}

fn map(file: &File, incarnation: u32) -> io::Result<Shared<Account>> {
    let place = incarnation as usize % ACCOUNTS;
    Shared::of(file, offset_of!(State, accounts) + place * size_of::<Account>())
}

impl Account {
    /// The account of process `incarnation`; `None` if it has none.
    pub(super) fn of(file: &File, incarnation: u32) -> Option<Shared<Self>> {
        let account = map(file, incarnation).ok()?;
        let owns = account.owner.load(Ordering::Acquire) == owner(incarnation);
        owns.then_some(account)
    }

    /// Reads the account and frees its place.
    pub(super) fn take(&self) -> LastAccount {
        let mut sums = Sums::zeroed();
        for (number, word) in words(&mut sums).iter_mut().zip(&self.sums) {
            *number = word.load(Ordering::Relaxed);
        }
        self.owner.store(0, Ordering::Release);
        let topics = || TOPICS.into_iter().map(|topic| (topic, sums.topics[topic as usize]));
        let sends = topics().filter(|(_, of)| of.sends > 0);
        let receives = topics().filter(|(_, of)| of.receives > 0);
        let faults = sums.faults.iter().map_while(|of| {
            let fault = u32::try_from(of.number.checked_sub(1)?).ok()?;
            let OfFault { begun_ns, messages, undetected, .. } = *of;
            Some(FaultStatistics { fault, begun_ns, messages, undetected })
        });
        let sent = |topic: messages::Topic, sent| SentTopic {
            topic: topic.name().into(),
            sent,
            digest: None,
        };
        LastAccount {
            cycles: sums.cycles,
            skipped: sums.skipped,
            sent: sends.map(|(topic, of)| sent(topic, of.sent)).collect(),
            received: receives
                .map(|(topic, OfTopic { received, lost, e2e, .. })| ReceivedTopic {
                    topic: topic.name().into(),
                    received,
                    lost,
                    e2e,
                })
                .collect(),
            faults: faults.collect(),
        }
    }
}

fn words(sums: &mut Sums) -> &mut [u64] {
    bytemuck::cast_slice_mut(std::slice::from_mut(sums))
}

/// The account as its process writes it.
#[derive(Debug)]
pub(crate) struct OwnAccount {
    account: Shared<Account>,
    sums: Box<Sums>,
}

impl OwnAccount {
    /// Begins the account of process `incarnation`. Its place may have been another process's, long ago.
    pub(super) fn begin(file: &File, incarnation: u32) -> io::Result<Self> {
        let mut this = Self { account: map(file, incarnation)?, sums: Box::new(Sums::zeroed()) };
        this.show_progress(0);
        this.put();
        this.account.owner.store(owner(incarnation), Ordering::Release);
        Ok(this)
    }

    /// Shows that another cycle is done: the `cycles`th of this process.
    pub(crate) fn show_progress(&self, cycles: u64) {
        self.account.progress.store(cycles, Ordering::Relaxed);
    }

    /// Writes what was counted so far, and what faults of messages did.
    pub(crate) fn write(
        &mut self,
        (cycles, skipped): (u64, u64),
        (sent, received): (&[Counted], &[Counted]),
        faults: &Faults,
    ) {
        let sums = &mut *self.sums;
        (sums.cycles, sums.skipped) = (cycles, skipped);
        for (topic, tally) in sent {
            let of = &mut sums.topics[*topic as usize];
            (of.sends, of.sent) = (1, tally.borrow().messages);
        }
        for (topic, tally) in received {
            let (of, tally) = (&mut sums.topics[*topic as usize], tally.borrow());
            of.receives = 1;
            (of.received, of.lost, of.e2e) = (tally.messages, tally.lost, tally.e2e);
        }
        let mut places = sums.faults.iter_mut();
        faults.each_statistics(|FaultStatistics { fault, begun_ns, messages, undetected }| {
            if let Some(place) = places.next() {
                *place = OfFault { number: u64::from(fault) + 1, begun_ns, messages, undetected };
            }
        });
        self.put();
    }

    fn put(&mut self) {
        for (word, number) in self.account.sums.iter().zip(words(&mut self.sums)) {
            word.store(*number, Ordering::Relaxed);
        }
    }
}

/// The progress of a process, as another one sees it.
#[derive(Debug)]
pub struct Progress(Shared<Account>);

impl Progress {
    /// The progress that `account` shows.
    pub(super) fn of(account: Shared<Account>) -> Self {
        Self(account)
    }

    /// Cycles that it has done, silent ones included.
    pub fn cycles(&self) -> u64 {
        self.0.progress.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::ServiceCounts;
    use crate::counts::tests::Run;
    use crate::ports::Tally;
    use messages::{Service, Topic};
    use scenario::Scenario;

    fn begin(run: &Run, incarnation: u32) -> ServiceCounts {
        let mut counts = ServiceCounts::open(&run.0, Service::Plant).expect("shared memory");
        counts.begin_account(incarnation).expect("shared memory");
        counts
    }

    fn no_faults() -> Faults {
        Faults::of(&Scenario::parse("x", "schema_version = 1\nname = \"x\"").expect("right"), None)
    }

    #[test]
    fn an_account_outlives_its_process_and_is_taken_once() {
        let run = Run::new("account");
        let tally = || {
            let tally = std::rc::Rc::<std::cell::RefCell<Tally>>::default();
            tally.borrow_mut().messages = 7;
            tally.borrow_mut().e2e.unknown_sender = 3;
            tally
        };
        let mut counts = begin(&run, 2);
        let account = counts.account().expect("it has begun");
        let (sent, received) = ([(Topic::Odometry, tally())], [(Topic::Command, tally())]);
        account.write((5, 1), (&sent, &received), &no_faults());
        drop(counts);
        let reader = ServiceCounts::of(&run.0, Service::Plant);
        let last = reader.take_account(2).expect("it is there");
        assert_eq!((last.cycles, last.skipped, last.faults), (5, 1, Vec::new()));
        assert_eq!((last.sent.len(), last.sent[0].sent), (1, 7));
        assert_eq!((last.received[0].received, last.received[0].e2e.unknown_sender), (7, 3));
        assert_eq!(reader.take_account(2), None);
    }

    #[test]
    fn the_active_process_and_its_standby_have_accounts_of_their_own() {
        let run = Run::new("two-accounts");
        let (mut active, mut standby) = (begin(&run, 0), begin(&run, 1));
        active.account().expect("it has begun").write((5, 0), (&[], &[]), &no_faults());
        standby.account().expect("it has begun").show_progress(4);
        let reader = ServiceCounts::of(&run.0, Service::Plant);
        assert_eq!(reader.progress(1).map(|progress| progress.cycles()), Some(4));
        assert!(reader.progress(2).is_none(), "no such process");
        assert_eq!(reader.take_account(0).map(|last| last.cycles), Some(5));
        assert_eq!(reader.take_account(1).map(|last| last.cycles), Some(0));
    }

    #[test]
    fn a_page_that_a_later_process_takes_begins_anew() {
        let run = Run::new("account-again");
        for incarnation in 0..40 {
            let mut counts = begin(&run, incarnation);
            let reader = ServiceCounts::of(&run.0, Service::Plant);
            let progress = reader.progress(incarnation).expect("it has begun");
            assert_eq!(progress.cycles(), 0);
            counts.account().expect("it has begun").show_progress(9);
            assert_eq!(progress.cycles(), 9);
        }
        let reader = ServiceCounts::of(&run.0, Service::Plant);
        assert!(reader.take_account(3).is_none(), "another process has its page");
        assert!(ServiceCounts::of(&run.0, Service::Controller).take_account(0).is_none());
    }
}
