//! The account of one process: its counts so far, in shared memory that outlives it. A process that dies cannot report,
//! and its messages were sent all the same.
//!
//! The service keeps the account at the end of each cycle, as a [`Checkpoint`] keeps a state. The launcher takes it when
//! the process is gone without a report.

use crate::faults::{FaultStatistics, Faults};
use crate::ports::{Opened, Ports};
use crate::report::{ReceivedTopic, SentTopic};
use crate::survival::checkpoint::Checkpoint;
use crate::transport::{Receiver, Sender};
use crate::{Group, RuntimeError};
use messages::Service;
use scenario::faults::MAX_FAULTS;
use serde::{Deserialize, Serialize, Serializer};
use std::path::{Path, PathBuf};

/// Counts of a process when it died.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct LastAccount {
    pub cycles: u64,
    /// Releases left out.
    pub skipped: u64,
    pub sent: Vec<SentTopic>,
    pub received: Vec<ReceivedTopic>,
    /// Effects of faults on the messages of its ports.
    pub faults: Vec<FaultStatistics>,
}

impl LastAccount {
    /// The account of a process that is gone, once; `None` if it kept no account.
    #[must_use]
    pub fn take(group: &Group, service: Service, incarnation: u32) -> Option<Self> {
        let path = path(group, service, incarnation);
        let last = Checkpoint::existing(&path)?.restore();
        // The rest goes with the run.
        let _ = std::fs::remove_file(path);
        last
    }
}

fn path(group: &Group, service: Service, incarnation: u32) -> PathBuf {
    Path::new("/dev/shm").join(format!("{}{service}.{incarnation}.account", group.prefix))
}

/// A [`LastAccount`] as it is written: what the ports count.
#[derive(Serialize)]
struct Counts<'a> {
    cycles: u64,
    skipped: u64,
    #[serde(serialize_with = "sent")]
    sent: &'a [Opened<Sender>],
    #[serde(serialize_with = "received")]
    received: &'a [Opened<Receiver>],
    faults: &'a [FaultStatistics],
}

fn sent<S: Serializer>(ports: &&[Opened<Sender>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(ports.iter().map(|end| {
        let digest: Option<String> = None;
        (end.topic.name(), end.tally.borrow().messages, digest)
    }))
}

fn received<S: Serializer>(ports: &&[Opened<Receiver>], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(ports.iter().map(|end| {
        let tally = end.tally.borrow();
        (end.topic.name(), tally.messages, tally.lost, tally.e2e)
    }))
}

/// The account as its process writes it.
#[derive(Debug)]
pub(crate) struct OwnAccount {
    checkpoint: Checkpoint<LastAccount>,
    faults: Vec<FaultStatistics>,
}

impl OwnAccount {
    pub(crate) fn begin(
        group: &Group,
        service: Service,
        incarnation: u32,
    ) -> Result<Self, RuntimeError> {
        let checkpoint = Checkpoint::open(&path(group, service, incarnation))?;
        Ok(Self { checkpoint, faults: Vec::with_capacity(2 * MAX_FAULTS) })
    }

    /// Writes what was counted so far, and what faults of messages did.
    pub(crate) fn write(
        &mut self,
        (cycles, skipped): (u64, u64),
        ports: &Ports,
        faults: &Faults,
    ) -> Result<(), RuntimeError> {
        self.faults.clear();
        faults.statistics(&mut self.faults);
        let (sent, received, faults) = (&*ports.senders, &*ports.receivers, &*self.faults);
        self.checkpoint.save(&Counts { cycles, skipped, sent, received, faults })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::tests::Run;
    use crate::life::link::End;
    use crate::ports::Tally;
    use crate::transport::{Bus, Sealing, Seat, Transport, Wanted};
    use messages::Topic;
    use scenario::Scenario;
    use std::cell::RefCell;
    use std::rc::Rc;

    fn ports(run: &Run) -> Ports {
        let bus = Rc::new(Bus::new(&run.0.timetable, Sealing::Sealed));
        Ports::new(Transport::Memory(Seat::new(bus, None)))
    }

    fn begin(run: &Run, incarnation: u32) -> OwnAccount {
        OwnAccount::begin(&run.0, Service::Plant, incarnation).expect("shared memory")
    }

    fn take(run: &Run, incarnation: u32) -> Option<LastAccount> {
        LastAccount::take(&run.0, Service::Plant, incarnation)
    }

    fn faults(keys: &str) -> Faults {
        let text = format!("schema_version = 1\nname = \"x\"\n{keys}");
        Faults::of(&Scenario::parse("x", &text).expect("right"), None)
    }

    #[test]
    fn an_account_outlives_its_process_and_is_taken_once() {
        let run = Run::new("account");
        let tally = || {
            let tally = Rc::<RefCell<Tally>>::default();
            tally.borrow_mut().messages = 7;
            tally.borrow_mut().lost = 2;
            tally.borrow_mut().e2e.unknown_sender = 3;
            tally
        };
        let mut account = begin(&run, 2);
        let mut ports = ports(&run);
        let port = ports.transport.sender(Topic::Odometry, End::default()).expect("memory");
        ports.senders.push(Opened { topic: Topic::Odometry, port, tally: tally() });
        let port = ports.transport.receiver(Topic::Command, Wanted::Every).expect("memory");
        ports.receivers.push(Opened { topic: Topic::Command, port, tally: tally() });
        let faults = faults("[[faults]]\nkind = \"drop\"\ntopic = \"control/command\"\n");
        let activated = scenario::faults::Effect::of_channels;
        faults.activate(activated, Topic::Command, (4, 0, 1), 9, |_, _| {});
        account.write((5, 1), &ports, &faults).expect("there is room");
        drop(account);
        let last = take(&run, 2).expect("it is there");
        assert_eq!((last.cycles, last.skipped), (5, 1));
        assert_eq!((last.sent.len(), last.sent[0].sent), (1, 7));
        assert_eq!((&*last.sent[0].topic, &last.sent[0].digest), ("vehicle/odometry", &None));
        assert_eq!((last.received[0].received, last.received[0].lost), (7, 2));
        assert_eq!(last.received[0].e2e.unknown_sender, 3);
        let mut found = Vec::new();
        faults.statistics(&mut found);
        assert_eq!((last.faults.len(), last.faults), (1, found));
        assert_eq!(take(&run, 2), None);
    }

    #[test]
    fn the_active_process_and_its_standby_have_accounts_of_their_own() {
        let run = Run::new("two-accounts");
        let (mut active, standby) = (begin(&run, 0), begin(&run, 1));
        for cycles in [5, 6] {
            active.write((cycles, 0), &ports(&run), &faults("")).expect("there is room");
        }
        drop(standby);
        assert_eq!(take(&run, 0).map(|last| last.cycles), Some(6));
        assert_eq!(take(&run, 1), None, "it wrote nothing");
        assert_eq!(take(&run, 2), None, "no such process");
    }
}
