//! `[referee]`: what the referee measures a drive against.

use scenario_derive::tables;

use crate::quantity::{Distance, Time, TimeConstant};

tables! {
    /// The referee.
    pub struct Referee {
        /// Gap from which the gap errors of every law are measured. If absent, it is a time headway of 1.5 s and 5 m.
        pub desired_gap: Option<DesiredGap>,
        /// The run ends once the ego is clear of all others; absent: it lasts `duration_s` whatever they do.
        pub ends_when_clear: Option<EndsWhenClear>,
    }

    /// The ego is clear if no other vehicle comes nearer to it. Those ahead are then at least as fast as the ego, and
    /// those behind at most as fast. None is beside it, in any lane.
    #[derive(Copy)]
    pub struct EndsWhenClear {
        /// Not before this time: what the scenario has in store is over by then, s.
        pub after_s: Time,
        /// Time for which this holds without a break, s.
        pub for_s: Time,
    }

    /// A desired gap over the ego's speed.
    #[derive(Copy)]
    pub enum DesiredGap {
        /// The same at every speed.
        Fixed {
            /// Gap, m.
            gap_m: Distance,
        },
        /// A time headway and a distance at standstill.
        Headway {
            /// Time headway, s.
            time_headway_s: TimeConstant,
            /// Gap at standstill, m.
            standstill_distance_m: Distance,
        },
    }
}

impl DesiredGap {
    /// At a speed of the ego, m.
    #[must_use]
    pub fn at(self, speed_mps: f64) -> f64 {
        match self {
            Self::Fixed { gap_m } => gap_m.value(),
            Self::Headway { time_headway_s, standstill_distance_m } => {
                time_headway_s.value() * speed_mps + standstill_distance_m.value()
            }
        }
    }
}
