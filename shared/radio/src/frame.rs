//! A received frame.

use crate::clock::ClockDifference;

/// Most bytes of a frame.
pub const MAX_FRAME: usize = 1500;

/// A frame as it was received.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    pub(crate) bytes: [u8; MAX_FRAME],
    pub(crate) length: u16,
    /// The sender's number, which it draws anew at each start; `None`: the sender is not timegap's.
    pub sender: Option<u64>,
    /// When it was sent, by the sender's wall clock, ns since the Unix epoch; of a capture: when it was
    /// captured.
    pub sent_ns: Option<i64>,
    /// When it was received, by this host's wall clock, ns since the Unix epoch; of a capture: when it was
    /// captured.
    pub received_ns: i64,
    /// The sender's wall clock at its run time 0, ns since the Unix epoch; `None`: it does not say.
    pub start_ns: Option<i64>,
    /// How far the sender's clock is from this host's, when the frame was received; `None`: not known. Of a
    /// capture the clocks are one.
    pub clock: Option<ClockDifference>,
}

impl Frame {
    /// A frame of at most [`MAX_FRAME`] bytes that was received at `received_ns`, of a sender that says
    /// nothing of itself; `None` if there are more.
    #[must_use]
    pub fn new(bytes: &[u8], received_ns: i64) -> Option<Self> {
        let mut room = [0; MAX_FRAME];
        room.get_mut(..bytes.len())?.copy_from_slice(bytes);
        let length = u16::try_from(bytes.len()).ok()?;
        let (sender, sent_ns, start_ns, clock) = (None, None, None, None);
        Some(Self { bytes: room, length, sender, sent_ns, received_ns, start_ns, clock })
    }

    /// Time from sending to receiving, ns, with its uncertainty; `None` where the clocks' difference is not
    /// known.
    #[must_use]
    pub fn travelled_ns(&self) -> Option<(i64, i64)> {
        let (sent_ns, clock) = (self.sent_ns?, self.clock?);
        Some((self.received_ns - (sent_ns - clock.offset_ns), clock.uncertainty_ns))
    }

    /// The frame's bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }
}

impl std::fmt::Debug for Frame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Frame")
            .field("bytes", &self.bytes())
            .field("sender", &self.sender)
            .field("sent_ns", &self.sent_ns)
            .field("received_ns", &self.received_ns)
            .field("start_ns", &self.start_ns)
            .field("clock", &self.clock)
            .finish()
    }
}
