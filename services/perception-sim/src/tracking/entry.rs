//! The part of a track that is handed out.

use messages::Detection;

use super::course::Course;
use super::list::Track;
use super::numbers::Numbers;
use super::track::DetectedTrack;
use crate::radar::scene::Ego;

/// A track's entry in the list. One that is lost in the path goes on as it did; one that is not seen has the direction
/// in which it is expected.
pub(super) fn entry(
    track: &DetectedTrack,
    ego: &Ego,
    course: &Course,
    detections: &[Detection],
    numbers: &Numbers,
) -> Track {
    let estimate = track.along.estimate();
    let mut entry = Track {
        id: track.id,
        measured: track.is_seen(),
        gap_m: estimate.gap_m.max(0.0),
        relative_speed_mps: estimate.relative_speed_mps,
        acceleration_mps2: estimate.acceleration_mps2,
        lateral_m: track.across.position_m(),
        lateral_speed_mps: track.across.speed_mps(),
        length_m: track.length_m,
        width_m: track.width_m,
        in_path: track.membership.in_path(),
        ..Track::default()
    };
    if let Some(lost) = track.lost(numbers) {
        entry.gap_m = lost.gap_m.max(0.0);
        entry.relative_speed_mps = lost.speed_mps - ego.speed_mps;
        entry.acceleration_mps2 = lost.acceleration_mps2;
    }
    match detections.get(track.nearest).filter(|_| track.is_seen()) {
        Some(detection) => {
            entry.range_m = detection.range_m;
            entry.range_rate_mps = detection.range_rate_mps;
            entry.azimuth_rad = detection.azimuth_rad;
        }
        None => {
            let (x_m, y_m) = course.place(entry.gap_m, entry.lateral_m);
            entry.range_m = libm::hypot(x_m, y_m);
            entry.range_rate_mps = entry.relative_speed_mps;
            entry.azimuth_rad = libm::atan2(y_m, x_m.max(0.1));
        }
    }
    entry
}
