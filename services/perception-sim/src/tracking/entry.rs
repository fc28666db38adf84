//! The part of a track that is handed out.

use messages::Detection;

use super::course::Course;
use super::list::Track;
use super::track::DetectedTrack;

/// A track's entry in the list. One that is not seen has the direction in which it is expected.
pub(super) fn entry(track: &DetectedTrack, course: &Course, detections: &[Detection]) -> Track {
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
        doubt_share: track.membership.doubt_share,
        ..Track::default()
    };
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

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::super::association::tests::point;
    use super::super::longitudinal::{Maneuver, Model, Step};
    use super::super::numbers::Numbers;
    use super::super::sighting::Sighting;
    use super::*;
    use crate::radar::scene::Ego;

    fn step(dt_s: f64) -> Step {
        Step { dt_s, ego: Ego { speed_mps: 20.0, ..Ego::default() } }
    }

    const NUMBERS: Numbers = Numbers::DEFAULT;

    #[test]
    fn what_is_seen_has_its_detection_and_what_is_not_the_direction_in_which_it_is_expected() {
        let model = Model::new(Maneuver { sigma_mps2: 1.0, tau_s: 2.0 }, 4.0, &NUMBERS);
        let points = [point(40.0, 3.0, -2.0)];
        let sighting = Sighting::of(points.iter(), 0.0, &NUMBERS).expect("a point");
        let mut track = DetectedTrack::begin(&model, &sighting, true);
        track.id = 9;
        let seen = Detection {
            range_m: 40.2,
            range_rate_mps: -1.9,
            azimuth_rad: 0.07,
            ..Detection::zeroed()
        };
        let of = |track: &DetectedTrack, course: &Course| entry(track, course, &[seen]);
        let found = of(&track, &Course::STRAIGHT);
        assert!(found.measured && !found.in_path && found.id == 9);
        assert_eq!((found.range_m, found.range_rate_mps, found.azimuth_rad), (40.2, -1.9, 0.07));
        assert_eq!((found.gap_m, found.relative_speed_mps, found.lateral_m), (40.0, -2.0, 3.0));
        assert_eq!((found.length_m, found.width_m), (4.5, 1.8));
        track.predict(&model, &step(0.5));
        let found = of(&track, &Course::STRAIGHT);
        assert!(!found.measured && (found.gap_m - 39.0).abs() < 1e-12);
        assert!((found.range_m - libm::hypot(39.0, 3.0)).abs() < 1e-12);
        assert!((found.azimuth_rad - libm::atan2(3.0, 39.0)).abs() < 1e-12);
        assert!((found.range_rate_mps + 2.0).abs() < 1e-12);
        // On a left curve of 200 m it is farther to the left.
        let curve = of(&track, &Course::bent(0.0, |_| 0.005));
        let turn = 39.0 / 200.0;
        let (x_m, y_m) = (197.0 * libm::sin(turn), 200.0 - 197.0 * libm::cos(turn));
        assert!((curve.azimuth_rad - libm::atan2(y_m, x_m)).abs() < 1e-6, "{curve:?}");
        // A gap is never negative.
        track.predict(&model, &step(30.0));
        assert_eq!(of(&track, &Course::STRAIGHT).gap_m, 0.0);
    }
}
