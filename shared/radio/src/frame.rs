//! A received frame.

use crate::clock::ClockDifference;

/// Longest frame, bytes.
pub const MAX_FRAME: usize = 1500;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    pub(crate) bytes: [u8; MAX_FRAME],
    pub(crate) length: u16,
    /// The sender's number, random at each start; `None` for other programs.
    pub sender: Option<u64>,
    /// Time of sending by the sender's wall clock, ns since the Unix epoch; of a capture, its stamp.
    pub sent_ns: Option<i64>,
    /// Time of receiving by this host's wall clock, ns since the Unix epoch; of a capture, its stamp.
    pub received_ns: i64,
    /// The sender's wall clock at its run time 0, ns since the Unix epoch; `None` if unknown.
    pub start_ns: Option<i64>,
    /// Difference of the sender's clock from this host's at the time of receiving; `None` if unknown. A
    /// capture has one clock.
    pub clock: Option<ClockDifference>,
}

impl Frame {
    /// A frame that was received at `received_ns` from an unknown sender; `None` above [`MAX_FRAME`] bytes.
    ///
    /// ```
    /// use radio::Frame;
    ///
    /// let frame = Frame::new(b"spatem", 1_000).expect("short enough");
    /// assert_eq!(frame.bytes(), b"spatem");
    /// assert_eq!(frame.travelled_ns(), None, "an unknown sender has no stamp");
    /// ```
    pub fn new(bytes: &[u8], received_ns: i64) -> Option<Self> {
        let mut room = [0; MAX_FRAME];
        room.get_mut(..bytes.len())?.copy_from_slice(bytes);
        let length = u16::try_from(bytes.len()).ok()?;
        let (sender, sent_ns, start_ns, clock) = (None, None, None, None);
        Some(Self { bytes: room, length, sender, sent_ns, received_ns, start_ns, clock })
    }

    /// Time from sending to receiving, ns, with its uncertainty; `None` if the clocks' difference is unknown.
    pub fn travelled_ns(&self) -> Option<(i64, i64)> {
        let (sent_ns, clock) = (self.sent_ns?, self.clock?);
        Some((self.received_ns - (sent_ns - clock.offset_ns), clock.uncertainty_ns))
    }

    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }
}
