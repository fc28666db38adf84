//! The two ends of each way to wake a process.
//!
//! Every wake-up carries the instant before the sender's first action. So a stalled sink is charged for each late
//! wake-up. An end holds all its ways open and uses them in turn.

use super::payload::{PayloadReceiver, PayloadSender};
use super::setup::{Mechanism, failed};
use iceoryx2::port::{listener::Listener, notifier::Notifier};
use iceoryx2::service::port_factory::event::PortFactory;
use messages::{Header, MAX_DETECTIONS, Origins, RadarDetections, RadarTracks, Service};
use runtime::{Group, Guest, Ipc, Publisher, SharedWords, Subscriber, enroll, monotonic_ns};
use rustix::io::Errno;
use rustix::thread::futex;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;
use supervise::{Error, MachineError};

/// Longest wait before the sink checks whether the source has ended.
const LOOK: Duration = Duration::from_millis(50);

/// iceoryx2's own event service, of the topics' own node and variant.
fn event(guest: &Guest) -> Result<PortFactory<Ipc>, MachineError> {
    let name = "bench/event".try_into().expect("a valid service name");
    guest.service(&name).event().open_or_create().map_err(failed("open an event service"))
}

/// Words of the stamp of a wake-up.
fn stamp_words(page: &SharedWords, number: u32) -> [&AtomicU32; 2] {
    let place = STAMPS + number as usize % RING * 2;
    [&page[place], &page[place + 1]]
}

/// The sending end.
pub struct Source<'a> {
    page: &'a SharedWords,
    sent: u32,
    ways: Vec<SourceWay>,
    /// Dropped after the ports that need it.
    _guest: Guest,
}

enum SourceWay {
    Futex,
    Eventfd,
    Event(Box<Notifier<Ipc>>),
    Message(Box<Publisher<RadarTracks>>),
    Detections(Box<Publisher<RadarDetections>>),
    Payload(PayloadSender),
}

impl SourceWay {
    fn open(mechanism: Mechanism, guest: &Guest) -> Result<Self, Error> {
        Ok(match mechanism {
            Mechanism::Futex => Self::Futex,
            Mechanism::Eventfd => Self::Eventfd,
            Mechanism::Iceoryx2Event => {
                let port = event(guest)?.notifier_builder().create();
                Self::Event(Box::new(port.map_err(failed("make a notifier"))?))
            }
            Mechanism::Message => Self::Message(Box::new(guest.publisher(Service::PerceptionSim)?)),
            Mechanism::Detections => {
                Self::Detections(Box::new(guest.publisher(Service::PerceptionSim)?))
            }
            Mechanism::Payload { bytes, is_protected } => {
                Self::Payload(PayloadSender::open(guest, bytes, is_protected)?)
            }
        })
    }
}

impl<'a> Source<'a> {
    /// Opens the sending ends of `mechanisms`.
    pub fn open(
        mechanisms: &[Mechanism],
        root: &Path,
        page: &'a SharedWords,
    ) -> Result<Self, Error> {
        let group = Group::read(root)?;
        let guest = Guest::join(&group, "bench-source")?;
        // A reader accepts messages of group members only.
        enroll(&group.prefix, Service::PerceptionSim, 0, std::process::id())?;
        let ways = mechanisms.iter().map(|mechanism| SourceWay::open(*mechanism, &guest));
        let ways = ways.collect::<Result<_, _>>()?;
        Ok(Self { page, sent: 0, ways, _guest: guest })
    }

    /// Wakes the sink by the way with this number.
    pub fn wake(&mut self, way: usize) -> Result<(), Error> {
        let header = Header::new(self.sent.into(), monotonic_ns(), Origins::NONE);
        match &mut self.ways[way] {
            SourceWay::Message(port) => {
                port.send_with(|message| message.header = header)?;
            }
            SourceWay::Detections(port) => {
                // Like the radar: the message still holds an earlier, valid scan.
                let mut message = port.loan_used()?;
                message.header = header;
                message.count = MAX_DETECTIONS as u64;
                port.send(message)?;
            }
            SourceWay::Payload(port) => port.send()?,
            SourceWay::Futex | SourceWay::Eventfd | SourceWay::Event(_) => {
                let now = monotonic_ns().cast_unsigned();
                let [high, low] = stamp_words(self.page, self.sent);
                high.store((now >> 32) as u32, Ordering::Relaxed);
                low.store(now as u32, Ordering::Relaxed);
                self.sent += 1;
                self.page[COUNT].store(self.sent, Ordering::Release);
                self.ring(way)?;
            }
        }
        Ok(())
    }

