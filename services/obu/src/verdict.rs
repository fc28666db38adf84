//! The unit's verdict on each frame, and the counts of them.

use its::DecodeError;
use runtime::{Count, Figures, RuntimeError};
use std::collections::BTreeMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// New, and consistent with the rest.
    Accepted,
    /// Timing of a signal whose intersection has no map yet.
    UnknownIntersection,
    /// A map without a lane of the vehicle, or timing without the signal group of that lane.
    MissingLane,
    /// Older than the last used frame of its sender.
    OutOfOrder,
    /// The same bytes again.
    Duplicated,
    /// Made too long ago, or in the future, according to its stamps.
    TooOld,
    /// Inconsistent with another frame about the same intersection.
    Contradicting,
    /// Sent under the vehicle's own station id.
    SameStationId,
    /// A kind of message that the unit does not read.
    UnknownMessage,
    /// Signed, and the scenario ignores such frames.
    Signed,
    /// Headers or versions of another profile.
    OtherProfile,
    /// Not a frame.
    Malformed,
}

impl Verdict {
    /// All verdicts with their names in results, from the best to the worst.
    pub const ALL: [(Self, &str); 12] = [
        (Self::Accepted, "accepted"),
        (Self::UnknownIntersection, "unknown_intersection"),
        (Self::MissingLane, "missing_lane"),
        (Self::OutOfOrder, "out_of_order"),
        (Self::Duplicated, "duplicated"),
        (Self::TooOld, "too_old"),
        (Self::Contradicting, "contradicting"),
        (Self::SameStationId, "same_station_id"),
        (Self::UnknownMessage, "unknown_message"),
        (Self::Signed, "signed"),
        (Self::OtherProfile, "other_profile"),
        (Self::Malformed, "malformed"),
    ];
}

impl From<&DecodeError> for Verdict {
    fn from(error: &DecodeError) -> Self {
        match error {
            DecodeError::TooLong(_)
            | DecodeError::Truncated { .. }
            | DecodeError::Envelope(_)
            | DecodeError::Payload(_) => Self::Malformed,
            DecodeError::Version(_)
            | DecodeError::Secured
            | DecodeError::OtherHeader { .. }
            | DecodeError::ProtocolVersion { .. } => Self::OtherProfile,
            DecodeError::Port(_) | DecodeError::MessageId { .. } => Self::UnknownMessage,
        }
    }
}

#[derive(Debug)]
pub struct Verdicts(Vec<Count>);

impl Default for Verdicts {
    fn default() -> Self {
        Self::open(&Figures::default()).expect("memory of its own has room")
    }
}

impl Verdicts {
    /// The counts in `figures`: zero before the run.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room.
    pub fn open(figures: &Figures) -> Result<Self, RuntimeError> {
        let counts = Verdict::ALL.iter().map(|(_, name)| figures.count(name));
        counts.collect::<Result<_, _>>().map(Self)
    }

    pub fn count(&mut self, verdict: Verdict) {
        self.0[verdict as usize].add(1);
    }

    pub fn of(&self, verdict: Verdict) -> u64 {
        self.0[verdict as usize].get()
    }

    pub fn by_name(&self) -> BTreeMap<String, u64> {
        Verdict::ALL.iter().map(|(verdict, name)| ((*name).to_owned(), self.of(*verdict))).collect()
    }
}
