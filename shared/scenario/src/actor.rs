//! `[[actors]]`: the other vehicles.

use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::event::{ActorEvent, VEHICLE_WIDTH_M};
use super::name::Name;
use super::quantity::{
    Acceleration, AccelerationMagnitude, Distance, Duration, Lateral, Length, Speed, Time,
};
use super::recorded::CsvFile;
use super::schema::Schema;
use super::speeds::SpeedPoint;

/// Most actors of a scenario: as many as the messages of a step carry.
pub const MAX_ACTORS: usize = messages::MAX_VEHICLES;
/// Most points of all speed tables of a scenario together, those of CSV files included.
pub const MAX_PROFILE_POINTS: usize = 20_000;

/// A vehicle other than the ego.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct Actor {
    /// Name, unique in the scenario.
    pub name: Name,
    /// Distance from the ego's front bumper to this vehicle's rear bumper when it appears, m.
    pub gap_m: Distance,
    /// Speed when it appears, m/s. Absent only where the profile is a table of speeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_speed_mps: Option<Speed>,
    /// Highest speed that the profile may reach, m/s; absent: no cap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_mps: Option<Speed>,
    /// Length, m.
    #[serde(default = "car_length")]
    pub length_m: Length,
    /// Width, m.
    #[serde(default = "car_width")]
    pub width_m: Length,
    /// Lateral position of its centre when it appears, m from the centre of the ego's lane, left
    /// positive.
    #[serde(default = "in_lane")]
    pub lateral_offset_m: Lateral,
    /// Time when it appears on the road, s.
    #[serde(default = "at_start")]
    pub appears_at_s: Time,
    /// Time when it leaves the road, s; absent: never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leaves_at_s: Option<Time>,
    /// Profile of its speed. Times count from the start of the run.
    #[serde(default)]
    pub profile: Profile,
    /// Lateral motions in order of time: a cut-in ends at 0, a cut-out beside the lane.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lateral: Vec<LateralMotion>,
    /// Its events, beside keeping its speed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<ActorEvent>,
}

/// Profile of an actor's speed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
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
    /// The speeds of a standard drive cycle.
    Cycle(Cycle),
}

impl Profile {
    /// The points of a table of speeds, when the profile is one.
    #[must_use]
    pub fn points(&self) -> Option<&[SpeedPoint]> {
        match self {
            Self::Speeds(points) | Self::Csv(CsvFile { points, .. }) => Some(points),
            Self::Cycle(cycle) => Some(cycle.points()),
            Self::Constant
            | Self::Steps(_)
            | Self::Sine(_)
            | Self::Piecewise(_)
            | Self::Storyboard => None,
        }
    }
}

/// From `time_s` on, the speed goes to `speed_mps` at the given rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct SpeedStep {
    /// Start of the change, s.
    pub time_s: Time,
    /// Speed to be reached, m/s.
    pub speed_mps: Speed,
    /// Rate of the change in either direction, m/s².
    pub acceleration_mps2: AccelerationMagnitude,
}

/// A sinusoidal acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Amplitude of the acceleration, m/s².
    pub amplitude_mps2: Acceleration,
    /// Period, s.
    pub period_s: Duration,
    /// Start of the oscillation, s.
    #[serde(default = "at_start")]
    pub start_s: Time,
}

/// From `time_s` on, the acceleration is `acceleration_mps2`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct AccelerationPiece {
    /// Start of the piece, s.
    pub time_s: Time,
    /// Acceleration during the piece, m/s².
    pub acceleration_mps2: Acceleration,
}

/// A change of the lateral position: a fifth-order curve with rest at both ends, or one at constant
/// lateral speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct LateralMotion {
    /// Start, s.
    pub time_s: Time,
    /// Lateral position at the end, m, left positive.
    pub to_m: Lateral,
    /// Time that the motion takes, s.
    pub duration_s: Duration,
    /// Time in which the lateral speed rises evenly, then to stay until the end, s; absent: the
    /// fifth-order curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rise_s: Option<Time>,
}

impl LateralMotion {
    /// The part of the way that is done at `time_s`, from 0 to 1, and how fast it grows, 1/s.
    #[must_use]
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

fn car_length() -> Length {
    Length::of(4.5)
}

fn car_width() -> Length {
    Length::of(VEHICLE_WIDTH_M)
}

fn in_lane() -> Lateral {
    Lateral::of(0.0)
}

fn at_start() -> Time {
    Time::of(0.0)
}
