//! The same message over zenoh. It is written into zenoh's shared memory, and announced over a unix socket between two
//! peers that have each other's address.

use super::{MiddlewareError, Receiving, Sending, failed, patiently};
use messages::RadarTracks;
use std::path::Path;
use std::time::Duration;
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh::shm::{
    BlockOn, GarbageCollect, PosixShmProviderBackend, ShmProvider, ShmProviderBuilder,
};
use zenoh::{Config, Session, Wait};

/// Key of the topic.
const KEY: &str = "timegap/radar/tracks";
/// Bytes of a message.
const BYTES: usize = size_of::<RadarTracks>();
/// Most messages in flight.
const UNDER_WAY: usize = 256;

/// A session of a peer that does not search for others.
fn session(root: &Path, listens: bool) -> Result<Session, MiddlewareError> {
    let address = format!("[\"unixsock-stream/{}\"]", root.join("bench-zenoh.sock").display());
    let (listen, connect) =
        if listens { (address.as_str(), "[]") } else { ("[]", address.as_str()) };
    let mut config = Config::default();
    let settings = [
        ("mode", "\"peer\""),
        ("listen/endpoints", listen),
        ("connect/endpoints", connect),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        ("transport/shared_memory/enabled", "true"),
        ("transport/shared_memory/mode", "\"init\""),
    ];
    for (key, value) in settings {
        config.insert_json5(key, value).map_err(failed("zenoh cannot be configured"))?;
    }
    zenoh::open(config).wait().map_err(failed("zenoh cannot open a session"))
}

/// Removes segments of shared memory without a living owner, which ended processes leave.
pub fn forget() {
    zenoh::shm::cleanup_orphaned_shm_segments();
}

/// The publishing end.
pub struct Source {
    publisher: Publisher<'static>,
    memory: ShmProvider<PosixShmProviderBackend>,
    _session: Session,
}

impl Source {
    /// Opens the end and waits for its subscriber.
    pub fn open(root: &Path) -> Result<Self, MiddlewareError> {
        let session = patiently(|| session(root, false).map_err(std::io::Error::other))
            .map_err(MiddlewareError::ZenohAlone)?;
        let publisher = (session.declare_publisher(KEY))
            .congestion_control(CongestionControl::Block)
            // Sent at once, as a user who waits for each message would do.
            .express(true)
            .wait()
            .map_err(failed("zenoh cannot declare a publisher"))?;
        patiently(|| match publisher.matching_status().wait() {
            Ok(status) if status.matching() => Ok(()),
            Ok(_) => Err(std::io::Error::other("no subscriber")),
            Err(error) => Err(std::io::Error::other(error.to_string())),
        })
        .map_err(failed("zenoh"))?;
        let backend = PosixShmProviderBackend::builder(2 * UNDER_WAY * BYTES).wait();
        let backend = backend.map_err(failed("zenoh cannot share memory"))?;
        let memory = ShmProviderBuilder::backend(backend).wait();
        Ok(Self { publisher, memory, _session: session })
    }
}

impl Sending for Source {
    fn send(&mut self, message: &RadarTracks) -> Result<(), MiddlewareError> {
        let room = self.memory.alloc(BYTES).with_policy::<BlockOn<GarbageCollect>>().wait();
        let mut room = room.map_err(failed("zenoh cannot loan memory"))?;
        room.copy_from_slice(bytemuck::bytes_of(message));
        self.publisher.put(room).wait().map_err(failed("zenoh cannot send"))
    }
}

/// The subscribing end.
pub struct Sink {
    subscriber: Subscriber<FifoChannelHandler<Sample>>,
    _session: Session,
}

impl Sink {
    /// Opens the end.
    pub fn open(root: &Path) -> Result<Self, MiddlewareError> {
        let session = session(root, true)?;
        let subscriber = (session.declare_subscriber(KEY))
            .with(FifoChannel::new(UNDER_WAY))
            .wait()
            .map_err(failed("zenoh cannot declare a subscriber"))?;
        Ok(Self { subscriber, _session: session })
    }
}

impl Receiving for Sink {
    fn receive(
        &mut self,
        timeout: Duration,
        each: &mut dyn FnMut(i64),
    ) -> Result<(), MiddlewareError> {
        let mut next =
            self.subscriber.recv_timeout(timeout).map_err(failed("zenoh cannot receive"))?;
        while let Some(sample) = next {
            if sample.payload().as_shm().is_none() {
                return Err(MiddlewareError::ZenohCopied);
            }
            let bytes = sample.payload().to_bytes();
            let message: RadarTracks =
                bytemuck::try_pod_read_unaligned(&bytes).map_err(MiddlewareError::ZenohMessage)?;
            each(message.header.acquisition_ns);
            next = self.subscriber.try_recv().map_err(failed("zenoh cannot receive"))?;
        }
        Ok(())
    }
}
