//! `[v2x]`: the roadside unit and its signals.

use scenario_derive::tables;

use crate::quantity::{
    Distance, Duration, IntersectionId, MapShift, Percent, PeriodMs, Reach, SignalGroupId, Time,
};
use crate::radio::{Air, Obu, Origin, Radio, Unit};

/// Most signals of a scenario.
pub const MAX_SIGNALS: usize = 64;
pub const MAX_PROGRAM_PHASES: usize = 64;

tables! {
    /// The simulated roadside unit.
    pub struct V2x {
        /// Period of `v2x/spat` and `v2x/map`, ms.
        pub period_ms: PeriodMs = 100,
        /// Period in which frames of other hosts are looked for and handed on, ms; absent: `plant.period_ms`.
        pub poll_ms: Option<PeriodMs>,
        /// Signals farther ahead of the ego than this are not received, m.
        pub range_m: Reach = 300.0,
        /// Way of the signals to the vehicle. `direct`: as structs. `frames`: as SPATEM and MAPEM of the simulated
        /// units. Else it is the address of a carrier of other units' frames: `udp://ADDRESS:PORT`, `zenoh`,
        /// `zenoh:FILE.json5`, `pcap:FILE`.
        pub radio: Radio = sparse,
        /// The signals along the road, in order of their stop lines.
        pub signals: Vec<Signal> = default,
        /// The map of the road ahead, with its faults.
        pub preview: Preview = sparse,
        /// Place of the road on the Earth, with frames.
        pub origin: Origin = sparse,
        /// The air between roadside units and vehicle, with frames.
        pub air: Air = sparse,
        /// Errors of the roadside units, with frames.
        pub unit: Unit = sparse,
        /// The on-board unit, with frames.
        pub obu: Obu = sparse,
    }

    /// Faults of the maps. Without any they are exact.
    #[derive(Copy)]
    pub struct Preview {
        /// Distance by which everything on the maps is too far ahead, m.
        pub shift_m: MapShift = 0.0,
        /// Standard deviation of an error of each cell, made from the run's seed. A grade's is in percentage points, a
        /// curvature's in percent of it.
        pub noise_percent: Percent = 0.0,
        /// End of the maps, m; absent: they have no end.
        pub ends_at_m: Option<Distance>,
    }

    /// A signal group on the ego's lane with a fixed-time program.
    pub struct Signal {
        /// Position of the stop line along the road, m from the ego's front bumper at the start.
        pub stop_line_m: Distance,
        /// Id of the intersection.
        pub intersection_id: IntersectionId,
        /// Id of the signal group, 1 when absent.
        pub signal_group: SignalGroupId = 1,
        /// Time by which the program is ahead at the start of the run, s. Its first phase begins that much before t =
        /// 0.
        pub offset_s: Time = 0.0,
        /// `true`: the program repeats for ever. `false`: it runs once and its last phase stays.
        pub repeat: bool = true,
        /// The phases in their order.
        pub program: Vec<ProgramPhase>,
    }

    /// One phase of a program.
    #[derive(Copy)]
    pub struct ProgramPhase {
        /// Colour of the signal.
        pub phase: Phase,
        /// Duration, s.
        pub duration_s: Duration,
    }

    /// Colour of a signal.
    pub enum Phase {
        /// Go.
        Green,
        /// Stop if that is comfortable.
        Yellow,
        /// Stop.
        Red,
    }
}
