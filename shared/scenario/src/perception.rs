//! `[perception]`: radar, tracker and target selection.

use serde::{Deserialize, Serialize};

use super::course::Course;
use super::problem::Problem;
use super::quantity::{
    Angle, Count, CrossSection, Decibels, DelayMs, Length, Loss, MeanCount, PerKilometre, PeriodMs,
    Probability, Reach, Sigma, SigmaMultiple, Speed, Time, TimeConstant,
};
use super::refusal::{Explained, read_from};
use super::schema::{Schema, Shape};

/// Longest latency of the radar, in scans.
pub const MAX_LATENCY_SCANS: u32 = 32;

/// The simulated perception.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Perception {
    /// Period of the radar and of `radar/tracks`, ms.
    pub period_ms: PeriodMs,
    /// The same as `radar.model = "ideal"`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ideal: bool,
    /// The radar: its range, field of view and errors.
    pub radar: Radar,
    /// The tracker behind the radar.
    pub tracker: Tracker,
    /// Choice of the target track.
    pub target_selection: TargetSelection,
    /// The path ahead, on a road with a plan.
    #[serde(skip_serializing_if = "Course::is_usual")]
    pub course: Course,
}

impl Default for Perception {
    fn default() -> Self {
        Self {
            period_ms: PeriodMs::of(50),
            ideal: false,
            radar: Radar::default(),
            tracker: Tracker::default(),
            target_selection: TargetSelection::default(),
            course: Course::default(),
        }
    }
}

impl Perception {
    /// Makes one of the two keys that say how deep the simulation of the radar goes.
    pub(super) fn unite(&mut self, is_written: impl Fn(&str) -> bool) -> Result<(), Problem> {
        const KEYS: [&str; 2] = ["perception.ideal", "perception.radar.model"];
        if self.ideal && self.radar.model != RadarModel::Ideal && KEYS.into_iter().all(is_written) {
            let message = "perception.ideal = true says another model of the radar";
            let expected = "perception.radar.model = \"ideal\", or perception.ideal = false";
            return Err(Problem::new(KEYS[1], message, expected).against(KEYS[0]));
        }
        self.radar.model = self.model();
        Ok(())
    }

    /// Depth of the simulation of the radar.
    #[must_use]
    pub fn model(&self) -> RadarModel {
        if self.ideal { RadarModel::Ideal } else { self.radar.model }
    }

    /// True if the radar gives detections.
    #[must_use]
    pub fn gives_detections(&self) -> bool {
        self.model() == RadarModel::Detections
    }
}

/// Depth of the simulation of the radar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum RadarModel {
    /// Detections as a radar's receiver hands them out, with the tracker that works on them alone.
    #[default]
    Detections,
    /// One noisy measurement for each vehicle, with its identity.
    ObjectList,
    /// Exact tracks: the true gap, speed and acceleration at once, without noise, dropout, latency
    /// or filter. Range and field of view still bound what is seen.
    Ideal,
}

/// The radar at the middle of the ego's front bumper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Radar {
    /// Depth of the simulation.
    pub model: RadarModel,
    /// Farthest detection, m.
    pub max_range_m: Reach,
    /// Full opening angle, degrees, symmetric to the ego's axis.
    pub field_of_view_deg: Angle,
    /// Standard deviation of the range, m. For the model `object-list`; in `detections` it follows from the
    /// signal-to-noise ratio. So do the next two.
    pub range_sigma_m: Sigma,
    /// Standard deviation of the range rate, m/s.
    pub range_rate_sigma_mps: Sigma,
    /// Standard deviation of the azimuth, degrees.
    pub azimuth_sigma_deg: Sigma,
    /// Probability that a visible vehicle, or an object beside the road, is missing from one scan. It does not depend
    /// on its echoes.
    pub dropout_probability: Probability,
    /// Time from the acquisition to the publication of a scan, ms: a multiple of the period.
    pub latency_ms: DelayMs,
    /// Parameters of the model `detections`.
    pub detections: Detections,
}

