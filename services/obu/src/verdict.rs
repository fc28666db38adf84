//! The unit's verdict on each frame, and the counts of them.

use its::DecodeError;
use messages::numbered;
use runtime::{Count, Figures, RuntimeError};
use std::collections::BTreeMap;

numbered! {
    /// A verdict on a frame, from the best to the worst.
    #[derive(PartialOrd, Ord)]
    pub enum Verdict {
        /// New, and consistent with the rest.
        Accepted = 0 "accepted",
        /// Timing of a signal whose intersection has no map yet.
        UnknownIntersection = 1 "unknown_intersection",
        /// A map without a lane of the vehicle, or timing without the signal group of that lane.
        MissingLane = 2 "missing_lane",
        /// Older than the last used frame of its sender.
        OutOfOrder = 3 "out_of_order",
        /// The same bytes again.
        Duplicated = 4 "duplicated",
        /// Made too long ago, or in the future, according to its stamps.
        TooOld = 5 "too_old",
        /// Inconsistent with another frame about the same intersection.
        Contradicting = 6 "contradicting",
        /// Sent under the vehicle's own station id.
        SameStationId = 7 "same_station_id",
        /// A kind of message that the unit does not read.
        UnknownMessage = 8 "unknown_message",
        /// Signed, and the scenario ignores such frames.
        Signed = 9 "signed",
        /// Headers or versions of another profile.
        OtherProfile = 10 "other_profile",
        /// Not a frame.
        Malformed = 11 "malformed",
    }
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
        let counts = Verdict::ALL.iter().map(|verdict| figures.count(verdict.name()));
        counts.collect::<Result<_, _>>().map(Self)
    }

    pub fn count(&mut self, verdict: Verdict) {
        self.0[verdict as usize].add(1);
    }

    pub fn of(&self, verdict: Verdict) -> u64 {
        self.0[verdict as usize].get()
    }

    pub fn by_name(&self) -> BTreeMap<String, u64> {
        Verdict::ALL.iter().map(|verdict| (verdict.name().to_owned(), self.of(*verdict))).collect()
    }
}
