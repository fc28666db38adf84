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
use runtime::{Guest, Ipc, Waiter, Waker, monotonic_ns};
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

/// The iceoryx2 service of payloads of `bytes`, beside the one of the topic.
fn topic(guest: &Guest, bytes: usize) -> Result<PortFactory<Ipc, Payload, Stamp>, MachineError> {
    let name = format!("bench/payload/{bytes}");
    (guest.service(&name.as_str().try_into().expect("a valid service name")))
        .publish_subscribe::<Payload>()
        .user_header::<Stamp>()
        .max_publishers(1)
        .max_subscribers(1)
        // A sink that lags by more than this has lost the wake-ups anyway.
        .subscriber_max_buffer_size(4)
        .subscriber_max_borrowed_samples(1)
        .history_size(0)
        .open_or_create()
        .map_err(failed("open a service of payloads"))
}

const PAYLOAD_DATA_ID: u32 = PAYLOAD_TOPIC.data_id(Member::PerceptionSim.to_wire());

#[derive(Debug)]
pub struct PayloadSender {
    port: Publisher<Ipc, Payload, Stamp>,
    waker: Waker,
    bytes: usize,
    /// The sender writes and protects the bytes, the reader checks them, all in place.
    is_protected: bool,
    sent: u32,
}

impl PayloadSender {
    pub fn open(guest: &Guest, bytes: usize, is_protected: bool) -> Result<Self, MachineError> {
        let port = (topic(guest, bytes)?.publisher_builder())
            .initial_max_slice_len(bytes)
            .create()
            .map_err(failed("make a sender of payloads"))?;
        Ok(Self { port, waker: guest.waker(PAYLOAD_TOPIC), bytes, is_protected, sent: 0 })
    }

    /// Loans a payload, stamps it with the time before the loan, sends it and wakes who waits.
    #[expect(unsafe_code, reason = "a payload is not written to please the type")]
    pub fn send(&mut self) -> Result<(), MachineError> {
        let sent_ns = monotonic_ns();
        let sample = self.port.loan_slice_uninit(self.bytes);
        let mut sample = sample.map_err(failed("loan a payload"))?;
        sample.user_header_mut().sent_ns = sent_ns;
        // SAFETY: the payload is a part of a file in memory, mapped by this process. It holds zeros or an earlier
        // payload.
        let mut sample = unsafe { sample.assume_init() };
        self.sent = self.sent.wrapping_add(1);
        if self.is_protected {
            let bytes = sample.payload_mut();
            bytes.fill(self.sent as u8);
            profile7::protect(bytes, PAYLOAD_DATA_ID, self.sent);
        }
        sample.send().map_err(failed("send a payload"))?;
        self.waker.wake();
        Ok(())
    }
}

#[derive(Debug)]
pub struct PayloadReceiver {
    port: Subscriber<Ipc, Payload, Stamp>,
    waiter: Waiter,
    is_protected: bool,
}

impl PayloadReceiver {
    pub fn open(guest: &Guest, bytes: usize, is_protected: bool) -> Result<Self, MachineError> {
        let port = (topic(guest, bytes)?.subscriber_builder())
            .create()
            .map_err(failed("make a receiver of payloads"))?;
        Ok(Self { port, waiter: guest.waiter(PAYLOAD_TOPIC), is_protected })
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
        let mut found = false;
        while let Some(sample) = self.port.receive().map_err(failed("receive a payload"))? {
            found = true;
            if self.is_protected {
                profile7::check(sample.payload(), PAYLOAD_DATA_ID)
                    .map_err(|reason| failed("accept a payload")(format!("{reason:?}")))?;
            }
            each(sample.user_header().sent_ns);
        }
        Ok(found)
    }
}
