//! A carrier, opened from its address. Sending and receiving never wait.

use crate::capture::Capture;
use crate::endpoint::{Endpoint, Outlet};
use crate::envelope::{Content, MAX_PACKET};
use crate::error::{OpenError, SendError};
use crate::frame::{Frame, MAX_FRAME};
use crate::listener::{Identity, Listener, Shared};
use crate::numbers::NUMBERS;
use crate::stations::{Counts, RadioReport};
use crate::{udp, wall_clock_ns};
use scenario::carrier::CarrierAddress;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The roadside unit: announces its start and answers questions about its clock.
    Roadside {
        /// Its wall clock at run time 0, ns since the Unix epoch.
        start_ns: i64,
    },
    /// A vehicle: asks roadside units for their clocks.
    Vehicle,
}

#[derive(Debug)]
pub struct Carrier {
    address: CarrierAddress,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Live(Live),
    Capture(Capture),
}

#[derive(Debug)]
struct Live {
    identity: Identity,
    outlet: Box<dyn Outlet>,
    sequence: u64,
    room: Box<[u8; MAX_PACKET]>,
    frames: Receiver<Frame>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Carrier {
    /// Opens a carrier. Call it before the thread gets real-time priority, which the receive thread would
    /// inherit.
    pub fn open(address: &CarrierAddress, role: Role) -> Result<Self, OpenError> {
        let identity = Identity::draw(match role {
            Role::Roadside { start_ns } => Some(start_ns),
            Role::Vehicle => None,
        });
        let is_roadside = identity.start_ns.is_some();
        let kind = match address {
            CarrierAddress::Udp { address, interface } => {
                let (endpoint, outlet) = udp::open(*address, interface.as_deref(), is_roadside)?;
                Kind::Live(Live::start(identity, Arc::default(), endpoint, outlet)?)
            }
            CarrierAddress::Zenoh { configuration } => {
                Kind::Live(open_zenoh(configuration.as_deref(), identity)?)
            }
            CarrierAddress::Capture { .. } if is_roadside => {
                return Err(OpenError::CaptureIsNoTarget);
            }
            CarrierAddress::Capture { file } => {
                let capture = Capture::open(file);
                let fail = |source| OpenError::Capture { path: file.clone(), source };
                Kind::Capture(capture.map_err(fail)?)
            }
        };
        Ok(Self { address: address.clone(), kind })
    }

    /// Sends a frame, stamped with this host's wall clock. It does not wait.
    ///
    /// # Errors
    /// [`SendError`]; the frame is counted as not sent.
    pub fn send(&mut self, frame: &[u8]) -> Result<(), SendError> {
        match &mut self.kind {
            Kind::Live(live) => live.send(frame),
            Kind::Capture(_) => Err(SendError::Capture),
        }
    }

    /// The next received frame or, of a capture, the next frame due by run time `now_ns`, ns. It does not
    /// wait.
    pub fn receive(&mut self, now_ns: i64) -> Option<Frame> {
        match &mut self.kind {
            Kind::Live(live) => live.frames.try_recv().ok(),
            Kind::Capture(capture) => capture.receive(now_ns),
        }
    }

    /// Counts of the frames so far.
    pub fn report(&self) -> RadioReport {
        let carrier = self.address.to_string();
        match &self.kind {
            Kind::Live(live) => {
                let stations = live.shared.stations().report(wall_clock_ns());
                live.shared.counts.report(carrier, stations)
            }
            Kind::Capture(capture) => {
                let received = capture.played();
                let malformed = capture.passed_over;
                RadioReport { carrier, received, malformed, ..RadioReport::default() }
            }
        }
    }

    pub fn capture(&self) -> Option<&Capture> {
        match &self.kind {
            Kind::Live(_) => None,
            Kind::Capture(capture) => Some(capture),
        }
    }
}

#[cfg(feature = "zenoh")]
fn open_zenoh(
    configuration: Option<&std::path::Path>,
    identity: Identity,
) -> Result<Live, OpenError> {
    let shared: Arc<Shared> = Arc::default();
    let (endpoint, outlet) = crate::zenoh::open(configuration, identity, &shared)?;
    Live::start(identity, shared, endpoint, outlet)
}

#[cfg(not(feature = "zenoh"))]
fn open_zenoh(_: Option<&std::path::Path>, _: Identity) -> Result<Live, OpenError> {
    Err(OpenError::WithoutZenoh)
}

impl Live {
    fn start(
        identity: Identity,
        shared: Arc<Shared>,
        endpoint: impl Endpoint + 'static,
        outlet: impl Outlet + 'static,
    ) -> Result<Self, OpenError> {
        let (queue, frames) = sync_channel(NUMBERS.queue as usize);
        let listener =
            Listener { endpoint: Box::new(endpoint), identity, queue, shared: Arc::clone(&shared) };
        let thread = std::thread::Builder::new()
            .name("radio".into())
            .spawn(move || listener.run())
            .map_err(OpenError::SetUp)?;
        Ok(Self {
            identity,
            outlet: Box::new(outlet),
            sequence: 0,
            room: Box::new([0; MAX_PACKET]),
            frames,
            shared,
            thread: Some(thread),
        })
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), SendError> {
        let counts = &self.shared.counts;
        if frame.is_empty() || frame.len() > MAX_FRAME {
            Counts::count(&counts.not_sent);
            return Err(SendError::TooLong(frame.len()));
        }
        let envelope = self.identity.envelope(self.sequence + 1);
        let length = envelope.write(Content::Frame(frame), &mut self.room);
        let sent = self.outlet.send(&self.room[..length]);
        // The next frame reuses the number of an unsent one, which therefore does not count as lost.
        self.sequence += u64::from(sent.is_ok());
        Counts::count(if sent.is_ok() { &counts.sent } else { &counts.not_sent });
        sent
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.outlet.close();
        if let Some(thread) = self.thread.take() {
            // A panic was reported by its thread.
            let _ = thread.join();
        }
    }
}
