//! Mirror images of vehicles in a guard rail, recognised without knowledge of a rail.
//!
//! An image has its vehicle's place along the road and its speed. It is as far beyond the rail as the vehicle is
//! before it. Two rules keep images from becoming tracks:
//!
//! * lateral position: no track begins farther than three lanes from the ego's ([`Numbers::farthest_m`]). A vehicle
//!   there cannot come before the ego soon, and most images are there;
//! * consistency: a track that is not yet confirmed ends if it could be the image of a track nearer to the ego's lane.
//!   The rail must be outside the next lane ([`Numbers::nearest_rail_m`]) and leave that vehicle room.
//!
//! On a curve an image is displaced along the road as well, and may stay a track. The belief about the road leaves it
//! beside the ego's way.
//!
//! The price: a vehicle three lanes off becomes a track late. It must no longer drive exactly beside another one of the
//! same speed.

use super::association::Point;
use super::numbers::Numbers;
use super::track::DetectedTrack;

/// A detection is so far off that no track begins with it.
pub fn is_too_far(point: &Point, numbers: &Numbers) -> bool {
    point.y_m.abs() > numbers.farthest_m
}

/// `track` could be the image of `vehicle`.
pub fn is_image(track: &DetectedTrack, vehicle: &DetectedTrack, numbers: &Numbers) -> bool {
    let side = track.across.position_m().signum();
    let (image_m, vehicle_m) =
        (side * track.across.position_m(), side * vehicle.across.position_m());
    let rail_m = 0.5 * (image_m + vehicle_m);
    if vehicle_m.abs() > image_m
        || rail_m < numbers.nearest_rail_m
        || rail_m - vehicle_m < numbers.rail_room_m
    {
        return false;
    }
    let (a, b) = (track.along.estimate(), vehicle.along.estimate());
    let agrees = |difference: f64, slack: f64, variance: f64| {
        difference.abs() < slack + numbers.surely_sigma * variance.max(0.0).sqrt()
    };
    let variance = |entry: usize| a.covariance[entry][entry] + b.covariance[entry][entry];
    agrees(a.gap_m - b.gap_m, numbers.image_along_m, variance(0))
        && agrees(a.relative_speed_mps - b.relative_speed_mps, numbers.image_mps, variance(1))
}

#[cfg(test)]
mod tests {
    use super::super::longitudinal::{Maneuver, Model};
    use super::super::sighting::Sighting;
    use super::DetectedTrack;
    use super::Numbers;
    use crate::tracking::association::tests::point;

    fn track(gap_m: f64, lateral_m: f64, relative_mps: f64) -> DetectedTrack {
        let quiet = Maneuver { sigma_mps2: 1.0, tau_s: 2.0 };
        let model = Model::new(quiet, 4.0, &Numbers::DEFAULT);
        let points = [point(gap_m, lateral_m, relative_mps)];
        let sighting = Sighting::of(points.iter(), 0.0, &Numbers::DEFAULT).expect("a point");
        DetectedTrack::begin(&model, &sighting, true)
    }

    fn is_image(track: &DetectedTrack, vehicle: &DetectedTrack) -> bool {
        super::is_image(track, vehicle, &Numbers::DEFAULT)
    }

    #[test]
    fn an_image_lies_as_far_beyond_the_rail_as_its_vehicle_before_it() {
        let lead = track(60.0, 0.0, -2.0);
        assert!(is_image(&track(60.5, 16.0, -2.0), &lead), "a rail at 8 m");
        assert!(is_image(&track(60.5, -16.0, -2.0), &lead), "and on the right");
        assert!(!is_image(&track(60.5, 16.0, 4.0), &lead), "it is faster");
        assert!(!is_image(&track(90.0, 16.0, -2.0), &lead), "it is elsewhere");
        assert!(!is_image(&lead, &track(60.5, 16.0, -2.0)), "the nearer one is the vehicle");
    }

    #[test]
    fn vehicles_side_by_side_on_neighbouring_lanes_are_no_images() {
        let lead = track(60.0, 0.0, 0.0);
        for lateral_m in [3.5, -3.5, 7.0, -7.0] {
            assert!(!is_image(&track(60.0, lateral_m, 0.0), &lead), "{lateral_m}");
        }
        assert!(!is_image(&track(60.0, 7.0, 0.0), &track(60.0, 3.5, 0.0)));
    }

    #[test]
    fn a_rail_is_outside_the_next_lane_and_leaves_its_vehicle_room() {
        // The rail is in the middle between the two, for a vehicle in the ego's lane at 4.5 m or farther.
        for (vehicle_m, image_m, expected) in [
            (0.0, 9.1, true),
            (0.0, 8.9, false),
            (0.0, -9.1, true),
            (0.0, -8.9, false),
            // From a vehicle at 3.5 m it is 2.5 m away.
            (3.5, 8.6, true),
            (3.5, 8.4, false),
            (-3.5, -8.6, true),
            (-3.5, -8.4, false),
            // Beyond the ego's own lane: the rail would be at 4.6 or 4.4 m.
            (-3.5, 12.7, true),
            (-3.5, 12.3, false),
        ] {
            let found = is_image(&track(60.0, image_m, -2.0), &track(60.0, vehicle_m, -2.0));
            assert_eq!(found, expected, "{vehicle_m} {image_m}");
        }
        // The image is not nearer than its vehicle.
        assert!(!is_image(&track(60.0, 11.9, -2.0), &track(60.0, -12.0, -2.0)));
    }

    /// Each gap has the variance 0.1² + 0.1², each speed 0.1² + 0.02².
    #[test]
    fn an_image_agrees_with_its_vehicle_within_three_deviations() {
        let lead = track(60.0, 0.0, -2.0);
        let (along_m, rate_mps) = (2.0 + 3.0 * f64::sqrt(0.04), 0.5 + 3.0 * f64::sqrt(0.0208));
        for (share, expected) in [(0.99, true), (1.01, false), (-0.99, true), (-1.01, false)] {
            let along = track(60.0 + share * along_m, 16.0, -2.0);
            assert_eq!(is_image(&along, &lead), expected, "{share} along");
            let faster = track(60.0, 16.0, -2.0 + share * rate_mps);
            assert_eq!(is_image(&faster, &lead), expected, "{share} faster");
        }
    }
}
