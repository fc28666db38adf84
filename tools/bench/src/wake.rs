//! The two ends of each way to wake a process.
//!
//! Every wake-up carries the instant before the sender's first action. So a stalled sink is charged for each late
//! wake-up. An end may hold several ways open and use them in turn; equal mechanisms share one.

use super::event::{EventReceiver, EventSender};
use super::payload::{Contents, PayloadReceiver, PayloadSender};
use super::setup::Mechanism;
use super::words::{COUNT, RING, STAMPS};
use group::{Failure, Status};
use messages::Service;
use messages::e2e::profile7;
use messages::{Header, MAX_DETECTIONS, Origins, RadarDetections, RadarTracks};
use runtime::{
    Group, Guest, Publisher, RuntimeError, SharedWords, Subscriber, enroll, monotonic_ns,
};
use rustix::io::Errno;
use rustix::thread::futex;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Longest wait before the sink checks whether the source has ended.
const LOOK: Duration = Duration::from_millis(50);

/// Reason why a wake-up failed.
#[derive(Debug, thiserror::Error)]
pub enum WakeError {
    /// The kernel does not wake the sink.
    #[error("cannot wake: {0}")]
    Wake(#[source] Errno),
    /// The kernel does not let the sink wait.
    #[error("cannot wait: {0}")]
    Wait(#[source] Errno),
    /// A port of ours failed.
    #[error(transparent)]
    Port(#[from] RuntimeError),
    /// iceoryx2 itself, whose errors are names.
    #[error("iceoryx2 cannot {what}: {reason:?}")]
    Iceoryx2 {
        /// Failed operation.
        what: &'static str,
        reason: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A payload cannot be waited for.
    #[error("waiting for a payload: {0}")]
    Waiter(#[source] std::io::Error),
    /// A payload does not pass its check.
    #[error("a payload's {0:?}")]
    Corrupted(profile7::Corrupted),
}

impl Failure for WakeError {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// The error of an operation of iceoryx2.
pub fn failed<E>(what: &'static str) -> impl Fn(E) -> WakeError
where
    E: std::error::Error + Send + Sync + 'static,
{
    move |reason| WakeError::Iceoryx2 { what, reason: Box::new(reason) }
}

/// The sending end.
pub struct Source<'a> {
    page: &'a SharedWords,
    sent: u32,
    ways: Vec<(Mechanism, SourceWay)>,
    /// Dropped after the ports that need it.
    _guest: Option<Guest>,
}

enum SourceWay {
    Futex,
    Eventfd,
    Event(Box<EventSender>),
    Message(Box<Publisher<RadarTracks>>),
    Detections(Box<Publisher<RadarDetections>>),
    Payload(PayloadSender),
}

fn join(root: &Path, name: &str) -> Result<Guest, WakeError> {
    Ok(Guest::join(Group::read(root)?, name)?)
}

fn distinct(mechanisms: &[Mechanism]) -> Vec<Mechanism> {
    let mut distinct = Vec::new();
    for mechanism in mechanisms {
        if !distinct.contains(mechanism) {
            distinct.push(*mechanism);
        }
    }
    distinct
}

/// The guest for mechanisms with our ports.
fn guest(mechanisms: &[Mechanism], root: &Path, name: &str) -> Result<Option<Guest>, WakeError> {
    let ours = |mechanism: &Mechanism| {
        use Mechanism::{Detections, Iceoryx2Event, Message, Payload, ProtectedPayload};
        matches!(mechanism, Iceoryx2Event | Message | Detections | Payload(_) | ProtectedPayload(_))
    };
    if mechanisms.iter().any(ours) { join(root, name).map(Some) } else { Ok(None) }
}

/// Words of the stamp of a wake-up.
fn stamp_words(page: &SharedWords, number: u32) -> [&std::sync::atomic::AtomicU32; 2] {
    let place = STAMPS + number as usize % RING * 2;
    [page.word(place), page.word(place + 1)]
}

impl<'a> Source<'a> {
    /// Opens the sending ends of `mechanisms`.
    pub fn open(
        mechanisms: &[Mechanism],
        root: &Path,
        page: &'a SharedWords,
    ) -> Result<Self, WakeError> {
        let guest = guest(mechanisms, root, "bench-source")?;
        let needed = || guest.as_ref().expect("made for every mechanism with a port");
        // A reader accepts messages of group members only.
        let member = || enroll(root, Service::PerceptionSim, 0, std::process::id());
        let mut ways = Vec::new();
        for mechanism in distinct(mechanisms) {
            let way = match mechanism {
                Mechanism::Futex => SourceWay::Futex,
                Mechanism::Eventfd => SourceWay::Eventfd,
                Mechanism::Iceoryx2Event => {
                    SourceWay::Event(Box::new(EventSender::open(needed())?))
                }
                Mechanism::Message => {
                    member()?;
                    SourceWay::Message(Box::new(needed().publisher(Service::PerceptionSim)?))
                }
                Mechanism::Detections => {
                    member()?;
                    SourceWay::Detections(Box::new(needed().publisher(Service::PerceptionSim)?))
                }
                Mechanism::Payload(bytes) => {
                    SourceWay::Payload(PayloadSender::open(needed(), bytes, Contents::Bare)?)
                }
                Mechanism::ProtectedPayload(bytes) => {
                    SourceWay::Payload(PayloadSender::open(needed(), bytes, Contents::Protected)?)
                }
            };
            ways.push((mechanism, way));
        }
        Ok(Self { page, sent: 0, ways, _guest: guest })
    }

    pub fn wake(&mut self, by: Mechanism) -> Result<(), WakeError> {
        let header = Header::new(self.sent.into(), monotonic_ns(), Origins::NONE);
        match self.ways.iter_mut().find(|(mechanism, _)| *mechanism == by) {
            Some((_, SourceWay::Message(port))) => {
                port.send_with(|message| message.header = header)?;
            }
            Some((_, SourceWay::Detections(port))) => {
                // Like the radar: the message still holds an earlier, valid scan.
                let mut message = port.loan_used()?;
                message.header = header;
                message.count = MAX_DETECTIONS as u64;
                port.send(message)?;
            }
            Some((_, SourceWay::Payload(port))) => port.send()?,
            Some((_, SourceWay::Futex | SourceWay::Eventfd | SourceWay::Event(_))) => {
                let now = monotonic_ns().cast_unsigned();
                let [high, low] = stamp_words(self.page, self.sent);
                high.store((now >> 32) as u32, Ordering::Relaxed);
                low.store(now as u32, Ordering::Relaxed);
                self.sent += 1;
                self.page.word(COUNT).store(self.sent, Ordering::Release);
                return self.ring(by);
            }
            None => unreachable!("every mechanism of the job was opened"),
        }
        Ok(())
    }

    /// Wakes a sink that waits without a timeout, so that it checks for the end.
    pub fn wake_for_the_end(&self, by: Mechanism) -> Result<(), WakeError> {
        self.ring(by)
    }

    fn ring(&self, by: Mechanism) -> Result<(), WakeError> {
        match self.ways.iter().find(|(mechanism, _)| *mechanism == by) {
            Some((_, SourceWay::Futex)) => {
                futex::wake(self.page.word(COUNT), futex::Flags::empty(), 1)
                    .map_err(WakeError::Wake)?;
            }
            Some((_, SourceWay::Eventfd)) => {
                // The counter is this process's standard input.
                rustix::io::write(rustix::stdio::stdin(), &1_u64.to_ne_bytes())
                    .map_err(WakeError::Wake)?;
            }
            Some((_, SourceWay::Event(event))) => event.wake()?,
            Some((_, SourceWay::Message(_) | SourceWay::Detections(_) | SourceWay::Payload(_)))
            | None => {}
        }
        Ok(())
    }
}

/// The receiving end.
pub struct Sink<'a> {
    page: &'a SharedWords,
    seen: u32,
    ways: Vec<(Mechanism, SinkWay)>,
    /// Dropped after the ports that need it; messages are waited for through it.
    guest: Option<Guest>,
}

enum SinkWay {
    Futex,
    Eventfd,
    Event(Box<EventReceiver>),
    Message(Box<Subscriber<RadarTracks>>),
    Detections(Box<Subscriber<RadarDetections>>),
    Payload(PayloadReceiver),
}

impl<'a> Sink<'a> {
    /// Opens the receiving ends of `mechanisms`.
    pub fn open(
        mechanisms: &[Mechanism],
        root: &Path,
        page: &'a SharedWords,
    ) -> Result<Self, WakeError> {
        let guest = guest(mechanisms, root, "bench-sink")?;
        let needed = || guest.as_ref().expect("made for every mechanism with a port");
        let mut ways = Vec::new();
        for mechanism in distinct(mechanisms) {
            let way = match mechanism {
                Mechanism::Futex => SinkWay::Futex,
                Mechanism::Eventfd => SinkWay::Eventfd,
                Mechanism::Iceoryx2Event => {
                    SinkWay::Event(Box::new(EventReceiver::open(needed())?))
                }
                Mechanism::Message => SinkWay::Message(Box::new(needed().subscriber()?)),
                Mechanism::Detections => SinkWay::Detections(Box::new(needed().subscriber()?)),
                Mechanism::Payload(bytes) => {
                    SinkWay::Payload(PayloadReceiver::open(needed(), bytes, Contents::Bare)?)
                }
                Mechanism::ProtectedPayload(bytes) => {
                    SinkWay::Payload(PayloadReceiver::open(needed(), bytes, Contents::Protected)?)
                }
            };
            ways.push((mechanism, way));
        }
        Ok(Self { page, seen: 0, ways, guest })
    }

    /// Bytes copied so far to take messages out of shared memory.
    pub fn copied_bytes(&self) -> u64 {
        let copied = self.ways.iter().map(|(_, way)| match way {
            SinkWay::Message(port) => port.copied_bytes(),
            SinkWay::Detections(port) => port.copied_bytes(),
            // Borrowed, or not a message.
            SinkWay::Payload(_) | SinkWay::Futex | SinkWay::Eventfd | SinkWay::Event(_) => 0,
        });
        copied.sum()
    }

    /// Waits once, and calls `each` with the stamp of each new wake-up.
    pub fn wait(&mut self, by: Mechanism, mut each: impl FnMut(i64)) -> Result<(), WakeError> {
        let guest = || self.guest.as_ref().expect("opened with the port");
        match self.ways.iter_mut().find(|(mechanism, _)| *mechanism == by) {
            Some((_, SinkWay::Message(port))) => {
                guest().next_samples(port, LOOK, |m| each(m.header.acquisition_ns))?;
                return Ok(());
            }
            Some((_, SinkWay::Detections(port))) => {
                guest().next_samples(port, LOOK, |m| each(m.header.acquisition_ns))?;
                return Ok(());
            }
            Some((_, SinkWay::Payload(port))) => {
                port.next(LOOK, each)?;
                return Ok(());
            }
            Some((_, SinkWay::Futex)) => {
                let timeout = LOOK.try_into().expect("short");
                let word = self.page.word(COUNT);
                match futex::wait(word, futex::Flags::empty(), self.seen, Some(&timeout)) {
                    Ok(()) | Err(Errno::AGAIN | Errno::TIMEDOUT | Errno::INTR) => {}
                    Err(error) => return Err(WakeError::Wait(error)),
                }
            }
            Some((_, SinkWay::Eventfd)) => {
                rustix::io::read(rustix::stdio::stdin(), &mut [0_u8; 8])
                    .map_err(WakeError::Wait)?;
            }
            Some((_, SinkWay::Event(event))) => event.wait(LOOK)?,
            None => unreachable!("every mechanism of the job was opened"),
        }
        let count = self.page.word(COUNT).load(Ordering::Acquire);
        while self.seen < count {
            let [high, low] = stamp_words(self.page, self.seen).map(|w| w.load(Ordering::Relaxed));
            each((u64::from(high) << 32 | u64::from(low)).cast_signed());
            self.seen += 1;
        }
        Ok(())
    }
}
