//! Messages of the roadside unit, in the terms of SPATEM and MAPEM (SAE J2735).

use crate::layout::declare::*;
use crate::numbered;

/// Most signals in one message.
pub const MAX_SIGNALS: usize = 8;
/// Most intervals announced for a signal, the current one included.
pub const MAX_INTERVALS: usize = 8;
/// Most lanes in one map.
pub const MAX_LANES: usize = 8;

numbered! {
    /// Movement phase state, reduced to what a cruise controller distinguishes; numbers of SAE J2735.
    #[derive(Default)]
    pub enum PhaseState {
        /// `unavailable` or `dark`: never to be treated as green.
        #[default]
        Unavailable = 0 "unavailable",
        StopAndRemain = 3 "stop-and-remain",
        ProtectedMovementAllowed = 6 "protected-movement-allowed",
        ProtectedClearance = 8 "protected-clearance",
    }
}

impl PhaseState {
    /// State with this number in a message; an unknown number is [`PhaseState::Unavailable`].
    pub fn from_wire(number: u32) -> Self {
        Self::by_number(number).unwrap_or_default()
    }

    pub fn to_wire(self) -> u32 {
        self as u32
    }
}

layout! {
    /// One interval of a signal group's program, in run time.
    pub struct Interval "timegap_msgs/msg/Interval" {
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

    /// Timing of one signal group.
    pub struct Signal "timegap_msgs/msg/Signal" lists intervals: Interval {
        /// Intersection id.
        pub intersection_id: u32,
        /// Signal group id.
        pub signal_group: u32,
        /// Valid entries of `intervals`.
        pub count: u64,
        /// The current interval and those that follow.
        pub intervals: [Interval; MAX_INTERVALS],
    }

    /// Signal phase and timing of all signals within radio range.
    pub message Spat "timegap_msgs/msg/Spat" lists signals: Signal {
        /// Valid entries of `signals`.
        pub count: u64,
        /// The signals, nearest first; unused entries are 0.
        pub signals: [Signal; MAX_SIGNALS],
    }
}

/// Most cells of a road preview: 2 km in cells of 50 m, and some that the
/// vehicle passes meanwhile.
pub const MAX_PREVIEW_CELLS: usize = 48;
/// Most other vehicles with a radio.
pub const MAX_MOTIONS: usize = 8;

layout! {
    /// The road ahead by the map.
    pub message Preview "timegap_msgs/msg/Preview" lists grades: f64 {
        /// Valid entries of `grades`: beyond them the map is empty.
        pub count: u64,
        /// Beginning of the first cell on the ego's axis, m: at the ego or behind it.
        pub first_cell_m: f64,
        /// Length of a cell, m.
        pub cell_m: f64,
        /// Legal limit on the road, m/s, infinite when unknown.
        pub speed_limit_mps: f64,
        /// Mean grade of each cell, rise over run, positive uphill; unused entries are 0.
        pub grades: [f64; MAX_PREVIEW_CELLS],
    }

    /// A lane's stop line and the signal group that governs it.
    pub struct Lane "timegap_msgs/msg/Lane" {
        /// Intersection id.
        pub intersection_id: u32,
        /// Signal group id.
        pub signal_group: u32,
        /// Position of the stop line on the ego's axis, m.
        pub stop_line_m: f64,
    }

    /// Stop lines of all intersections within radio range.
    pub message Map "timegap_msgs/msg/Map" lists lanes: Lane {
        /// Valid entries of `lanes`.
        pub count: u64,
        /// The lanes, nearest first; unused entries are 0.
        pub lanes: [Lane; MAX_LANES],
    }

    /// The motion of another vehicle, which has a radio.
    pub struct AnnouncedMotion "timegap_msgs/msg/AnnouncedMotion" {
        /// Station id; 0 in an unused entry.
        pub station_id: u64,
        /// Time of the motion, ns of run time.
        pub made_ns: i64,
        /// Position of its rear on the ego's axis, m.
        pub rear_position_m: f64,
        /// Lateral position of its middle, m, left positive.
        pub lateral_m: f64,
        /// Speed, m/s.
        pub speed_mps: f64,
        /// Acceleration, m/s².
        pub acceleration_mps2: f64,
    }

    /// Motions of the vehicles within radio range, as they announce them.
    pub message AnnouncedMotions "timegap_msgs/msg/AnnouncedMotions" lists motions: AnnouncedMotion {
        /// Valid entries of `motions`.
        pub count: u64,
        /// The motions; unused entries are 0.
        pub motions: [AnnouncedMotion; MAX_MOTIONS],
    }

    /// Lights and vehicles with a radio as another simulator has them: not limited by radio range.
    pub message Lights "timegap_msgs/msg/Lights" lists lanes: Lane, signals: Signal {
        /// Valid entries of `lanes` and `signals`, which belong together by index.
        pub count: u64,
        /// Stop lines.
        pub lanes: [Lane; MAX_LANES],
        /// Their signals.
        pub signals: [Signal; MAX_SIGNALS],
        /// Vehicles with a radio; the station id of an unused entry is 0.
        pub motions: [AnnouncedMotion; MAX_MOTIONS],
    }

    /// All signals as they really are: the referee's copy, not limited by radio range.
    pub message SignalTruth "timegap_msgs/msg/SignalTruth" lists lanes: Lane, signals: Signal {
        /// Valid entries of `lanes` and `signals`, which belong together by index.
        pub count: u64,
        /// Stop lines.
        pub lanes: [Lane; MAX_LANES],
        /// Their signals.
        pub signals: [Signal; MAX_SIGNALS],
    }
}
