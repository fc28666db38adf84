//! Payloads of any size, sent as a topic's large messages are.
//!
//! They take the same steps through the same node, iceoryx2 variant and wake-up. Payloads are loaned, sent where they
//! are, and borrowed by the reader. They are bare, or written, protected and checked in place.

use super::setup::failed;
use iceoryx2::port::{publisher::Publisher, subscriber::Subscriber};
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use messages::e2e::profile7;
use messages::{Service as Member, Topic};
use runtime::{Guest, Ipc, Waker, monotonic_ns};
use std::time::Duration;
use supervise::MachineError;

/// Topic whose wake-up word the payloads use.
const PAYLOAD_TOPIC: Topic = Topic::RadarTracks;

/// Time when a payload was sent, `CLOCK_MONOTONIC` ns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Stamp")]
struct Stamp {
    sent_ns: i64,
}

type Payload = [u8];

/// Processes that a service of payloads has at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peers {
    pub senders: usize,
    pub receivers: usize,
    /// Payloads kept for receivers that come late.
    pub history: usize,
}

/// The iceoryx2 service of payloads of this name, beside those of the topics.
fn service(
    guest: &Guest,
    name: &str,
    peers: Peers,
) -> Result<PortFactory<Ipc, Payload, Stamp>, MachineError> {
    (guest.service(&name.try_into().map_err(failed("name a service of payloads"))?))
        .publish_subscribe::<Payload>()
        .user_header::<Stamp>()
        .max_publishers(peers.senders)
        .max_subscribers(peers.receivers)
        .max_nodes(2 * (peers.senders + peers.receivers))
        // A sink that lags by more than this has lost the wake-ups anyway.
        .subscriber_max_buffer_size(4)
        .subscriber_max_borrowed_samples(1)
        .history_size(peers.history)
        .open_or_create()
        .map_err(failed("open a service of payloads"))
}

/// The sending end of payloads.
#[derive(Debug)]
pub struct BytesSender {
    port: Publisher<Ipc, Payload, Stamp>,
    bytes: usize,
}

impl BytesSender {
    /// Opens the service `name` for payloads of `bytes`.
    pub fn open(
        guest: &Guest,
        name: &str,
        bytes: usize,
        peers: Peers,
    ) -> Result<Self, MachineError> {
        let port = (service(guest, name, peers)?.publisher_builder())
            .initial_max_slice_len(bytes)
            .create()
            .map_err(failed("make a sender of payloads"))?;
        Ok(Self { port, bytes })
    }

    /// Loans a payload, stamps it with the time before the loan, lets `write` fill it and sends it. It holds zeros or
    /// an earlier payload.
    #[expect(unsafe_code, reason = "a payload is not written to please the type")]
    pub fn send(&mut self, write: impl FnOnce(&mut [u8])) -> Result<(), MachineError> {
        let sent_ns = monotonic_ns();
        let sample = self.port.loan_slice_uninit(self.bytes);
        let mut sample = sample.map_err(failed("loan a payload"))?;
        sample.user_header_mut().sent_ns = sent_ns;
        // SAFETY: the payload is a part of a file in memory, mapped by this process. It holds zeros or an earlier
        // payload.
        let mut sample = unsafe { sample.assume_init() };
        write(sample.payload_mut());
        sample.send().map_err(failed("send a payload"))?;
        Ok(())
    }
}

/// A receiving end of payloads.
#[derive(Debug)]
pub struct BytesReceiver(Subscriber<Ipc, Payload, Stamp>);

impl BytesReceiver {
    pub fn open(guest: &Guest, name: &str, peers: Peers) -> Result<Self, MachineError> {
        let port = (service(guest, name, peers)?.subscriber_builder()).create();
        Ok(Self(port.map_err(failed("make a receiver of payloads"))?))
    }

    /// Hands all payloads that have come to `each`, in order, with their stamps; true if there was one.
    pub fn take(
        &self,
        mut each: impl FnMut(i64, &[u8]) -> Result<(), MachineError>,
    ) -> Result<bool, MachineError> {
        let mut found = false;
        while let Some(sample) = self.0.receive().map_err(failed("receive a payload"))? {
            found = true;
            each(sample.user_header().sent_ns, sample.payload())?;
        }
        Ok(found)
    }
}

/// The service of the benchmark's own payloads of `bytes`: one sender, one receiver.
fn own(bytes: usize) -> (String, Peers) {
    (format!("bench/payload/{bytes}"), Peers { senders: 1, receivers: 1, history: 0 })
}

const PAYLOAD_DATA_ID: u32 = PAYLOAD_TOPIC.data_id(Member::PerceptionSim.to_wire());

#[derive(Debug)]
pub struct PayloadSender {
    port: BytesSender,
    waker: Waker,
    /// The sender writes and protects the bytes, the reader checks them, all in place.
    is_protected: bool,
    sent: u32,
}

impl PayloadSender {
    pub fn open(guest: &Guest, bytes: usize, is_protected: bool) -> Result<Self, MachineError> {
        let (name, peers) = own(bytes);
        let port = BytesSender::open(guest, &name, bytes, peers)?;
        Ok(Self { port, waker: guest.waker(PAYLOAD_TOPIC), is_protected, sent: 0 })
    }

    /// Sends a payload and wakes who waits.
    pub fn send(&mut self) -> Result<(), MachineError> {
        self.sent = self.sent.wrapping_add(1);
        let (is_protected, sent) = (self.is_protected, self.sent);
        self.port.send(|bytes| {
            if is_protected {
                bytes.fill(sent as u8);
                profile7::protect(bytes, PAYLOAD_DATA_ID, sent);
            }
        })?;
        self.waker.wake();
        Ok(())
    }
}

#[derive(Debug)]
pub struct PayloadReceiver {
    port: BytesReceiver,
    waiter: Waker,
    is_protected: bool,
}

impl PayloadReceiver {
    pub fn open(guest: &Guest, bytes: usize, is_protected: bool) -> Result<Self, MachineError> {
        let (name, peers) = own(bytes);
        let port = BytesReceiver::open(guest, &name, peers)?;
        Ok(Self { port, waiter: guest.waker(PAYLOAD_TOPIC), is_protected })
    }

    /// Waits for payloads, at most for `timeout`. Hands the stamp of each one to `each`, after its check if it is
    /// protected.
    pub fn next(&self, timeout: Duration, mut each: impl FnMut(i64)) -> Result<(), MachineError> {
        let ticket = self.waiter.ticket();
        if self.take(&mut each)? {
            return Ok(());
        }
        self.waiter.wait(ticket, timeout).map_err(failed("wait for a payload"))?;
        self.take(&mut each).map(|_| ())
    }

    fn take(&self, each: &mut impl FnMut(i64)) -> Result<bool, MachineError> {
        self.port.take(|sent_ns, bytes| {
            if self.is_protected {
                profile7::check(bytes, PAYLOAD_DATA_ID)
                    .map_err(|reason| failed("accept a payload")(format!("{reason:?}")))?;
            }
            each(sent_ns);
            Ok(())
        })
    }
}
