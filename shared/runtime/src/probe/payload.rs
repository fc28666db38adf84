//! Payloads of any size, sent as a topic's large messages are.
//!
//! They take the same steps through the same node, iceoryx2 variant and wake-up: loaned, sent where they are, borrowed
//! by the reader. They are bare, or written, protected and checked in place.

use super::Probe;
use crate::transport::waking::{Waiter, Waker};
use crate::transport::{Ipc, TransportError, refused};
use crate::{RuntimeError, monotonic_ns};
use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use messages::e2e::profile7;
use messages::{Service, Topic};
use std::time::Duration;

/// Topic whose wake-up word the payloads use.
pub(super) const PAYLOAD_TOPIC: Topic = Topic::RadarTracks;

/// When a payload was sent, `CLOCK_MONOTONIC` ns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Stamp")]
struct Stamp {
    sent_ns: i64,
}

/// Payload bytes.
type Payload = [u8];

impl Probe {
    /// The iceoryx2 service of payloads of `bytes`, beside the one of the topic.
    fn payload_topic(
        &self,
        bytes: usize,
    ) -> Result<PortFactory<Ipc, Payload, Stamp>, RuntimeError> {
        let name = format!("bench/payload/{bytes}");
        self.node()
            .service(&name.as_str().try_into().expect("a valid service name"))
            .publish_subscribe::<Payload>()
            .user_header::<Stamp>()
            .max_publishers(1)
            .max_subscribers(1)
            // A sink that lags by more than this has lost the wake-ups anyway.
            .subscriber_max_buffer_size(4)
            .subscriber_max_borrowed_samples(1)
            .history_size(0)
            .open_or_create()
            .map_err(refused(PAYLOAD_TOPIC))
    }

    /// The sending end for payloads of `bytes`.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn payload_sender(
        &self,
        bytes: usize,
        contents: Contents,
    ) -> Result<PayloadSender, RuntimeError> {
        let port = (self.payload_topic(bytes)?.publisher_builder())
            .initial_max_slice_len(bytes)
            .create()
            .map_err(refused(PAYLOAD_TOPIC))?;
        let waker = self.node().waker(PAYLOAD_TOPIC);
        Ok(PayloadSender { port, waker, bytes, contents, sent: 0 })
    }

    /// The receiving end for payloads of `bytes`.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    pub fn payload_receiver(
        &self,
        bytes: usize,
        contents: Contents,
    ) -> Result<PayloadReceiver, RuntimeError> {
        let port = (self.payload_topic(bytes)?.subscriber_builder())
            .create()
            .map_err(refused(PAYLOAD_TOPIC))?;
        let waiter = self.transport.waiter(PAYLOAD_TOPIC);
        Ok(PayloadReceiver { port, waiter, contents })
    }
}

/// Data ID of protected payloads.
const PAYLOAD_DATA_ID: u32 = PAYLOAD_TOPIC.data_id(Service::PerceptionSim.to_wire());

/// Treatment of the bytes of a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Nothing: they are handed over.
    Bare,
    /// The sender writes and protects them, the reader checks them, all in place.
    Protected,
}

/// Sends payloads.
#[derive(Debug)]
pub struct PayloadSender {
    port: iceoryx2::port::publisher::Publisher<Ipc, Payload, Stamp>,
    waker: Waker,
    bytes: usize,
    contents: Contents,
    sent: u32,
}

impl PayloadSender {
    /// Loans a payload, stamps it with the time before the loan, sends it and wakes who waits.
    ///
    /// # Errors
    /// [`RuntimeError::Send`].
    #[expect(unsafe_code, reason = "a payload is not written to please the type")]
    pub fn send(&mut self) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Send { topic: PAYLOAD_TOPIC, reason };
        let sent_ns = monotonic_ns();
        let sample = self.port.loan_slice_uninit(self.bytes);
        let mut sample = sample.map_err(TransportError::iceoryx2).map_err(error)?;
        sample.user_header_mut().sent_ns = sent_ns;
        // SAFETY: the payload is a part of a file in memory, mapped by this process: it holds zeros or an
        // earlier payload.
        let mut sample = unsafe { sample.assume_init() };
        self.sent = self.sent.wrapping_add(1);
        if self.contents == Contents::Protected {
            let bytes = sample.payload_mut();
            bytes.fill(self.sent as u8);
            profile7::protect(bytes, PAYLOAD_DATA_ID, self.sent);
        }
        sample.send().map_err(TransportError::iceoryx2).map_err(error)?;
        self.waker.wake();
        Ok(())
    }
}

/// Receives payloads.
#[derive(Debug)]
pub struct PayloadReceiver {
    port: iceoryx2::port::subscriber::Subscriber<Ipc, Payload, Stamp>,
    waiter: Waiter,
    contents: Contents,
}

impl PayloadReceiver {
    /// Waits for payloads, at most for `timeout`; hands the stamp of each one to `each`, after its check
    /// if it is protected.
    ///
    /// # Errors
    /// [`RuntimeError::Receive`], also of a payload that does not pass its check.
    pub fn next(&self, timeout: Duration, mut each: impl FnMut(i64)) -> Result<(), RuntimeError> {
        let ticket = self.waiter.ticket();
        if self.take(&mut each)? {
            return Ok(());
        }
        let error = |reason| RuntimeError::Receive { topic: PAYLOAD_TOPIC, reason };
        let waited = self.waiter.wait(ticket, timeout);
        waited.map_err(|reason| error(TransportError::System { what: "waiting", reason }))?;
        self.take(&mut each).map(|_| ())
    }

    fn take(&self, each: &mut impl FnMut(i64)) -> Result<bool, RuntimeError> {
        let error = |reason| RuntimeError::Receive { topic: PAYLOAD_TOPIC, reason };
        let mut found = false;
        while let Some(sample) =
            self.port.receive().map_err(TransportError::iceoryx2).map_err(error)?
        {
            found = true;
            if self.contents == Contents::Protected {
                let checked = profile7::check(sample.payload(), PAYLOAD_DATA_ID);
                checked.map_err(|corrupted| error(TransportError::Corrupted(corrupted)))?;
            }
            each(sample.user_header().sent_ns);
        }
        Ok(found)
    }
}
