//! `[v2x]`: the roadside unit and its signals.

use serde::{Deserialize, Serialize};

use super::preview::Preview;
use super::quantity::{Distance, Duration, IntersectionId, PeriodMs, Reach, SignalGroupId, Time};
use super::radio::{Air, Obu, Origin, Radio, Unit};
use super::schema::Schema;

/// Most signals of a scenario.
pub const MAX_SIGNALS: usize = 64;
/// Most phases of one program.
pub const MAX_PROGRAM_PHASES: usize = 64;

/// The simulated roadside unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct V2x {
    /// Period of `v2x/spat` and `v2x/map`, ms.
    pub period_ms: PeriodMs,
    /// Period in which frames of other hosts are looked for and handed on, ms; absent: `plant.period_ms`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poll_ms: Option<PeriodMs>,
    /// Signals farther ahead of the ego than this are not received, m.
    pub range_m: Reach,
    /// Way of the signals to the vehicle. `direct`: as structs. `frames`: as SPATEM and MAPEM of the simulated units.
    /// Else it is the address of a carrier of other units' frames: `udp://ADDRESS:PORT`, `zenoh`, `zenoh:FILE.json5`,
    /// `pcap:FILE`.
    #[serde(skip_serializing_if = "Radio::is_direct")]
    pub radio: Radio,
    /// The signals along the road, in order of their stop lines.
    pub signals: Vec<Signal>,
    /// The map of the road ahead, with its faults.
    #[serde(skip_serializing_if = "Preview::is_right")]
    pub preview: Preview,
    /// Place of the road on the Earth, with frames.
    #[serde(skip_serializing_if = "Origin::is_usual")]
    pub origin: Origin,
    /// The air between roadside units and vehicle, with frames.
    #[serde(skip_serializing_if = "Air::is_right")]
    pub air: Air,
    /// Errors of the roadside units, with frames.
    #[serde(skip_serializing_if = "Unit::is_right")]
    pub unit: Unit,
    /// The on-board unit, with frames.
    #[serde(skip_serializing_if = "Obu::is_usual")]
    pub obu: Obu,
}

impl Default for V2x {
    fn default() -> Self {
        Self {
            period_ms: PeriodMs::of(100),
            poll_ms: None,
            range_m: Reach::of(300.0),
            radio: Radio::default(),
            signals: Vec::new(),
            preview: Preview::default(),
            origin: Origin::default(),
            air: Air::default(),
            unit: Unit::default(),
            obu: Obu::default(),
        }
    }
}

/// A signal group on the ego's lane with a fixed-time program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// Position of the stop line along the road, m from the ego's front bumper at the start.
    pub stop_line_m: Distance,
    /// Id of the intersection.
    pub intersection_id: IntersectionId,
    /// Id of the signal group, 1 when absent.
    #[serde(default = "first_group")]
    pub signal_group: SignalGroupId,
    /// Time by which the program is ahead at the start of the run, s. Its first phase begins that much before t = 0.
    #[serde(default = "no_offset")]
    pub offset_s: Time,
    /// `true`: the program repeats for ever. `false`: it runs once and its last phase stays.
    #[serde(default = "yes")]
    pub repeat: bool,
    /// The phases in their order.
    pub program: Vec<ProgramPhase>,
}

/// One phase of a program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct ProgramPhase {
    /// Colour of the signal.
    pub phase: Phase,
    /// Duration, s.
    pub duration_s: Duration,
}

/// Colour of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Go.
    Green,
    /// Stop if that is comfortable.
    Yellow,
    /// Stop.
    Red,
}

fn first_group() -> SignalGroupId {
    SignalGroupId::of(1)
}

fn no_offset() -> Time {
    Time::of(0.0)
}

fn yes() -> bool {
    true
}
