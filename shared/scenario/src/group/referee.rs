//! `[referee]`: what the referee measures a drive against, and `[require]`: what a run must keep to count as completed
//! beside the referee's rules.

use scenario_derive::tables;

use crate::quantity::{AccelerationMagnitude, Distance, Share, Time, TimeConstant};

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

    /// Requirements on a run.
    pub struct Require {
        /// Largest share of the control cycles in which the backup of a law that is a program may drive. Beyond it the
        /// outcome is `driven_by_backup`.
        // A program in Python needs about 0.5 s to start again. This is 5 % of the default run of 10 s. Twice that leaves
        // room for late answers, and nine cycles of ten still belong to the law that is judged.
        pub max_backup_share: Share = 0.1,
        /// Largest lateral acceleration on a road with a plan, m/s². Beyond it the outcome is `requirement_broken`.
        // Drivers stay below 3 m/s² in curves: it is 1.3 times the largest design value of ISO 15622.
        pub max_lateral_mps2: AccelerationMagnitude = 3.0,
        /// Requirements that the drive is judged by: formulas over its signals, such as `always gap_m > 2`, or names,
        /// such as `min-gap:2`. A drive that breaks one has the outcome `requirement_broken`. docs/search.md lists
        /// both.
        pub formulas: Vec<String> = default,
    }
}

impl DesiredGap {
    /// At a speed of the ego, m.
    pub fn at(self, speed_mps: f64) -> f64 {
        match self {
            Self::Fixed { gap_m } => gap_m.value(),
            Self::Headway { time_headway_s, standstill_distance_m } => {
                time_headway_s.value() * speed_mps + standstill_distance_m.value()
            }
        }
    }
}
