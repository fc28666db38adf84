//! `[[actors]]`: the other vehicles.

use scenario_derive::tables;

use crate::event::{ActorEvent, VEHICLE_WIDTH_M};
use crate::name::Name;
use crate::quantity::{
    Acceleration, AccelerationMagnitude, Distance, Duration, Lateral, Length, Speed, Time,
};
use crate::recorded::CsvFile;
use crate::speeds::{Cycle, SpeedPoint};

/// Most actors of a scenario: as many as the messages of a step carry.
pub const MAX_ACTORS: usize = messages::MAX_VEHICLES;
/// Most points of all speed tables of a scenario together, those of CSV files included.
pub const MAX_PROFILE_POINTS: usize = 20_000;

tables! {
    /// A vehicle other than the ego.
    pub struct Actor {
        /// Name, unique in the scenario.
        pub name: Name,
        /// Distance from the ego's front bumper to this vehicle's rear bumper when it appears, m.
        pub gap_m: Distance,
        /// Speed when it appears, m/s. Absent only where the profile is a table of speeds.
        pub initial_speed_mps: Option<Speed>,
        /// Highest speed that the profile may reach, m/s; absent: no cap.
        pub max_speed_mps: Option<Speed>,
        /// Length, m.
        pub length_m: Length = 4.5,
        /// Width, m.
        pub width_m: Length = VEHICLE_WIDTH_M,
        /// Lateral position of its centre when it appears, m from the centre of the ego's lane, left
        /// positive.
        pub lateral_offset_m: Lateral = 0.0,
        /// Time when it appears on the road, s.
        pub appears_at_s: Time = 0.0,
        /// Time when it leaves the road, s; absent: never.
        pub leaves_at_s: Option<Time>,
        /// Profile of its speed. Times count from the start of the run.
        pub profile: Profile = default,
        /// Lateral motions in order of time: a cut-in ends at 0, a cut-out beside the lane.
        pub lateral: Vec<LateralMotion> = sparse,
        /// Its events, beside keeping its speed.
        pub events: Vec<ActorEvent> = sparse,
    }

    /// Profile of an actor's speed.
    pub enum Profile {
        /// Keeps its initial speed.
        #[default]
        Constant,
        /// Approaches one target speed after the other, each with its own acceleration.
        Steps(Vec<SpeedStep>),
        /// Acceleration `amplitude * sin(2 pi (t - start) / period)` from `start` on.
        Sine(Sine),
        /// Acceleration constant by pieces, never below standstill.
        Piecewise(Vec<AccelerationPiece>),
        /// Speed interpolated between points of (time in s, speed in m/s); constant after the last.
        Speeds(Vec<SpeedPoint>),
        /// The same from a recorded motion: a CSV file, an MCAP file or a ROS bag.
        Csv(CsvFile),
        /// As the scenario's storyboard says: the n-th such actor is the n-th entity that it moves.
        Storyboard,
        /// As SUMO moves it: a place for one of the vehicles around the ego.
        Sumo,
        /// The speeds of a standard drive cycle.
        Cycle(Cycle),
    }

    /// From `time_s` on, the speed goes to `speed_mps` at the given rate.
    #[derive(Copy)]
    pub struct SpeedStep {
        /// Start of the change, s.
        pub time_s: Time,
        /// Speed to be reached, m/s.
        pub speed_mps: Speed,
        /// Rate of the change in either direction, m/s².
        pub acceleration_mps2: AccelerationMagnitude,
    }

    /// A sinusoidal acceleration.
    #[derive(Copy)]
    pub struct Sine {
        /// Amplitude of the acceleration, m/s².
        pub amplitude_mps2: Acceleration,
        /// Period, s.
        pub period_s: Duration,
        /// Start of the oscillation, s.
        pub start_s: Time = 0.0,
    }

    /// From `time_s` on, the acceleration is `acceleration_mps2`.
    #[derive(Copy)]
    pub struct AccelerationPiece {
        /// Start of the piece, s.
        pub time_s: Time,
        /// Acceleration during the piece, m/s².
        pub acceleration_mps2: Acceleration,
    }

    /// A change of the lateral position: a fifth-order curve with rest at both ends, or one at constant
    /// lateral speed.
    #[derive(Copy)]
    pub struct LateralMotion {
        /// Start, s.
        pub time_s: Time,
        /// Lateral position at the end, m, left positive.
        pub to_m: Lateral,
        /// Time that the motion takes, s.
        pub duration_s: Duration,
        /// Time in which the lateral speed rises evenly, then to stay until the end, s; absent: the
        /// fifth-order curve.
        pub rise_s: Option<Time>,
    }
}

impl Profile {
    /// The points of a table of speeds, when the profile is one.
    pub fn points(&self) -> Option<&[SpeedPoint]> {
        match self {
            Self::Speeds(points) | Self::Csv(CsvFile { points, .. }) => Some(points),
            Self::Cycle(cycle) => Some(cycle.points()),
            _ => None,
        }
    }
}

impl LateralMotion {
    /// The part of the way that is done at `time_s`, from 0 to 1, and how fast it grows, 1/s.
    pub fn progress(&self, time_s: f64) -> (f64, f64) {
        let duration_s = self.duration_s.value();
        let since_s = (time_s - self.time_s.value()).clamp(0.0, duration_s);
        let moves = since_s > 0.0 && since_s < duration_s;
        match self.rise_s.map(Time::value) {
            None => {
                let s = since_s / duration_s;
                let share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
                (share, 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration_s)
            }
            Some(rise_s) => {
                let whole_s = duration_s - rise_s / 2.0;
                let (done_s, speed) = if since_s < rise_s {
                    (since_s * since_s / (2.0 * rise_s), since_s / rise_s)
                } else {
                    (since_s - rise_s / 2.0, 1.0)
                };
                (done_s / whole_s, if moves { speed / whole_s } else { 0.0 })
            }
        }
    }
}