    /// Wakes a sink that waits without a stamp, also so that it checks for the end.
    pub fn ring(&self, way: usize) -> Result<(), MachineError> {
        match &self.ways[way] {
            SourceWay::Futex => {
                let woken = futex::wake(&self.page[COUNT], futex::Flags::empty(), 1);
                woken.map_err(failed("wake by futex"))?;
            }
            SourceWay::Eventfd => {
                // The counter is this process's standard input.
                let written = rustix::io::write(rustix::stdio::stdin(), &1_u64.to_ne_bytes());
                written.map_err(failed("wake by eventfd"))?;
            }
            SourceWay::Event(port) => {
                port.notify().map_err(failed("wake by event"))?;
            }
            SourceWay::Message(_) | SourceWay::Detections(_) | SourceWay::Payload(_) => {}
        }
        Ok(())
    }
}

/// The receiving end.
pub struct Sink<'a> {
    page: &'a SharedWords,
    seen: u32,
    ways: Vec<SinkWay>,
    /// Dropped after the ports that need it; messages are waited for through it.
    guest: Guest,
}

enum SinkWay {
    Futex,
    Eventfd,
    Event(Box<Listener<Ipc>>),
    Message(Box<Subscriber<RadarTracks>>),
    Detections(Box<Subscriber<RadarDetections>>),
    Payload(PayloadReceiver),
}

impl SinkWay {
    fn open(mechanism: Mechanism, guest: &Guest) -> Result<Self, Error> {
        Ok(match mechanism {
            Mechanism::Futex => Self::Futex,
            Mechanism::Eventfd => Self::Eventfd,
            Mechanism::Iceoryx2Event => {
                let port = event(guest)?.listener_builder().create();
                Self::Event(Box::new(port.map_err(failed("make a listener"))?))
            }
            Mechanism::Message => Self::Message(Box::new(guest.subscriber()?)),
            Mechanism::Detections => Self::Detections(Box::new(guest.subscriber()?)),
            Mechanism::Payload { bytes, is_protected } => {
                Self::Payload(PayloadReceiver::open(guest, bytes, is_protected)?)
            }
        })
    }
}

impl<'a> Sink<'a> {
    /// Opens the receiving ends of `mechanisms`.
    pub fn open(
        mechanisms: &[Mechanism],
        root: &Path,
        page: &'a SharedWords,
    ) -> Result<Self, Error> {
        let guest = Guest::join(&Group::read(root)?, "bench-sink")?;
        let ways = mechanisms.iter().map(|mechanism| SinkWay::open(*mechanism, &guest));
        let ways = ways.collect::<Result<_, _>>()?;
        Ok(Self { page, seen: 0, ways, guest })
    }

    /// Bytes copied so far to take messages out of shared memory.
    pub fn copied_bytes(&self) -> u64 {
        let copied = self.ways.iter().map(|way| match way {
            SinkWay::Message(port) => port.copied_bytes(),
            SinkWay::Detections(port) => port.copied_bytes(),
            // Borrowed, or not a message.
            SinkWay::Payload(_) | SinkWay::Futex | SinkWay::Eventfd | SinkWay::Event(_) => 0,
        });
        copied.sum()
    }

    /// Waits once by the way with this number, and calls `each` with the stamp of each new wake-up.
    pub fn wait(&mut self, way: usize, mut each: impl FnMut(i64)) -> Result<(), Error> {
        match &mut self.ways[way] {
            SinkWay::Message(port) => {
                self.guest.next_samples(port, LOOK, |m| each(m.header.acquisition_ns))?;
            }
            SinkWay::Detections(port) => {
                self.guest.next_samples(port, LOOK, |m| each(m.header.acquisition_ns))?;
            }
            SinkWay::Payload(port) => port.next(LOOK, &mut each)?,
            SinkWay::Futex => {
                let timeout = LOOK.try_into().expect("short");
                let word = &self.page[COUNT];
                match futex::wait(word, futex::Flags::empty(), self.seen, Some(&timeout)) {
                    Ok(()) | Err(Errno::AGAIN | Errno::TIMEDOUT | Errno::INTR) => {}
                    Err(error) => return Err(failed("wait by futex")(error).into()),
                }
            }
            SinkWay::Eventfd => {
                let read = rustix::io::read(rustix::stdio::stdin(), &mut [0_u8; 8]);
                read.map_err(failed("wait by eventfd"))?;
            }
            SinkWay::Event(port) => {
                port.timed_wait(|_| {}, LOOK).map_err(failed("wait by event"))?;
            }
        }
        // Messages and payloads carry their stamps and do not count here.
        let count = self.page[COUNT].load(Ordering::Acquire);
        while self.seen < count {
            let [high, low] = stamp_words(self.page, self.seen).map(|w| w.load(Ordering::Relaxed));
            each((u64::from(high) << 32 | u64::from(low)).cast_signed());
            self.seen += 1;
        }
        Ok(())
    }
}

/// Wake-ups so far; the futex.
pub const COUNT: usize = 0;
/// Number of the block that the sink waits for, from 1; 1 for a metronome that ticks.
pub const READY: usize = 16;
/// Number of the block that the source has ended, from 1.
pub const DONE: usize = 32;
/// State of the metronome, [`super::peer::metronome`].
pub const METRONOME: usize = 48;
/// First word of the ring of stamps, two words each.
pub const STAMPS: usize = 64;
pub const RING: usize = 256;
