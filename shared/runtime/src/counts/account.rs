//! What a service has counted so far, in a page of shared memory that outlives it: a process that dies
//! cannot report, and its messages were sent all the same.
//!
//! The service writes the page at the end of each cycle (some hundred stores, no system call), the
//! launcher reads it when the process is gone without a report.

use crate::faults::{FaultStatistics, Faults};
use crate::ports::Counted;
use crate::report::{ReceivedTopic, SentTopic};
use crate::words::SharedWords;
use crate::{Group, RuntimeError};
use messages::e2e::Outcomes;
use messages::{Service, TOPICS, Topic};
use std::path::Path;
use std::sync::atomic::Ordering;

/// Words for the cycles, the skipped releases and the progress, before those of the topics.
const HEAD: usize = 16;
/// The word that counts all cycles, also those of a standby.
const PROGRESS: usize = 2;
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

fn name(prefix: &str, service: Service, incarnation: u32) -> String {
    format!("{prefix}{service}.{incarnation}.account")
}

impl Account {
    /// Opens the page of a process.
    pub(crate) fn open(
        group: &Group,
        service: Service,
        incarnation: u32,
    ) -> Result<Self, RuntimeError> {
        SharedWords::map(&name(&group.prefix, service, incarnation))
            .map(Self)
            .map_err(RuntimeError::setup("the account in shared memory"))
    }

    /// Shows that another cycle is done: the `cycles`th of this process.
    pub(crate) fn show_progress(&self, cycles: u64) {
        self.put(PROGRESS, cycles);
    }

    /// Writes what was counted so far.
    pub(crate) fn write(&self, cycles: u64, skipped: u64, sent: &[Counted], received: &[Counted]) {
        self.put(0, cycles);
        self.put(1, skipped);
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
            cycles: count(0),
            skipped: count(1),
            sent: with(SENDS).map(sent).collect(),
            received: with(RECEIVES).map(received).collect(),
        }
    }
}

/// The page of another process; `None` if it is gone: the page of an ended process is not made again.
pub(crate) fn page(group: &Group, service: Service, incarnation: u32) -> Option<SharedWords> {
    SharedWords::map_existing(&name(&group.prefix, service, incarnation)).ok()
}

/// Cycles that the process with this page has done, silent ones included; they wrap at 2³².
pub(crate) fn progress(page: &SharedWords) -> u32 {
    page.word(PROGRESS).load(Ordering::Relaxed)
}

/// The progress of a process, as another one sees it.
#[derive(Debug)]
pub struct Progress(SharedWords);

impl Progress {
    /// The progress of process `incarnation` of `service`; `None` if it keeps no account.
    #[must_use]
    pub fn of(group: &Group, service: Service, incarnation: u32) -> Option<Self> {
        page(group, service, incarnation).map(Self)
    }

    /// Cycles that it has done, silent ones included; they wrap at 2³².
    #[must_use]
    pub fn cycles(&self) -> u32 {
        progress(&self.0)
    }
}

/// First word of a topic.
fn place(topic: Topic) -> usize {
    HEAD + topic as usize * STRIDE
}

/// The counts of process `incarnation` of `service`, which is gone; `None` if it kept no account.
/// The page is removed.
#[must_use]
pub fn take_account(group: &Group, service: Service, incarnation: u32) -> Option<LastAccount> {
    let name = name(&group.prefix, service, incarnation);
    let path = Path::new("/dev/shm").join(&name);
    if !path.exists() {
        return None;
    }
    let account = SharedWords::map(&name).ok().map(|words| Account(words).read());
    // The run's clean-up takes what is left here.
    let _ = std::fs::remove_file(path);
    account
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ports::Tally;
    use crate::{Mode, Timetable};

    #[test]
    fn an_account_outlives_its_process_and_is_taken_once() {
        let group = Group {
            root: "/tmp".into(),
            prefix: format!("timegap_account-{}_", std::process::id()),
            mode: Mode::Realtime,
            standby: Vec::new(),
            timetable: Timetable { step_ns: 1, strides: [1; Service::ALL.len()], last_step: 1 },
            patience_ns: 1,
            scenario: Vec::new(),
        };
        let tally = || {
            let tally = Tally::of_receiver();
            tally.borrow_mut().messages = 7;
            tally.borrow_mut().e2e.unknown_sender = 3;
            tally
        };
        let account = Account::open(&group, Service::Plant, 2).expect("shared memory");
        account.write(5, 1, &[(Topic::Odometry, tally())], &[(Topic::Command, tally())]);
        drop(account);
        let last = take_account(&group, Service::Plant, 2).expect("it is there");
        assert_eq!((last.cycles, last.skipped, last.faults), (5, 1, Vec::new()));
        assert_eq!((last.sent.len(), last.sent[0].sent), (1, 7));
        assert_eq!((last.received[0].received, last.received[0].e2e.unknown_sender), (7, 3));
        assert_eq!(take_account(&group, Service::Plant, 2), None);
    }
}
