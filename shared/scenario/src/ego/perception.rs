//! `[perception]`: radar, tracker and target selection.

use scenario_derive::tables;
use serde::{Deserialize, Serialize};

use crate::Problem;
use crate::quantity::{
    Angle, Count, CrossSection, Decibels, DelayMs, Length, Loss, MeanCount, PerKilometre, PeriodMs,
    Probability, Reach, Sigma, SigmaMultiple, Speed, Time, TimeConstant,
};
use crate::reading::refuse;

/// Longest latency of the radar, in scans.
pub const MAX_LATENCY_SCANS: u32 = 32;

tables! {
    /// The simulated perception.
    pub struct Perception {
        /// Period of the radar and of `radar/tracks`, ms.
        pub period_ms: PeriodMs = 50,
        /// The same as `radar.model = "ideal"`.
        pub ideal: bool = sparse,
        /// The radar: its range, field of view and errors.
        pub radar: Radar = default,
        /// The tracker behind the radar.
        pub tracker: Tracker = default,
        /// Choice of the target track.
        pub target_selection: TargetSelection = default,
        /// The path ahead, on a road with a plan.
        pub course: Course = sparse,
    }

    /// Depth of the simulation of the radar.
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
    #[derive(Copy)]
    pub struct Radar {
        /// Depth of the simulation.
        pub model: RadarModel = default,
        /// Farthest detection, m.
        pub max_range_m: Reach = 150.0,
        /// Full opening angle, degrees, symmetric to the ego's axis.
        pub field_of_view_deg: Angle = 60.0,
        /// Standard deviation of the range, m. For the model `object-list`; in `detections` it follows from the
        /// signal-to-noise ratio. So do the next two.
        pub range_sigma_m: Sigma = 0.4,
        /// Standard deviation of the range rate, m/s.
        pub range_rate_sigma_mps: Sigma = 0.15,
        /// Standard deviation of the azimuth, degrees.
        pub azimuth_sigma_deg: Sigma = 0.3,
        /// Probability that a visible vehicle, or an object beside the road, is missing from one scan. It does not
        /// depend on its echoes.
        pub dropout_probability: Probability = 0.0,
        /// Time from the acquisition to the publication of a scan, ms: a multiple of the period.
        pub latency_ms: DelayMs = 0,
        /// Parameters of the model `detections`.
        pub detections: Detections = default,
    }

    /// Detections as a radar's receiver hands them out. Accuracy and resolution are those of a 77 GHz
    /// radar for cruise control with 0.2 to 0.3 GHz of bandwidth.
    #[derive(Copy)]
    pub struct Detections {
        /// Signal-to-noise ratio of 1 m² at 100 m on the axis, dB.
        pub snr_at_100_m_db: Decibels = 15.0,
        /// Loss of an echo at the edge of the field of view against the axis, dB, both ways.
        pub edge_loss_db: Loss = 6.0,
        /// An echo is detected when it and the noise exceed the mean noise by this, dB.
        pub threshold_db: Decibels = 12.0,
        /// Mean radar cross section of a car's rear, dB relative to 1 m² (ISO 15622's target: 10 m²).
        pub car_rcs_dbsm: CrossSection = 10.0,
        /// Mean radar cross section of a vehicle longer than 7 m, dB relative to 1 m².
        pub lorry_rcs_dbsm: CrossSection = 16.0,
        /// Fluctuation of the cross section from scan to scan: Swerling's case 0 (none), 1 or 3.
        pub swerling: Swerling = Case1,
        /// Echoes nearer than this in range, and in range rate and azimuth, may merge, m.
        pub range_resolution_m: Length = 0.75,
        /// The same in range rate, m/s.
        pub range_rate_resolution_mps: Speed = 0.2,
        /// The same in azimuth, degrees.
        pub azimuth_resolution_deg: Angle = 3.0,
        /// Echoes that the resolution does not keep apart come out as one.
        pub merge: bool = true,
        /// Standard deviation of the range that no signal-to-noise ratio improves, m.
        pub range_floor_m: Sigma = 0.1,
        /// The same for the range rate, m/s.
        pub range_rate_floor_mps: Sigma = 0.03,
        /// The same for the azimuth, degrees.
        pub azimuth_floor_deg: Sigma = 0.1,
        /// Loss of the echo of a vehicle that a nearer one hides, dB; 0: no vehicle hides another.
        pub hidden_loss_db: Loss = 20.0,
        /// Mean number of detections of noise in a scan.
        pub false_alarms_per_scan: MeanCount = 0.5,
        /// Standing objects on each side of the road, per km.
        pub standing_objects_per_km: PerKilometre = 50.0,
        /// Their mean radar cross section, dB relative to 1 m².
        pub standing_object_rcs_dbsm: CrossSection = 0.0,
        /// Distance of guard rails and standing objects from the centre of the ego's lane, m.
        pub roadside_offset_m: Length = 8.0,
        /// Probability of a second echo from under the body of a vehicle.
        pub under_body_probability: Probability = 0.3,
        /// Mean of its additional range, m.
        pub under_body_range_m: Length = 1.5,
        /// Its loss against the first echo, dB.
        pub under_body_loss_db: Loss = 10.0,
        /// Share of the road with a guard rail on either side, in which vehicles have mirror images.
        pub guard_rail_share: Probability = 0.5,
        /// Loss of a mirror image, dB.
        pub guard_rail_loss_db: Loss = 18.0,
    }

    /// The model of a quiet lead behind each track, and the life of a track.
    #[derive(Copy)]
    pub struct Tracker {
        /// Standard deviation of the acceleration of a lead that does not manoeuvre hard, m/s².
        pub lead_acceleration_sigma_mps2: Sigma = 0.5,
        /// Correlation time of that acceleration, s.
        pub maneuver_time_constant_s: TimeConstant = 2.5,
        /// A measurement farther off than this many standard deviations is not used.
        pub gate_sigma: SigmaMultiple = 5.0,
        /// A track without measurement is dropped after this time, s.
        pub coast_s: Time = 0.5,
        /// Scans that must have measured a track to confirm it (model `detections`).
        pub confirm_hits: Count = 3,
        /// Scans in a row among which they are counted (model `detections`).
        pub confirm_scans: Count = 4,
    }

    /// The target is the nearest vehicle in the ego's path. Entering and leaving the path have different limits, so
    /// that a vehicle on the line does not flicker.
    #[derive(Copy)]
    pub struct TargetSelection {
        /// A vehicle is in the path when its centre is nearer to the lane's centre than this, m.
        pub enter_half_width_m: Length = 1.6,
        /// A vehicle in the path leaves it when its centre is farther off than this, m.
        pub leave_half_width_m: Length = 2.2,
        /// A vehicle must be in the path for this time before it becomes the target, s.
        pub confirm_s: Time = 0.1,
        /// A vehicle is in the path already if its lateral motion takes its body before the ego's within this time, s.
        /// 0: no prediction. Exact tracks are not predicted.
        pub predict_s: Time = 1.2,
    }

    /// The estimate of the axis ahead on a road with a plan.
    pub struct Course {
        /// Its sources; an empty list: the straight path.
        pub sources: Vec<CourseSource> = vec![CourseSource::YawRate, CourseSource::Standing, CourseSource::Trails],
    }

    /// A source of the course.
    pub enum CourseSource {
        /// The yaw rate and the speed of the ego.
        YawRate,
        /// Standing objects beside the road.
        Standing,
        /// Ways of the vehicles ahead.
        Trails,
        /// Curvatures of the map, `v2x/curves`.
        Map,
    }
}

