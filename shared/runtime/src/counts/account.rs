//! The account of one process: its counts so far, on a page of shared memory that outlives it. A process that dies
//! cannot report, and its messages were sent all the same.
//!
//! The service writes the page at the end of each cycle (some hundred stores, no system call). The launcher reads it
//! when the process is gone without a report.

use super::file::CountsFile;
use crate::RuntimeError;
use crate::faults::{FaultStatistics, Faults};
use crate::ports::Counted;
use crate::report::{ReceivedTopic, SentTopic};
use crate::words::SharedWords;
use messages::e2e::Outcomes;
use messages::{TOPICS, Topic};
use std::sync::atomic::Ordering;

/// Words before those of the topics.
const HEAD: usize = 16;
/// Cycles run, and releases left out.
const CYCLES: usize = 0;
const SKIPPED: usize = 1;
/// All cycles, also those of a standby.
const PROGRESS: usize = 2;
/// Incarnation of the page's process, counted from 1; 0: the page is free.
const OWNER: usize = 3;
/// Words of a topic.
const STRIDE: usize = 16;
/// Bits of a topic's first word.
const SENDS: u32 = 1;
const RECEIVES: u32 = 2;

/// First word of the faults, words of each, and how many there is room for.
const FAULTS: usize = HEAD + TOPICS.len() * STRIDE;
const FAULT_STRIDE: usize = 5;
const MOST_FAULTS: usize = (crate::words::WORDS - FAULTS) / FAULT_STRIDE;

const _: () = assert!(MOST_FAULTS >= 2 * scenario::faults::MAX_FAULTS);

/// The page of one process.
#[derive(Debug)]
pub(crate) struct Account(SharedWords);

/// The word by which process `incarnation` owns its page.
fn owner(incarnation: u32) -> u32 {
    incarnation.wrapping_add(1)
}

/// Counts of a process when it died. They wrap at 2³².
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

impl Account {
    /// Begins the account of process `incarnation`. Its page may have been another process's, long ago.
    pub(super) fn begin(file: &CountsFile, incarnation: u32) -> Result<Self, RuntimeError> {
        let setup = RuntimeError::setup("the account in shared memory");
        let page = file.account(incarnation).map_err(setup)?;
        for index in 0..crate::words::WORDS {
            page.word(index).store(0, Ordering::Relaxed);
        }
        page.word(OWNER).store(owner(incarnation), Ordering::Release);
        Ok(Self(page))
    }

    /// The account of process `incarnation`; `None` if it has none.
    pub(super) fn of(file: &CountsFile, incarnation: u32) -> Option<Self> {
        let page = file.account(incarnation).ok()?;
        let owns = page.word(OWNER).load(Ordering::Acquire) == owner(incarnation);
        owns.then_some(Self(page))
    }

    /// Reads the account and frees its page.
    pub(super) fn take(self) -> LastAccount {
        let last = self.read();
        self.0.word(OWNER).store(0, Ordering::Release);
        last
    }

    /// Shows that another cycle is done: the `cycles`th of this process.
    pub(crate) fn show_progress(&self, cycles: u64) {
        self.put(PROGRESS, cycles);
    }

    /// Writes what was counted so far.
    pub(crate) fn write(&self, cycles: u64, skipped: u64, sent: &[Counted], received: &[Counted]) {
        self.put(CYCLES, cycles);
        self.put(SKIPPED, skipped);
        for (topic, tally) in sent {
            let place = place(*topic);
            self.0.word(place).fetch_or(SENDS, Ordering::Relaxed);
            self.put(place + 1, tally.borrow().messages);
        }
        for (topic, tally) in received {
            let (place, tally) = (place(*topic), tally.borrow());
            self.0.word(place).fetch_or(RECEIVES, Ordering::Relaxed);
            self.put(place + 2, tally.messages);
            self.put(place + 3, tally.lost);
            let outcomes = [
                tally.e2e.ok,
                tally.e2e.ok_some_lost,
                tally.e2e.repeated,
                tally.e2e.wrong_sequence,
                tally.e2e.error,
                tally.e2e.no_new_data,
                tally.e2e.unknown_sender,
                tally.e2e.from_the_future,
                tally.e2e.distrusted,
            ];
            for (index, count) in outcomes.into_iter().enumerate() {
                self.put(place + 4 + index, count);
            }
        }
    }

    /// Writes what faults of messages did so far.
    pub(crate) fn write_faults(&self, faults: &Faults) {
        let mut place = FAULTS;
        faults.each_statistics(|one| {
            if place + FAULT_STRIDE > FAULTS + MOST_FAULTS * FAULT_STRIDE {
                return;
            }
            let begun_ns = one.begun_ns.unsigned_abs();
            self.put(place + 1, begun_ns & u64::from(u32::MAX));
            self.put(place + 2, begun_ns >> 32);
            self.put(place + 3, one.messages);
            self.put(place + 4, one.undetected);
            // 0 marks the end of the faults.
            self.put(place, u64::from(one.fault) + 1);
            place += FAULT_STRIDE;
        });
    }

    fn put(&self, index: usize, count: u64) {
        self.0.word(index).store(count as u32, Ordering::Relaxed);
    }

