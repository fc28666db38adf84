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
//! The price: a vehicle three lanes off becomes a track late. It must no longer drive exactly beside another one of the
//! same speed.

use super::association::Point;
use super::course::Course;
use super::numbers::Numbers;
use super::track::DetectedTrack;

/// A detection is so far off that no track begins with it.
#[must_use]
pub fn is_too_far(point: &Point, numbers: &Numbers) -> bool {
    point.y_m.abs() > numbers.farthest_m
}

/// `track` could be the image of `vehicle`, to an ego with `ego_mps` on a course.
#[must_use]
pub fn is_image(
    track: &DetectedTrack,
    vehicle: &DetectedTrack,
    (course, ego_mps): (&Course, f64),
    numbers: &Numbers,
) -> bool {
    if !course.is_straight() {
        return is_image_on(course, ego_mps, track, vehicle, numbers);
    }
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

/// The same on a curve. A rail mirrors as its tangent at the place that the wave strikes. That place is on the line of
/// sight to the image, as far from the image as from the vehicle. There the line between the two is square to the
/// course.
fn is_image_on(
    course: &Course,
    ego_mps: f64,
    track: &DetectedTrack,
    vehicle: &DetectedTrack,
    numbers: &Numbers,
) -> bool {
    let (a, b) = (track.along.estimate(), vehicle.along.estimate());
    let (image, body) = (
        course.place(a.gap_m, track.across.position_m()),
        course.place(b.gap_m, vehicle.across.position_m()),
    );
    let square = |(x, y): (f64, f64)| x * x + y * y;
    let apart = (image.0 - body.0, image.1 - body.1);
    let apart_m = libm::sqrt(square(apart));
    let along = square(image) - (image.0 * body.0 + image.1 * body.1);
    if square(image) <= square(body) || along <= 0.0 || apart_m < numbers.rail_room_m {
        return false;
    }
    let share = (square(image) - square(body)) / (2.0 * along);
    let struck = course.locate(share * image.0, share * image.1);
    let side = struck.d_m.signum();
    let (rail_m, vehicle_m) = (side * struck.d_m, side * vehicle.across.position_m());
    if share >= 1.0 || rail_m < numbers.nearest_rail_m || rail_m - vehicle_m < numbers.rail_room_m {
        return false;
    }
    // The two are square to the course there.
    let (cosine, sine) = struck.tangent;
    let along_m = apart.0 * cosine + apart.1 * sine;
    let normal = (apart.0 / apart_m, apart.1 / apart_m);
    let velocity = |gap_m: f64, relative_mps: f64, lateral_mps: f64| {
        let ((cosine, sine), speed_mps) = (course.tangent(gap_m), ego_mps + relative_mps);
        (speed_mps * cosine - lateral_mps * sine, speed_mps * sine + lateral_mps * cosine)
    };
    let of_track = velocity(a.gap_m, a.relative_speed_mps, track.across.speed_mps());
    let of_body = velocity(b.gap_m, b.relative_speed_mps, vehicle.across.speed_mps());
    let outward_mps = of_body.0 * normal.0 + of_body.1 * normal.1;
    let mirrored =
        (of_body.0 - 2.0 * outward_mps * normal.0, of_body.1 - 2.0 * outward_mps * normal.1);
    // Only the motion along the line of sight is measured well.
    let range_m = libm::sqrt(square(image));
    let sight = (image.0 / range_m, image.1 / range_m);
    let differ_mps = (of_track.0 - mirrored.0) * sight.0 + (of_track.1 - mirrored.1) * sight.1;
    let agrees = |difference: f64, slack: f64, variance: f64| {
        difference.abs() < slack + numbers.surely_sigma * variance.max(0.0).sqrt()
    };
    let variance = |entry: usize| a.covariance[entry][entry] + b.covariance[entry][entry];
    agrees(along_m, numbers.image_along_m, variance(0))
        && agrees(differ_mps, numbers.image_mps, variance(1))
}

#[cfg(test)]
mod tests {
    use super::super::longitudinal::{Kind, Maneuver, Model};
    use super::super::sighting::Sighting;
    use super::Course;
    use super::DetectedTrack;
    use super::Numbers;
    use crate::tracking::association::tests::point;

    fn track(gap_m: f64, lateral_m: f64, relative_mps: f64) -> DetectedTrack {
        let quiet = Maneuver { sigma_mps2: 1.0, tau_s: 2.0 };
        let model = Model::new(Kind::Interacting, quiet, 4.0, &Numbers::DEFAULT);
        let points = [point(gap_m, lateral_m, relative_mps)];
        let sighting = Sighting::of(points.iter(), 0.0, &Numbers::DEFAULT).expect("a point");
        DetectedTrack::begin(&model, &sighting, true)
    }

    fn is_image(track: &DetectedTrack, vehicle: &DetectedTrack) -> bool {
        super::is_image(track, vehicle, (&Course::STRAIGHT, 20.0), &Numbers::DEFAULT)
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

    /// A lead on a left curve, both at 20 m/s, and its image in the rails of both sides.
    #[test]
    fn on_a_curve_the_image_is_displaced_and_is_recognised() {
        let radius_m = 300.0;
        let course = Course::bent(0.0, |_| 1.0 / radius_m);
        let lead = track(60.0, 0.0, 0.0);
        let body = course.place(60.0, 0.0);
        for offset_m in [8.0, -8.0] {
            // By hand: the place struck is half way on the circle of the rail, and the ways to it have equal length.
            let struck = course.place(30.0, offset_m);
            let (cosine, sine) = course.tangent(30.0);
            let before_m = (body.1 - struck.1) * cosine - (body.0 - struck.0) * sine;
            let image = (body.0 + 2.0 * before_m * sine, body.1 - 2.0 * before_m * cosine);
            let there = course.locate(image.0, image.1);
            let relative = |image_mps: f64| track(there.sigma_m, there.d_m, image_mps);
            // Its motion along the line of sight is that of the lead along its own line of sight: none.
            let sight_rad = libm::atan2(image.1, image.0);
            let (cosine, sine) = there.tangent;
            let across = libm::cos(sight_rad) * cosine + libm::sin(sight_rad) * sine;
            let image_mps = 20.0 * libm::cos(sight_rad) / across - 20.0;
            let is_image = |track: &DetectedTrack| {
                super::is_image(track, &lead, (&course, 20.0), &Numbers::DEFAULT)
            };
            assert!(is_image(&relative(image_mps)), "{offset_m}: {there:?} {image_mps}");
            assert!(!is_image(&relative(image_mps + 5.0)), "{offset_m}: it is faster");
        }
        let beside = track(60.0, 3.5, 0.0);
        assert!(!super::is_image(&beside, &lead, (&course, 20.0), &Numbers::DEFAULT));
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

    /// On a curve of so large a radius that it is straight the rules are those of the straight road.
    #[test]
    fn on_a_course_without_a_curve_the_rules_are_those_of_the_straight_road() {
        let flat = Course::bent(0.0, |_| 0.0);
        let is_image_on = |track: &DetectedTrack, vehicle: &DetectedTrack| {
            super::is_image(track, vehicle, (&flat, 20.0), &Numbers::DEFAULT)
        };
        // A far vehicle: the line of sight to the image is nearly along the road.
        let (gap_m, along_m, rate_mps) = (100.0, 2.0 + 3.0 * 0.2, 0.5 + 3.0 * f64::sqrt(0.0208));
        for (vehicle_m, image_m, expected) in [
            (0.0, 9.3, true),
            (0.0, 8.7, false),
            (0.0, -9.3, true),
            (3.5, 8.8, true),
            (3.5, 8.2, false),
            (-3.5, -8.8, true),
            (-3.5, 12.9, true),
            (-3.5, 12.1, false),
            (-12.0, 11.8, false),
        ] {
            let found = is_image_on(&track(gap_m, image_m, -2.0), &track(gap_m, vehicle_m, -2.0));
            assert_eq!(found, expected, "{vehicle_m} {image_m}");
        }
        // A standing object has no motion that the rail could turn.
        let (lead, post) = (track(gap_m, 0.0, -2.0), track(30.0, 0.0, -20.0));
        for (share, expected) in [(0.97, true), (1.03, false), (-0.97, true), (-1.03, false)] {
            let along = track(30.0 + share * along_m, 16.0, -20.0);
            assert_eq!(is_image_on(&along, &post), expected, "{share} along");
            let faster = track(gap_m, 16.0, -2.0 + share * rate_mps);
            assert_eq!(is_image_on(&faster, &lead), expected, "{share} faster");
        }
    }
}
