//! Actions that take their time: profiles of speeds, arrivals of two entities together, cycles of traffic signals.

use serde::{Deserialize, Serialize};

use super::position::Position;

/// A row of speeds that an entity reaches one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedProfile {
    /// An entity whose speed is added to the speeds of the profile.
    pub relative_to: Option<usize>,
    /// The bounds come before the times. Without it, the entries are reached at their times, on straight lines.
    pub smooth: bool,
    pub bounds: Bounds,
    pub entries: Vec<SpeedEntry>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedEntry {
    /// The speed at its end, m/s.
    pub mps: f64,
    /// The time after the entry before, s. Without one it is reached as soon as the bounds allow.
    pub time_s: Option<f64>,
}

/// Bounds on driving; an infinite one is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Largest acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Largest deceleration, m/s², positive.
    pub deceleration_mps2: f64,
    /// Largest rate of the acceleration while the entity accelerates, m/s³.
    pub acceleration_rate_mps3: f64,
    /// Largest rate of the deceleration while the entity brakes, m/s³.
    pub deceleration_rate_mps3: f64,
    /// Largest speed, m/s.
    pub speed_mps: f64,
}

impl Bounds {
    pub const NONE: Self = Self {
        acceleration_mps2: f64::INFINITY,
        deceleration_mps2: f64::INFINITY,
        acceleration_rate_mps3: f64::INFINITY,
        deceleration_rate_mps3: f64::INFINITY,
        speed_mps: f64::INFINITY,
    };
}

/// An entity arrives at its goal when another one, the master, arrives at its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Meeting {
    pub master: usize,
    pub master_goal: Position,
    pub goal: Position,
    /// A distance from its goal within which the other entity has arrived, m.
    pub master_tolerance_m: f64,
    /// A distance from its goal within which the entity has arrived, m.
    pub tolerance_m: f64,
    /// The speed of the entity at its goal. Without one it is free.
    pub final_speed: Option<FinalSpeed>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinalSpeed {
    pub speed: SpeedTarget,
    /// The last part of the way, on which the entity has this speed already.
    pub steady: Option<Steady>,
}

/// The length of the last part of a way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Steady {
    /// A distance before the goal, m.
    Distance(f64),
    /// A time before the arrival, s.
    Time(f64),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalCycle {
    /// The place of the present phase's name among the script's values.
    pub controller: usize,
    /// The first phase begins then, ns since the start of the run.
    pub begins_ns: i64,
    /// Its phases, one after the other without end.
    pub phases: Vec<SignalPhase>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalPhase {
    pub name: String,
    pub duration_ns: u64,
    /// States of signals: the place of the signal among the script's values, and its state.
    pub states: Vec<(usize, String)>,
}

impl SignalCycle {
    /// The duration of all phases, ns.
    pub fn duration_ns(&self) -> u64 {
        self.until(self.phases.len())
    }

    /// The phase at a time after the first phase's beginning.
    pub fn phase_at(&self, since_ns: u64) -> Option<usize> {
        let mut rest_ns = since_ns.checked_rem(self.duration_ns())?;
        self.phases.iter().position(|phase| {
            let is_now = rest_ns < phase.duration_ns;
            rest_ns = rest_ns.saturating_sub(phase.duration_ns);
            is_now
        })
    }

    /// The time from the beginning of the first phase to that of another one, ns.
    pub fn until(&self, phase: usize) -> u64 {
        let before = self.phases.iter().take(phase);
        before.fold(0, |sum, phase| sum.saturating_add(phase.duration_ns))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpeedTarget {
    Absolute(f64),
    /// Another entity's speed times a factor, plus an offset.
    Relative {
        entity: usize,
        factor: f64,
        offset_mps: f64,
        continuous: bool,
    },
}
