//! `[perception]`: radar, tracker and target selection.

use serde::{Deserialize, Serialize};

use super::quantity::{
    Angle, DelayMs, Length, PeriodMs, Probability, Reach, Sigma, SigmaMultiple, Time, TimeConstant,
};

/// Longest latency of the radar, in scans.
pub const MAX_LATENCY_SCANS: u32 = 32;

/// The simulated perception.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Perception {
    /// Period of the radar and of `radar/tracks`, ms.
    pub period_ms: PeriodMs,
    /// Exact tracks: the true gap, speed and acceleration at once, without noise, dropout, latency
    /// or filter. Range and field of view still bound what is seen.
    pub ideal: bool,
    /// What the radar sees and how well.
    pub radar: Radar,
    /// The Kalman filter behind each track.
    pub tracker: Tracker,
    /// Which track is the target.
    pub target_selection: TargetSelection,
}

impl Perception {
    /// True if the radar gives detections.
    #[must_use]
    pub fn gives_detections(&self) -> bool {
        false
    }
}

impl Default for Perception {
    fn default() -> Self {
        Self {
            period_ms: PeriodMs::of(50),
            ideal: false,
            radar: Radar::default(),
            tracker: Tracker::default(),
            target_selection: TargetSelection::default(),
        }
    }
}

/// The radar at the middle of the ego's front bumper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Radar {
    /// Farthest detection, m.
    pub max_range_m: Reach,
    /// Full opening angle, degrees, symmetric to the ego's axis.
    pub field_of_view_deg: Angle,
    /// Standard deviation of the range, m.
    pub range_sigma_m: Sigma,
    /// Standard deviation of the range rate, m/s.
    pub range_rate_sigma_mps: Sigma,
    /// Standard deviation of the azimuth, degrees.
    pub azimuth_sigma_deg: Sigma,
    /// Probability that a visible object is missing from one scan.
    pub dropout_probability: Probability,
    /// Time from the acquisition to the publication of a scan, ms: a multiple of the period.
    pub latency_ms: DelayMs,
}

impl Default for Radar {
    fn default() -> Self {
        Self {
            max_range_m: Reach::of(150.0),
            field_of_view_deg: Angle::of(60.0),
            range_sigma_m: Sigma::of(0.4),
            range_rate_sigma_mps: Sigma::of(0.15),
            azimuth_sigma_deg: Sigma::of(0.3),
            dropout_probability: Probability::of(0.0),
            latency_ms: DelayMs::of(0),
        }
    }
}

/// Kalman filter on gap, relative speed and lead acceleration, with Singer's model of the latter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tracker {
    /// Standard deviation of the lead's acceleration, m/s².
    pub lead_acceleration_sigma_mps2: Sigma,
    /// Correlation time of the lead's acceleration, s.
    pub maneuver_time_constant_s: TimeConstant,
    /// A measurement farther off than this many standard deviations is not used.
    pub gate_sigma: SigmaMultiple,
    /// A track without measurement is dropped after this time, s.
    pub coast_s: Time,
}

impl Default for Tracker {
    fn default() -> Self {
        Self {
            lead_acceleration_sigma_mps2: Sigma::of(0.5),
            maneuver_time_constant_s: TimeConstant::of(2.5),
            gate_sigma: SigmaMultiple::of(5.0),
            coast_s: Time::of(0.5),
        }
    }
}

/// The target is the nearest vehicle in the ego's path; entering and leaving the path have
/// different limits, so that a vehicle on the line does not flicker.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TargetSelection {
    /// A vehicle is in the path when its centre is nearer to the lane's centre than this, m.
    pub enter_half_width_m: Length,
    /// A vehicle in the path leaves it when its centre is farther off than this, m.
    pub leave_half_width_m: Length,
    /// A vehicle must be in the path for this time before it becomes the target, s.
    pub confirm_s: Time,
}

impl Default for TargetSelection {
    fn default() -> Self {
        Self {
            enter_half_width_m: Length::of(1.6),
            leave_half_width_m: Length::of(2.2),
            confirm_s: Time::of(0.1),
        }
    }
}
