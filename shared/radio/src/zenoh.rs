//! zenoh: frames under `timegap/radio/frames`, questions to roadside units beside them, and answers under the
//! asking station's number.
//!
//! zenoh's own configuration determines discovery, links and certificates. A frame that zenoh cannot accept at once is
//! dropped. zenoh's calls may wait for a lock, so a separate thread makes them.

use crate::endpoint::{Endpoint, Origin, Outlet, Received};
use crate::envelope::MAX_PACKET;
use crate::error::{OpenError, SendError};
use crate::listener::{Identity, Shared};
use crate::stations::Counts;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::Locality;
use zenoh::{Config, Session, Wait};

const FRAMES: &str = "timegap/radio/frames";
const QUESTIONS: &str = "timegap/radio/questions";
const ANSWERS: &str = "timegap/radio/answers";

/// Packets between zenoh's threads and ours, each way.
const QUEUE: usize = 256;

/// Longest time to open a session; zenoh itself waits without a bound on some links.
const PATIENCE: Duration = Duration::from_secs(10);

/// Time without a packet after which the subscriptions are declared again. If two peers declare at the instant
/// when their link opens, zenoh may lose a declaration and would never send.
const RENEWAL: Duration = Duration::from_secs(2);

/// Opens a session and both ends.
pub(crate) fn open(
    configuration: Option<&Path>,
    identity: Identity,
    shared: &Arc<Shared>,
) -> Result<(ZenohEndpoint, ZenohOutlet), OpenError> {
    let mut config = match configuration {
        None => Config::default(),
        Some(path) => Config::from_file(path).map_err(|reason| OpenError::ZenohConfiguration {
            path: path.to_owned(),
            reason: words(&reason),
        })?,
    };
    let fail = |reason: zenoh::Error| OpenError::ZenohSession(words(&reason));
    // With shared memory, zenoh would create segments for each session, which a killed process leaves behind.
    // Frames are too short to need them.
    config.insert_json5("transport/shared_memory/enabled", "false").map_err(fail)?;
    let session = open_session(config)?;
    let publisher = |key: &'static str| {
        (session.declare_publisher(key))
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::RealTime)
            .express(true)
            .allowed_destination(Locality::Remote)
            .wait()
            .map_err(fail)
    };
    let (frames, questions) = (publisher(FRAMES)?, publisher(QUESTIONS)?);
    let (arrivals, heard) = sync_channel(QUEUE);
    let other = match identity.start_ns {
        Some(_) => QUESTIONS.to_owned(),
        None => answers_to(identity.sender),
    };
    let keys = [FRAMES.to_owned(), other];
    let mut endpoint = ZenohEndpoint {
        heard,
        questions,
        session,
        keys,
        arrivals: arrivals.clone(),
        shared: Arc::clone(shared),
        subscribers: Vec::new(),
        silent: Duration::ZERO,
    };
    endpoint.subscribe().map_err(fail)?;
    let (queue, departures) = sync_channel::<Vec<u8>>(QUEUE);
    let counts = Arc::clone(shared);
    std::thread::Builder::new()
        .name("radio-send".into())
        .spawn(move || send_all(&departures, &frames, &counts))
        .map_err(OpenError::SetUp)?;
    Ok((endpoint, ZenohOutlet { queue, arrivals }))
}

fn answers_to(station: u64) -> String {
    format!("{ANSWERS}/{station:016x}")
}

/// zenoh's error, without the source location at its end.
fn words(error: &zenoh::Error) -> String {
    let said = error.to_string();
    match said.rsplit_once(" at ") {
        Some((words, place)) if place.contains(".rs:") => words.to_owned(),
        _ => said,
    }
}

/// Opens a session in a thread of its own, which is abandoned after a timeout.
fn open_session(config: Config) -> Result<Session, OpenError> {
    let (done, opened) = sync_channel(1);
    std::thread::Builder::new()
        .name("radio-open".into())
        .spawn(move || {
            // The caller may have stopped waiting.
            let _ = done.send(zenoh::open(config).wait());
        })
        .map_err(OpenError::SetUp)?;
    match opened.recv_timeout(PATIENCE) {
        Ok(session) => session.map_err(|reason| OpenError::ZenohSession(words(&reason))),
        Err(_) => {
            let reason = format!("none was open after {} s", PATIENCE.as_secs());
            Err(OpenError::ZenohSession(reason))
        }
    }
}

