//! Alternatives to the services' ports: the same message passed by other means.
//!
//! Each end is opened under the measured scheduling, so that a library's own threads inherit it.

pub mod event;
pub mod payload;
mod pub_sub;
mod sockets;

#[cfg(cyclonedds)]
mod cyclonedds;
#[cfg(feature = "peers")]
mod zenoh;

use super::setup::Mechanism;
use messages::RadarTracks;
use messages::e2e::profile7;
use runtime::RuntimeError;
use std::path::Path;
use std::time::{Duration, Instant};

/// Time to wait for the other end.
const PATIENCE: Duration = Duration::from_secs(30);

/// Error of a library.
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// An error of another transport.
#[derive(Debug, thiserror::Error)]
pub enum MiddlewareError {
    /// iceoryx2, whose errors are names.
    #[error("iceoryx2 cannot {what}: {reason:?}")]
    Iceoryx2 {
        /// Failed operation.
        what: &'static str,
        /// Its error.
        reason: Cause,
    },
    /// The run's configuration of iceoryx2 is not available.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A payload does not pass its check.
    #[error("a payload's {0:?}")]
    Corrupted(profile7::Corrupted),
    /// A socket or another library.
    #[error("{what}: {reason}")]
    Failed {
        /// Failed operation.
        what: &'static str,
        /// Its error.
        reason: Cause,
    },
    /// zenoh's other end did not open its session in time.
    #[cfg(feature = "peers")]
    #[error("{0}")]
    ZenohAlone(#[source] std::io::Error),
    /// The size of a message from zenoh is wrong.
    #[cfg(feature = "peers")]
    #[error("zenoh delivered a message of a wrong size: {0}")]
    ZenohMessage(bytemuck::PodCastError),
    /// zenoh did not use its shared memory.
    #[cfg(feature = "peers")]
    #[error("zenoh copied a message out of shared memory")]
    ZenohCopied,
    /// CycloneDDS.
    #[cfg(cyclonedds)]
    #[error("CycloneDDS cannot {what}: code {code}")]
    CycloneDds {
        /// Failed operation.
        what: &'static str,
        /// Its return code.
        code: i32,
    },
}

fn iceoryx2_failed<E>(what: &'static str) -> impl Fn(E) -> MiddlewareError
where
    E: std::error::Error + Send + Sync + 'static,
{
    move |reason| MiddlewareError::Iceoryx2 { what, reason: Box::new(reason) }
}

fn failed<E: Into<Cause>>(what: &'static str) -> impl Fn(E) -> MiddlewareError {
    move |reason| MiddlewareError::Failed { what, reason: reason.into() }
}

/// A sending end.
pub trait Sending {
    /// Sends one message and wakes its receiver.
    fn send(&mut self, message: &RadarTracks) -> Result<(), MiddlewareError>;
}

/// A receiving end.
pub trait Receiving {
    /// Waits for messages, about this long, and calls `each` with the acquisition stamp of each, ns.
    fn receive(
        &mut self,
        timeout: Duration,
        each: &mut dyn FnMut(i64),
    ) -> Result<(), MiddlewareError>;
}

/// Reason why this build lacks `mechanism`; `None` if it has it.
pub fn missing(mechanism: Mechanism) -> Option<&'static str> {
    const FEATURE: &str = "built without the feature \"peers\"";
    match mechanism {
        Mechanism::Zenoh if cfg!(not(feature = "peers")) => Some(FEATURE),
        Mechanism::CycloneDds if cfg!(not(feature = "peers")) => Some(FEATURE),
        Mechanism::CycloneDds if cfg!(not(cyclonedds)) => {
            Some("built without its library (Debian: cyclonedds-dev)")
        }
        _ => None,
    }
}

/// The sending end of another transport, once its receiver is ready. `None` for our own mechanisms and for
/// those that [`missing`] names.
pub fn source(
    mechanism: Mechanism,
    root: &Path,
) -> Result<Option<Box<dyn Sending>>, MiddlewareError> {
    Ok(Some(match mechanism {
        Mechanism::Iceoryx2PubSub => Box::new(pub_sub::Source::open(root)?),
        Mechanism::UnixDatagram => Box::new(sockets::Socket::datagram_source(root)?),
        Mechanism::Tcp => Box::new(sockets::Socket::tcp_source(root)?),
        #[cfg(feature = "peers")]
        Mechanism::Zenoh => Box::new(zenoh::Source::open(root)?),
        #[cfg(cyclonedds)]
        Mechanism::CycloneDds => Box::new(cyclonedds::Writer::open()?),
        _ => return Ok(None),
    }))
}

/// The receiving end, like [`source`].
pub fn sink(
    mechanism: Mechanism,
    root: &Path,
) -> Result<Option<Box<dyn Receiving>>, MiddlewareError> {
    Ok(Some(match mechanism {
        Mechanism::Iceoryx2PubSub => Box::new(pub_sub::Sink::open(root)?),
        Mechanism::UnixDatagram => Box::new(sockets::Socket::datagram_sink(root)?),
        Mechanism::Tcp => Box::new(sockets::Socket::tcp_sink(root)?),
        #[cfg(feature = "peers")]
        Mechanism::Zenoh => Box::new(zenoh::Sink::open(root)?),
        #[cfg(cyclonedds)]
        Mechanism::CycloneDds => Box::new(cyclonedds::Reader::open()?),
        _ => return Ok(None),
    }))
}

/// Removes the names of both ends and the shared memory of ended processes for the next comparison.
pub fn forget(root: &Path) {
    sockets::forget(root);
    #[cfg(feature = "peers")]
    zenoh::forget();
}

/// Repeats an attempt until it succeeds or [`PATIENCE`] is over.
fn patiently<T>(mut attempt: impl FnMut() -> std::io::Result<T>) -> std::io::Result<T> {
    let begun = Instant::now();
    loop {
        match attempt() {
            Err(_) if begun.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(1)),
            result => return result,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use group::RunRoot;

    /// Every other transport of this build delivers each message once and in order.
    #[test]
    fn every_peer_delivers_each_message_once_and_in_order() {
        const COUNT: i64 = 20;
        let root = RunRoot::create().expect("room in memory");
        crate::stage::group_below(&root).write().expect("our own root");
        let path = root.path();
        let known = Mechanism::PEERS.into_iter().filter(|peer| missing(*peer).is_none());
        let mut compared = 0;
        for mechanism in known {
            std::thread::scope(|scope| {
                let sender = scope.spawn(move || {
                    let mut source = source(mechanism, path).expect("a source").expect("a peer");
                    let mut message = RadarTracks::zeroed();
                    for number in 1..=COUNT {
                        message.header.acquisition_ns = number;
                        source.send(&message).expect("sent");
                        // iceoryx2's default keeps the two newest messages.
                        std::thread::sleep(Duration::from_millis(5));
                    }
                });
                let mut sink = sink(mechanism, path).expect("a sink").expect("a peer");
                let mut stamps = Vec::new();
                let begun = Instant::now();
                while stamps.last() != Some(&COUNT) {
                    assert!(begun.elapsed() < 2 * PATIENCE, "{mechanism:?}: {stamps:?}");
                    sink.receive(Duration::from_millis(50), &mut |ns| stamps.push(ns))
                        .unwrap_or_else(|e| panic!("{mechanism:?}: {e}"));
                }
                sender.join().expect("no panic");
                let first = stamps[0];
                assert_eq!(stamps, (first..=COUNT).collect::<Vec<_>>(), "{mechanism:?}");
            });
            compared += 1;
        }
        root.remove();
        let expected = match (cfg!(feature = "peers"), cfg!(cyclonedds)) {
            (false, _) => 3,
            (true, false) => 4,
            (true, true) => 5,
        };
        assert_eq!(compared, expected);
    }
}