impl Course {
    /// True if the source is used.
    pub fn uses(&self, source: CourseSource) -> bool {
        self.sources.contains(&source)
    }

    /// A source counts once.
    pub(crate) fn check(&self) -> Result<(), Problem> {
        let again = (1..self.sources.len())
            .find(|&index| self.sources[..index].contains(&self.sources[index]));
        refuse!(if let Some(index) = again, "perception.course.sources.{index}":
            "this source stands here twice", "each source once");
        Ok(())
    }
}

impl Perception {
    /// Makes one of the two keys that say how deep the simulation of the radar goes.
    pub(crate) fn unite(&mut self, is_written: impl Fn(&str) -> bool) -> Result<(), Problem> {
        let contradicts = self.ideal && self.radar.model != RadarModel::Ideal;
        let are_written = is_written("perception.ideal") && is_written("perception.radar.model");
        refuse!(if contradicts && are_written, "perception.radar.model":
            "perception.ideal = true says another model of the radar",
            "perception.radar.model = \"ideal\", or perception.ideal = false",
            against "perception.ideal");
        self.radar.model = self.model();
        Ok(())
    }

    /// Depth of the simulation of the radar.
    pub fn model(&self) -> RadarModel {
        if self.ideal { RadarModel::Ideal } else { self.radar.model }
    }

    pub fn gives_detections(&self) -> bool {
        self.model() == RadarModel::Detections
    }
}

/// Swerling's cases that a scan can distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "i64", into = "i64")]
pub enum Swerling {
    /// No fluctuation.
    Case0 = 0,
    /// Many equal parts.
    Case1 = 1,
    /// One strong part among many.
    Case3 = 3,
}

pub(crate) const CASES: &str = "Swerling's case 0, 1 or 3";

impl TryFrom<i64> for Swerling {
    type Error = String;

    fn try_from(case: i64) -> Result<Self, String> {
        let mut all = [Self::Case0, Self::Case1, Self::Case3].into_iter();
        let refused = || format!("{case} is out of range, expected {CASES}");
        all.find(|known| *known as i64 == case).ok_or_else(refused)
    }
}

impl From<Swerling> for i64 {
    fn from(swerling: Swerling) -> i64 {
        swerling as i64
    }
}