impl Default for Radar {
    fn default() -> Self {
        Self {
            model: RadarModel::default(),
            max_range_m: Reach::of(150.0),
            field_of_view_deg: Angle::of(60.0),
            range_sigma_m: Sigma::of(0.4),
            range_rate_sigma_mps: Sigma::of(0.15),
            azimuth_sigma_deg: Sigma::of(0.3),
            dropout_probability: Probability::of(0.0),
            latency_ms: DelayMs::of(0),
            detections: Detections::default(),
        }
    }
}

/// Detections as a radar's receiver hands them out. Accuracy and resolution are those of a 77 GHz
/// radar for cruise control with 0.2 to 0.3 GHz of bandwidth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Detections {
    /// Signal-to-noise ratio of 1 m² at 100 m on the axis, dB.
    pub snr_at_100_m_db: Decibels,
    /// Loss of an echo at the edge of the field of view against the axis, dB, both ways.
    pub edge_loss_db: Loss,
    /// An echo is detected when it and the noise exceed the mean noise by this, dB.
    pub threshold_db: Decibels,
    /// Mean radar cross section of a car's rear, dB relative to 1 m² (ISO 15622's target: 10 m²).
    pub car_rcs_dbsm: CrossSection,
    /// Mean radar cross section of a vehicle longer than 7 m, dB relative to 1 m².
    pub lorry_rcs_dbsm: CrossSection,
    /// Fluctuation of the cross section from scan to scan: Swerling's case 0 (none), 1 or 3.
    pub swerling: Swerling,
    /// Echoes nearer than this in range, and in range rate and azimuth, may merge, m.
    pub range_resolution_m: Length,
    /// The same in range rate, m/s.
    pub range_rate_resolution_mps: Speed,
    /// The same in azimuth, degrees.
    pub azimuth_resolution_deg: Angle,
    /// Echoes that the resolution does not keep apart come out as one.
    pub merge: bool,
    /// Standard deviation of the range that no signal-to-noise ratio improves, m.
    pub range_floor_m: Sigma,
    /// The same for the range rate, m/s.
    pub range_rate_floor_mps: Sigma,
    /// The same for the azimuth, degrees.
    pub azimuth_floor_deg: Sigma,
    /// Loss of the echo of a vehicle that a nearer one hides, dB; 0: no vehicle hides another.
    pub hidden_loss_db: Loss,
    /// Mean number of detections of noise in a scan.
    pub false_alarms_per_scan: MeanCount,
    /// Standing objects on each side of the road, per km.
    pub standing_objects_per_km: PerKilometre,
    /// Their mean radar cross section, dB relative to 1 m².
    pub standing_object_rcs_dbsm: CrossSection,
    /// Distance of guard rails and standing objects from the centre of the ego's lane, m.
    pub roadside_offset_m: Length,
    /// Probability of a second echo from under the body of a vehicle.
    pub under_body_probability: Probability,
    /// Mean of its additional range, m.
    pub under_body_range_m: Length,
    /// Its loss against the first echo, dB.
    pub under_body_loss_db: Loss,
    /// Share of the road with a guard rail on either side, in which vehicles have mirror images.
    pub guard_rail_share: Probability,
    /// Loss of a mirror image, dB.
    pub guard_rail_loss_db: Loss,
}

impl Default for Detections {
    fn default() -> Self {
        Self {
            snr_at_100_m_db: Decibels::of(15.0),
            edge_loss_db: Loss::of(6.0),
            threshold_db: Decibels::of(12.0),
            car_rcs_dbsm: CrossSection::of(10.0),
            lorry_rcs_dbsm: CrossSection::of(16.0),
            swerling: Swerling::Case1,
            range_resolution_m: Length::of(0.75),
            range_rate_resolution_mps: Speed::of(0.2),
            azimuth_resolution_deg: Angle::of(3.0),
            merge: true,
            range_floor_m: Sigma::of(0.1),
            range_rate_floor_mps: Sigma::of(0.03),
            azimuth_floor_deg: Sigma::of(0.1),
            hidden_loss_db: Loss::of(20.0),
            false_alarms_per_scan: MeanCount::of(0.5),
            standing_objects_per_km: PerKilometre::of(50.0),
            standing_object_rcs_dbsm: CrossSection::of(0.0),
            roadside_offset_m: Length::of(8.0),
            under_body_probability: Probability::of(0.3),
            under_body_range_m: Length::of(1.5),
            under_body_loss_db: Loss::of(10.0),
            guard_rail_share: Probability::of(0.5),
            guard_rail_loss_db: Loss::of(18.0),
        }
    }
}

