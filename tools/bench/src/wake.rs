//! The two ends of each way to wake a process.
//!
//! Every wake-up carries the instant before the sender's first act, so that a sink that was stalled
//! is charged for each wake-up that it came late to.

use super::peer::words::{COUNT, RING, STAMPS};
use super::plan::Mechanism;
use bytemuck::Zeroable;
use group::Error;
use messages::Service;
use messages::{Header, Origins, RadarTracks};
use runtime::{
    EventReceiver, EventSender, Group, PayloadReceiver, PayloadSender, Probe, Publisher,
    SharedWords, Subscriber, enroll, monotonic_ns,
};
use rustix::thread::futex;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Longest wait before the sink looks whether the source is done.
const LOOK: Duration = Duration::from_millis(50);

/// The sending end.
pub struct Source<'a> {
    page: &'a SharedWords,
    sent: u32,
    way: SourceWay,
    /// After the ports that need it.
    _probe: Option<Probe>,
}

enum SourceWay {
    Futex,
    Eventfd,
    Event(Box<EventSender>),
    Message(Box<Publisher<RadarTracks>>),
    Payload(PayloadSender),
}

fn join(root: &Path, name: &str) -> Result<Probe, Error> {
    Ok(Probe::join(Group::read(root)?, name)?)
}

/// Words of the stamp of a wake-up.
fn stamp_words(page: &SharedWords, number: u32) -> [&std::sync::atomic::AtomicU32; 2] {
    let place = STAMPS + number as usize % RING * 2;
    [page.word(place), page.word(place + 1)]
}

impl<'a> Source<'a> {
    pub fn open(mechanism: Mechanism, root: &Path, page: &'a SharedWords) -> Result<Self, Error> {
        let open = || join(root, "bench-source");
        let (way, probe) = match mechanism {
            Mechanism::Futex => (SourceWay::Futex, None),
            Mechanism::Eventfd => (SourceWay::Eventfd, None),
            Mechanism::Iceoryx2Event => {
                let probe = open()?;
                (SourceWay::Event(Box::new(probe.event_sender()?)), Some(probe))
            }
            Mechanism::Message => {
                let probe = open()?;
                // A reader heeds members of the group alone.
                enroll(root, Service::PerceptionSim, 0, std::process::id())?;
                let port = probe.publisher(Service::PerceptionSim)?;
                (SourceWay::Message(Box::new(port)), Some(probe))
            }
            Mechanism::Payload(bytes) => {
                let probe = open()?;
                (SourceWay::Payload(probe.payload_sender(bytes)?), Some(probe))
            }
        };
        Ok(Self { page, sent: 0, way, _probe: probe })
    }

    /// One wake-up.
    pub fn wake(&mut self) -> Result<(), Error> {
        match &mut self.way {
            SourceWay::Message(port) => {
                let header = Header::new(self.sent.into(), monotonic_ns(), Origins::NONE);
                port.send(RadarTracks { header, ..RadarTracks::zeroed() })?;
            }
            SourceWay::Payload(port) => port.send()?,
            SourceWay::Futex | SourceWay::Eventfd | SourceWay::Event(_) => {
                let now = monotonic_ns().cast_unsigned();
                let [high, low] = stamp_words(self.page, self.sent);
                high.store((now >> 32) as u32, Ordering::Relaxed);
                low.store(now as u32, Ordering::Relaxed);
                self.page.word(COUNT).store(self.sent + 1, Ordering::Release);
                self.ring()?;
            }
        }
        self.sent += 1;
        Ok(())
    }

    /// Lets a sink that waits without a timeout look again.
    pub fn wake_for_the_end(&self) -> Result<(), Error> {
        self.ring()
    }

    fn ring(&self) -> Result<(), Error> {
        let failed = |e: rustix::io::Errno| Error::Machine(format!("cannot wake: {e}"));
        match &self.way {
            SourceWay::Futex => {
                futex::wake(self.page.word(COUNT), futex::Flags::empty(), 1).map_err(failed)?;
            }
            SourceWay::Eventfd => {
                // The counter is this process's standard input.
                rustix::io::write(rustix::stdio::stdin(), &1_u64.to_ne_bytes()).map_err(failed)?;
            }
            SourceWay::Event(event) => event.wake()?,
            SourceWay::Message(_) | SourceWay::Payload(_) => {}
        }
        Ok(())
    }
}

/// The receiving end.
pub struct Sink<'a> {
    page: &'a SharedWords,
    seen: u32,
    way: SinkWay,
    /// After the ports that need it; the messages' port is waited for through it.
    probe: Option<Probe>,
}

enum SinkWay {
    Futex,
    Eventfd,
    Event(Box<EventReceiver>),
    Message(Box<Subscriber<RadarTracks>>),
    Payload(PayloadReceiver),
}

impl<'a> Sink<'a> {
    pub fn open(mechanism: Mechanism, root: &Path, page: &'a SharedWords) -> Result<Self, Error> {
        let open = || join(root, "bench-sink");
        let (way, probe) = match mechanism {
            Mechanism::Futex => (SinkWay::Futex, None),
            Mechanism::Eventfd => (SinkWay::Eventfd, None),
            Mechanism::Iceoryx2Event => {
                let probe = open()?;
                (SinkWay::Event(Box::new(probe.event_receiver()?)), Some(probe))
            }
            Mechanism::Message => {
                let probe = open()?;
                (SinkWay::Message(Box::new(probe.subscriber()?)), Some(probe))
            }
            Mechanism::Payload(_) => {
                let probe = open()?;
                (SinkWay::Payload(probe.payload_receiver()?), Some(probe))
            }
        };
        Ok(Self { page, seen: 0, way, probe })
    }

    /// Waits once, and hands the stamp of each new wake-up to `each`.
    pub fn wait(&mut self, mut each: impl FnMut(i64)) -> Result<(), Error> {
        let failed = |e: rustix::io::Errno| Error::Machine(format!("cannot wait: {e}"));
        match &mut self.way {
            SinkWay::Message(port) => {
                let probe = self.probe.as_ref().expect("opened with the port");
                probe.next_samples(port, LOOK, |m| each(m.header.acquisition_ns))?;
                return Ok(());
            }
            SinkWay::Payload(port) => {
                port.next(LOOK, |sent_ns, _| each(sent_ns))?;
                return Ok(());
            }
            SinkWay::Futex => {
                use rustix::io::Errno;
                let timeout = LOOK.try_into().expect("short");
                let word = self.page.word(COUNT);
                match futex::wait(word, futex::Flags::empty(), self.seen, Some(&timeout)) {
                    Ok(()) | Err(Errno::AGAIN | Errno::TIMEDOUT | Errno::INTR) => {}
                    Err(error) => return Err(failed(error)),
                }
            }
            SinkWay::Eventfd => {
                rustix::io::read(rustix::stdio::stdin(), &mut [0_u8; 8]).map_err(failed)?;
            }
            SinkWay::Event(event) => event.wait(LOOK)?,
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
