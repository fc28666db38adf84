//! What the roadside unit sends, in the terms of SPATEM and MAPEM (SAE J2735).

use super::{Header, Topic, layout, message};
use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Most signals in one message.
pub const MAX_SIGNALS: usize = 8;
/// Most intervals announced for a signal, the current one included.
pub const MAX_INTERVALS: usize = 8;
/// Most lanes in one map.
pub const MAX_LANES: usize = 8;

/// Movement phase state, reduced to what a cruise controller tells apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhaseState {
    /// `unavailable` or `dark`: never to be treated as green.
    #[default]
    Unavailable = 0,
    /// `stop-And-Remain`.
    StopAndRemain = 3,
    /// `protected-Movement-Allowed`.
    ProtectedMovementAllowed = 6,
    /// `protected-clearance`.
    ProtectedClearance = 8,
}

impl PhaseState {
    /// Decodes the number carried by a message; an unknown one is [`PhaseState::Unavailable`].
    #[must_use]
    pub fn from_wire(value: u32) -> Self {
        match value {
            3 => Self::StopAndRemain,
            6 => Self::ProtectedMovementAllowed,
            8 => Self::ProtectedClearance,
            _ => Self::Unavailable,
        }
    }

    /// Number carried by a message: SAE J2735's value of the state.
    #[must_use]
    pub fn to_wire(self) -> u32 {
        self as u32
    }
}

/// One interval of a signal group's program, in run time.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Interval")]
pub struct Interval {
    /// Movement phase state, [`PhaseState`] as a number.
    pub state: u32,
    /// Confidence that `likely_end_s` holds, 0 to 15.
    pub confidence: u32,
    /// Earliest end, s of run time.
    pub min_end_s: f64,
    /// Likely end, s of run time.
    pub likely_end_s: f64,
    /// Latest end, s of run time.
    pub max_end_s: f64,
}

layout!(Interval { state, confidence, min_end_s, likely_end_s, max_end_s });

/// Timing of one signal group.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Signal")]
pub struct Signal {
    /// Intersection id.
    pub intersection_id: u32,
    /// Signal group id.
    pub signal_group: u32,
    /// Valid entries of `intervals`.
    pub count: u64,
    /// The current interval and those that follow.
    pub intervals: [Interval; MAX_INTERVALS],
}

layout!(Signal { intersection_id, signal_group, count, intervals });

/// Signal phase and timing of all signals within radio range.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Spat")]
pub struct Spat {
    /// Common header.
    pub header: Header,
    /// Valid entries of `signals`.
    pub count: u64,
    /// The signals, nearest first; unused entries are 0.
    pub signals: [Signal; MAX_SIGNALS],
}

message!(Spat, Topic::Spat);
layout!(Spat { header, count, signals });

/// Most cells of a road preview: 2 km in cells of 50 m, and some that the
/// vehicle passes meanwhile.
pub const MAX_PREVIEW_CELLS: usize = 48;

/// The road ahead as the map knows it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Preview")]
pub struct Preview {
    /// Common header.
    pub header: Header,
    /// Valid entries of `grades`: beyond them the map knows nothing.
    pub count: u64,
    /// Where the first cell begins on the ego's axis, m: at the ego or behind it.
    pub first_cell_m: f64,
    /// Length of a cell, m.
    pub cell_m: f64,
    /// Legal limit on the road, m/s, infinite when unknown.
    pub speed_limit_mps: f64,
    /// Mean grade of each cell, rise over run, positive uphill; unused entries are 0.
    pub grades: [f64; MAX_PREVIEW_CELLS],
}

message!(Preview, Topic::Preview);
layout!(Preview { header, count, first_cell_m, cell_m, speed_limit_mps, grades });

/// A lane's stop line and the signal group that governs it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Lane")]
pub struct Lane {
    /// Intersection id.
    pub intersection_id: u32,
    /// Signal group id.
    pub signal_group: u32,
    /// Position of the stop line on the ego's axis, m.
    pub stop_line_m: f64,
}

layout!(Lane { intersection_id, signal_group, stop_line_m });

/// Stop lines of all intersections within radio range.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Map")]
pub struct Map {
    /// Common header.
    pub header: Header,
    /// Valid entries of `lanes`.
    pub count: u64,
    /// The lanes, nearest first; unused entries are 0.
    pub lanes: [Lane; MAX_LANES],
}

message!(Map, Topic::Map);
layout!(Map { header, count, lanes });

/// All signals as they really are: the referee's copy, not limited by radio range.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/SignalTruth")]
pub struct SignalTruth {
    /// Common header.
    pub header: Header,
    /// Valid entries of `lanes` and `signals`, which belong together by index.
    pub count: u64,
    /// Stop lines.
    pub lanes: [Lane; MAX_LANES],
    /// Their signals.
    pub signals: [Signal; MAX_SIGNALS],
}

message!(SignalTruth, Topic::SignalTruth);
layout!(SignalTruth { header, count, lanes, signals });