/// Swerling's cases that a scan can distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "i64")]
pub enum Swerling {
    /// No fluctuation.
    Case0,
    /// Many equal parts.
    Case1,
    /// One strong part among many.
    Case3,
}

/// A number that is not a case of Swerling's that applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} is out of range, expected {CASES}")]
pub struct NoSwerlingCase(i64);

/// The cases in words.
const CASES: &str = "Swerling's case 0, 1 or 3";

impl Explained for NoSwerlingCase {
    fn message(&self) -> String {
        format!("{} is out of range", self.0)
    }

    fn expected(&self) -> String {
        CASES.to_owned()
    }
}

impl Schema for Swerling {
    fn shape() -> Shape {
        Shape::Number { is_whole: true, range: Some((0.0, 3.0)), unit: "" }
    }

    fn expected() -> Option<String> {
        Some(CASES.to_owned())
    }
}

read_from!(Swerling, i64);

impl TryFrom<i64> for Swerling {
    type Error = NoSwerlingCase;

    fn try_from(case: i64) -> Result<Self, NoSwerlingCase> {
        match case {
            0 => Ok(Self::Case0),
            1 => Ok(Self::Case1),
            3 => Ok(Self::Case3),
            other => Err(NoSwerlingCase(other)),
        }
    }
}

impl From<Swerling> for i64 {
    fn from(swerling: Swerling) -> i64 {
        match swerling {
            Swerling::Case0 => 0,
            Swerling::Case1 => 1,
            Swerling::Case3 => 3,
        }
    }
}

/// The filter behind each track, and the life of a track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Tracker {
    /// Filter of gap, relative speed and lead acceleration.
    pub filter: TrackingFilter,
    /// Standard deviation of the acceleration of a lead that does not manoeuvre hard, m/s².
    pub lead_acceleration_sigma_mps2: Sigma,
    /// Correlation time of that acceleration, s.
    pub maneuver_time_constant_s: TimeConstant,
    /// A measurement farther off than this many standard deviations is not used.
    pub gate_sigma: SigmaMultiple,
    /// A track without measurement is dropped after this time, s.
    pub coast_s: Time,
    /// Scans that must have measured a track to confirm it (model `detections`).
    pub confirm_hits: Count,
    /// Scans in a row among which they are counted (model `detections`).
    pub confirm_scans: Count,
}

/// A filter of gap, relative speed and lead acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum TrackingFilter {
    /// One Kalman filter with Singer's model of the lead's acceleration.
    Singer,
    /// Three of them side by side, for a quiet, a moderate and a hard manoeuvre.
    #[default]
    InteractingModels,
}

impl Default for Tracker {
    fn default() -> Self {
        Self {
            filter: TrackingFilter::default(),
            lead_acceleration_sigma_mps2: Sigma::of(0.5),
            maneuver_time_constant_s: TimeConstant::of(2.5),
            gate_sigma: SigmaMultiple::of(5.0),
            coast_s: Time::of(0.5),
            confirm_hits: Count::of(3),
            confirm_scans: Count::of(4),
        }
    }
}

/// The target is the nearest vehicle in the ego's path. Entering and leaving the path have different limits, so that a
/// vehicle on the line does not flicker.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct TargetSelection {
    /// A vehicle is in the path when its centre is nearer to the lane's centre than this, m.
    pub enter_half_width_m: Length,
    /// A vehicle in the path leaves it when its centre is farther off than this, m.
    pub leave_half_width_m: Length,
    /// A vehicle must be in the path for this time before it becomes the target, s.
    pub confirm_s: Time,
    /// A vehicle is in the path already if its lateral motion takes its body before the ego's within this time, s. 0:
    /// no prediction. Exact tracks are not predicted.
    pub predict_s: Time,
}

impl Default for TargetSelection {
    fn default() -> Self {
        Self {
            enter_half_width_m: Length::of(1.6),
            leave_half_width_m: Length::of(2.2),
            confirm_s: Time::of(0.1),
            predict_s: Time::of(1.2),
        }
    }
}
