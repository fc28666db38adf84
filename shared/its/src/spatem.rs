//! SPATEM: signal phases and their timing (ETSI TS 103 301, SAE J2735 `SPAT`).

use crate::time::{Stamp, TimeMark};

/// Signal phase and timing of one or more intersections.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spatem {
    pub station_id: u32,
    /// The intersections, 1 to 32.
    pub intersections: Vec<IntersectionState>,
}

/// `IntersectionState`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IntersectionState {
    /// Road regulator, if the id is not unique without it.
    pub region: Option<u16>,
    pub id: u16,
    /// Revision of the map, 0 to 127.
    pub revision: u8,
    /// `IntersectionStatusObject`: bit n of the standard is bit n here; 0 is normal operation.
    pub status: u16,
    /// `moy` and `timeStamp`: time of the content.
    pub stamp: Option<Stamp>,
    /// The signal groups, 1 to 255.
    pub movements: Vec<MovementState>,
}

/// `MovementState`: one signal group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MovementState {
    pub signal_group: u8,
    /// The present phase and the next ones, 1 to 16.
    pub events: Vec<MovementEvent>,
}

/// `MovementEvent`: one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MovementEvent {
    pub state: MovementPhase,
    /// Time of its end.
    pub timing: Option<Timing>,
}

/// `TimeChangeDetails`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing {
    pub start: Option<TimeMark>,
    pub min_end: TimeMark,
    pub max_end: Option<TimeMark>,
    pub likely_end: Option<TimeMark>,
    /// Confidence in the likely end, 0 (21 %) to 15 (100 %).
    pub confidence: Option<u8>,
    /// Next start of this phase.
    pub next: Option<TimeMark>,
}

/// `MovementPhaseState`: all ten states of the standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum MovementPhase {
    /// Unknown or out of order.
    #[default]
    Unavailable = 0,
    Dark = 1,
    /// Flashing red: stop, then go.
    StopThenProceed = 2,
    StopAndRemain = 3,
    /// Red and yellow: not yet.
    PreMovement = 4,
    /// Green, give way to conflicting traffic.
    PermissiveMovementAllowed = 5,
    /// Green, no conflicting traffic.
    ProtectedMovementAllowed = 6,
    /// Yellow after a permissive green.
    PermissiveClearance = 7,
    /// Yellow after a protected green.
    ProtectedClearance = 8,
    /// Flashing yellow.
    CautionConflictingTraffic = 9,
}

impl MovementPhase {
    /// All states, in the order of their numbers.
    pub const ALL: [Self; 10] = [
        Self::Unavailable,
        Self::Dark,
        Self::StopThenProceed,
        Self::StopAndRemain,
        Self::PreMovement,
        Self::PermissiveMovementAllowed,
        Self::ProtectedMovementAllowed,
        Self::PermissiveClearance,
        Self::ProtectedClearance,
        Self::CautionConflictingTraffic,
    ];
}