    fn read(&self) -> LastAccount {
        let count = |index: usize| u64::from(self.0.word(index).load(Ordering::Relaxed));
        let with = |bit: u32| {
            TOPICS.into_iter().filter(move |&topic| count(place(topic)) & u64::from(bit) != 0)
        };
        let sent = |topic: Topic| SentTopic {
            topic: topic.name().into(),
            sent: count(place(topic) + 1),
            digest: None,
        };
        let received = |topic: Topic| {
            let outcome = |index: usize| count(place(topic) + 4 + index);
            ReceivedTopic {
                topic: topic.name().into(),
                received: count(place(topic) + 2),
                lost: count(place(topic) + 3),
                e2e: Outcomes {
                    ok: outcome(0),
                    ok_some_lost: outcome(1),
                    repeated: outcome(2),
                    wrong_sequence: outcome(3),
                    error: outcome(4),
                    no_new_data: outcome(5),
                    unknown_sender: outcome(6),
                    from_the_future: outcome(7),
                    distrusted: outcome(8),
                },
            }
        };
        let fault = |place: usize| {
            Some(FaultStatistics {
                fault: u32::try_from(count(place).checked_sub(1)?).ok()?,
                begun_ns: i64::try_from(count(place + 1) | (count(place + 2) << 32)).ok()?,
                messages: count(place + 3),
                undetected: count(place + 4),
            })
        };
        LastAccount {
            faults: (0..MOST_FAULTS).map_while(|i| fault(FAULTS + i * FAULT_STRIDE)).collect(),
            cycles: count(CYCLES),
            skipped: count(SKIPPED),
            sent: with(SENDS).map(sent).collect(),
            received: with(RECEIVES).map(received).collect(),
        }
    }
}

/// The progress of a process, as another one sees it.
#[derive(Debug)]
pub struct Progress(SharedWords);

impl Progress {
    /// The progress that `account` shows.
    pub(super) fn of(account: Account) -> Self {
        Self(account.0)
    }

    /// Cycles that it has done, silent ones included; they wrap at 2³².
    #[must_use]
    pub fn cycles(&self) -> u32 {
        self.0.word(PROGRESS).load(Ordering::Relaxed)
    }
}

/// First word of a topic.
fn place(topic: Topic) -> usize {
    HEAD + topic as usize * STRIDE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::file::tests::Run;
    use crate::counts::own::Counts;
    use crate::counts::reader::CountsReader;
    use crate::ports::Tally;
    use messages::Service;

    fn begin(run: &Run, incarnation: u32) -> Counts {
        let mut counts = Counts::open(&run.0, Service::Plant).expect("shared memory");
        counts.begin_account(incarnation).expect("shared memory");
        counts
    }

    #[test]
    fn an_account_outlives_its_process_and_is_taken_once() {
        let run = Run::new("account");
        let tally = || {
            let tally = Tally::of_receiver();
            tally.borrow_mut().messages = 7;
            tally.borrow_mut().e2e.unknown_sender = 3;
            tally
        };
        let counts = begin(&run, 2);
        let account = counts.account().expect("it has begun");
        account.write(5, 1, &[(Topic::Odometry, tally())], &[(Topic::Command, tally())]);
        drop(counts);
        let reader = CountsReader::of(&run.0, Service::Plant);
        let last = reader.take_account(2).expect("it is there");
        assert_eq!((last.cycles, last.skipped, last.faults), (5, 1, Vec::new()));
        assert_eq!((last.sent.len(), last.sent[0].sent), (1, 7));
        assert_eq!((last.received[0].received, last.received[0].e2e.unknown_sender), (7, 3));
        assert_eq!(reader.take_account(2), None);
    }

    #[test]
    fn the_active_process_and_its_standby_have_accounts_of_their_own() {
        let run = Run::new("two-accounts");
        let (active, standby) = (begin(&run, 0), begin(&run, 1));
        active.account().expect("it has begun").write(5, 0, &[], &[]);
        standby.account().expect("it has begun").show_progress(4);
        let reader = CountsReader::of(&run.0, Service::Plant);
        assert_eq!(reader.progress(1).map(|progress| progress.cycles()), Some(4));
        assert!(reader.progress(2).is_none(), "no such process");
        assert_eq!(reader.take_account(0).map(|last| last.cycles), Some(5));
        assert_eq!(reader.take_account(1).map(|last| last.cycles), Some(0));
    }

    #[test]
    fn a_page_that_a_later_process_takes_begins_anew() {
        let run = Run::new("account-again");
        for incarnation in 0..40 {
            let counts = begin(&run, incarnation);
            let reader = CountsReader::of(&run.0, Service::Plant);
            let progress = reader.progress(incarnation).expect("it has begun");
            assert_eq!(progress.cycles(), 0);
            counts.account().expect("it has begun").show_progress(9);
            assert_eq!(progress.cycles(), 9);
        }
        let reader = CountsReader::of(&run.0, Service::Plant);
        assert!(reader.take_account(3).is_none(), "another process has its page");
        assert!(CountsReader::of(&run.0, Service::Controller).take_account(0).is_none());
    }
}