fn send_all(departures: &Receiver<Vec<u8>>, publisher: &Publisher<'_>, shared: &Shared) {
    while let Ok(packet) = departures.recv() {
        if publisher.put(packet).wait().is_err() {
            Counts::count(&shared.counts.not_sent);
        }
    }
}

/// Input of the receive thread: a packet, or the end.
type Arrival = Option<Vec<u8>>;

pub(crate) struct ZenohEndpoint {
    heard: Receiver<Arrival>,
    questions: Publisher<'static>,
    session: Session,
    keys: [String; 2],
    arrivals: SyncSender<Arrival>,
    shared: Arc<Shared>,
    subscribers: Vec<Subscriber<()>>,
    /// Time since the last packet, or since the last declaration.
    silent: Duration,
}

impl ZenohEndpoint {
    /// Declares the subscriptions, replacing existing ones.
    fn subscribe(&mut self) -> Result<(), zenoh::Error> {
        self.silent = Duration::ZERO;
        self.subscribers.clear();
        for key in &self.keys {
            let (arrivals, shared) = (self.arrivals.clone(), Arc::clone(&self.shared));
            let subscriber = (self.session.declare_subscriber(key.clone()))
                .callback(move |sample| {
                    let bytes = sample.payload().to_bytes();
                    if bytes.len() > MAX_PACKET {
                        Counts::count(&shared.counts.malformed);
                    } else if arrivals.try_send(Some(bytes.into_owned())).is_err() {
                        Counts::count(&shared.counts.dropped);
                    }
                })
                .allowed_origin(Locality::Remote)
                .wait()?;
            self.subscribers.push(subscriber);
        }
        Ok(())
    }
}

impl Endpoint for ZenohEndpoint {
    fn receive(&mut self, timeout: Duration, buffer: &mut [u8]) -> Received {
        match self.heard.recv_timeout(timeout) {
            Ok(Some(packet)) => {
                self.silent = Duration::ZERO;
                buffer[..packet.len()].copy_from_slice(&packet);
                Received::Packet(packet.len(), Origin::Zenoh)
            }
            Ok(None) | Err(RecvTimeoutError::Disconnected) => Received::Closed,
            Err(RecvTimeoutError::Timeout) => {
                self.silent += timeout;
                if self.silent >= RENEWAL {
                    // If the session refuses now, the next turn repeats it.
                    let _ = self.subscribe();
                }
                Received::Nothing
            }
        }
    }

    fn send(&mut self, to: Origin, asker: Option<u64>, packet: &[u8]) {
        // A lost one is repeated later.
        let _ = match (to, asker) {
            (Origin::Socket(_), _) => return,
            (Origin::Zenoh, None) => self.questions.put(packet).wait(),
            (Origin::Zenoh, Some(asker)) => (self.session)
                .put(answers_to(asker), packet)
                .congestion_control(CongestionControl::Drop)
                .priority(Priority::RealTime)
                .express(true)
                .wait(),
        };
    }
}

impl Drop for ZenohEndpoint {
    fn drop(&mut self) {
        // A router may be gone already.
        let _ = self.session.close().wait();
    }
}

/// The sending end.
#[derive(Debug)]
pub(crate) struct ZenohOutlet {
    queue: SyncSender<Vec<u8>>,
    arrivals: SyncSender<Arrival>,
}

impl Outlet for ZenohOutlet {
    fn send(&mut self, packet: &[u8]) -> Result<(), SendError> {
        self.queue.try_send(packet.to_vec()).map_err(|_| SendError::Full)
    }

    fn close(&mut self) {
        // The receive thread empties the queue, so that there will be room.
        let _ = self.arrivals.send(None);
    }
}
