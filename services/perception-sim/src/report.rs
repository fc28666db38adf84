//! Figures that perception-sim reports at its end.

use serde::{Deserialize, Serialize};

/// Quality of perception's tracks by ground truth. Module [`quality`](crate::quality) computes each figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PerceptionReport {
    pub scans: u64,
    /// GOSPA (c = 10 m, p = 2), root mean square over the scans, m. Its square is the sum of the squares
    /// of the next three.
    pub gospa_m: f64,
    /// Part of the distance between tracks and their vehicles.
    pub localisation_m: f64,
    /// Part of vehicles without a track.
    pub missed_m: f64,
    /// Part of tracks without a vehicle.
    pub false_m: f64,
    /// Tracks for which the message had no room.
    pub tracks_left_out: u64,
    /// Vehicles that came into the ego's lane from beside it and got a track in the path.
    pub cut_ins: u64,
    /// Mean time from the overlap with the lane to the track in the path, s; negative: before.
    pub cut_in_mean_s: Option<f64>,
    /// The longest such time, s.
    pub cut_in_worst_s: Option<f64>,
    /// Vehicles that came into the lane and have no track in the path yet.
    pub cut_ins_unconfirmed: u64,
    /// Number of targets that are not a vehicle in the path or on its way into it.
    pub false_targets: u64,
    /// Time for which there was one, s.
    pub false_target_s: f64,
    /// Detections handed out, by a radar that has detections.
    pub detections: Option<u64>,
    /// Detections for which the message had no room.
    pub detections_left_out: Option<u64>,
    /// Acts of an OpenSCENARIO file of which no event started.
    #[serde(default)]
    pub unstarted_acts: Vec<String>,
    /// The ego came to the end of its road, and the drive ended there.
    #[serde(default)]
    pub road_ended: bool,
}
