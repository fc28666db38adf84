//! Profiles of speeds over time.

use serde::{Deserialize, Serialize};

/// A row of speeds that an entity reaches one after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedProfile {
    /// An entity whose speed is added to the speeds of the profile.
    pub relative_to: Option<usize>,
    /// The bounds come before the times. Without it, the entries are reached at their times, on straight lines.
    pub smooth: bool,
    /// Bounds on the way.
    pub bounds: Bounds,
    /// The speeds, in order.
    pub entries: Vec<SpeedEntry>,
}

/// A speed of a profile.
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
    /// No bounds.
    pub const NONE: Self = Self {
        acceleration_mps2: f64::INFINITY,
        deceleration_mps2: f64::INFINITY,
        acceleration_rate_mps3: f64::INFINITY,
        deceleration_rate_mps3: f64::INFINITY,
        speed_mps: f64::INFINITY,
    };
}
