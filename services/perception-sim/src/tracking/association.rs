//! Assignment of detections to tracks.
//!
//! A vehicle gives several detections, so a track may take any number of them. A detection belongs to one track at
//! most. Each choice then leaves all others free. So the least total distance assigns every detection to its nearest
//! track within the gate.
//!
//! Distance is measured from the outline that the track predicts. Its units are the standard deviations of range,
//! lateral position and range rate.
//!
//! Places are those of the straight road that [`super::course`] makes of the one ahead. They are arc length σ, and
//! distance d from the course. The range rate is the one that the same motion would have there.

use std::array::from_fn;
use std::ops::Range;

use messages::Detection;

use super::course::Course;
use super::motion::Motion;
use super::numbers::Numbers;
use crate::radar::receiver::{Receiver, snr_of};

/// A detection on the course.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Distance ahead, along the course, m.
    pub x_m: f64,
    /// Distance to the left of the course, m.
    pub y_m: f64,
    /// Cosine and sine of the line of sight in the axes of the course there. On a straight road they are those of the
    /// azimuth.
    pub direction: (f64, f64),
    /// Distance to the left of the radar in those axes, m. A vehicle there shows its right side if it is positive.
    pub aspect_m: f64,
    /// Range rate, m/s.
    pub range_rate_mps: f64,
    /// Variance of the range, m².
    pub range_variance: f64,
    /// Variance of the range rate, m²/s².
    pub range_rate_variance: f64,
    /// Variance of the lateral position, m².
    pub lateral_variance: f64,
    /// Speed over ground along the line of sight, m/s.
    pub ground_speed_mps: f64,
    /// Index of the detection.
    pub detection: usize,
    /// Place of the track that it belongs to.
    pub owner: Option<usize>,
}

/// A detection in the body's axes, with the accuracy that the receiver has at its signal-to-noise ratio.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Sine and cosine of the azimuth.
    pub sine: f64,
    /// See `sine`.
    pub cosine: f64,
    /// Distance ahead and to the left, m.
    pub ahead_m: f64,
    /// See `ahead_m`.
    pub left_m: f64,
    /// Signal-to-noise ratio.
    pub snr: f64,
}

impl Reading {
    /// A detection's direction, place and signal-to-noise ratio.
    #[must_use]
    pub fn new(detection: &Detection) -> Self {
        let (sine, cosine) = libm::sincos(detection.azimuth_rad);
        let (ahead_m, left_m) = (detection.range_m * cosine, detection.range_m * sine);
        Self { sine, cosine, ahead_m, left_m, snr: snr_of(detection) }
    }
}

impl Point {
    /// The detection number `index` on a course.
    #[must_use]
    pub fn new(
        index: usize,
        (detection, reading): (&Detection, &Reading),
        ego: &Motion,
        receiver: &Receiver,
        course: &Course,
    ) -> Self {
        let ego_mps = ego.speed_mps;
        let Reading { sine, cosine, ahead_m, left_m, snr } = *reading;
        let cross_m = detection.range_m / cosine.max(0.1);
        let straight = Self {
            x_m: ahead_m,
            y_m: left_m,
            direction: (cosine, sine),
            aspect_m: left_m,
            range_rate_mps: detection.range_rate_mps,
            range_variance: receiver.range.variance(snr).max(1e-6),
            range_rate_variance: receiver.range_rate.variance(snr).max(1e-6),
            lateral_variance: (receiver.azimuth.variance(snr) * cross_m * cross_m).max(1e-6),
            ground_speed_mps: detection.range_rate_mps + ego_mps * cosine,
            detection: index,
            owner: None,
        };
        if course.is_straight() {
            return straight;
        }
        let there = course.locate(ahead_m, left_m);
        let (along, across) = there.tangent;
        let direction = (cosine * along + sine * across, sine * along - cosine * across);
        let ground_mps = detection.range_rate_mps + ego_mps * (cosine + ego.slip_rad * sine);
        // On the inside of a curve less way makes the same progress along the course.
        let stretch = (1.0 - there.curvature_perm * there.d_m).clamp(0.5, 2.0);
        Self {
            x_m: there.sigma_m,
            y_m: there.d_m,
            direction,
            aspect_m: detection.range_m * direction.1,
            range_rate_mps: ground_mps / stretch - ego_mps * direction.0,
            ground_speed_mps: ground_mps,
            ..straight
        }
    }

    /// Speed relative to the ego along the road, for a lateral speed, m/s.
    #[must_use]
    pub fn relative_speed_mps(&self, lateral_mps: f64) -> f64 {
        let (cosine, sine) = self.direction;
        (self.range_rate_mps - lateral_mps * sine) / cosine.max(0.1)
    }
}

/// The outline that a track predicts, with its uncertainty.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// Place of the track.
    pub place: usize,
    /// It is confirmed.
    pub confirmed: bool,
    /// Position of the rear and of its lateral centre, m.
    pub rear_m: f64,
    /// Lateral position of its centre, m.
    pub lateral_m: f64,
    /// The same in the axes of the course there, seen from the radar, m.
    pub aspect_m: f64,
    /// Length, m.
    pub length_m: f64,
    /// Half of the width, m.
    pub half_width_m: f64,
    /// Speed relative to the ego, m/s.
    pub relative_speed_mps: f64,
    /// Lateral speed, m/s.
    pub lateral_speed_mps: f64,
    /// Variances of rear, lateral position, relative speed (with that of a good measurement) and
    /// lateral speed.
    pub variances: [f64; 4],
}

impl Outline {
    /// Distance of a detection from the outline, squared; `None` outside the gate.
    #[must_use]
    pub fn distance(&self, point: &Point, gate: f64, numbers: &Numbers) -> Option<f64> {
        let position_gate = numbers.position_gate * numbers.position_gate;
        let body = numbers.body_sigma_m * numbers.body_sigma_m;
        let along_m = point.x_m - self.rear_m;
        let off_x = |beyond_m: f64| (-along_m).max(along_m - self.length_m - beyond_m).max(0.0);
        let off_y = ((point.y_m - self.lateral_m).abs() - self.half_width_m).max(0.0);
        let variance_x = self.variances[0] + point.range_variance + body;
        let variance_y = self.variances[1] + point.lateral_variance + body;
        // Most points are far from most outlines: neither a root nor a division for them.
        let least_x = off_x(numbers.beyond_along_side_m.max(numbers.beyond_m));
        if least_x * least_x > position_gate * variance_x
            || off_y * off_y > position_gate * variance_y
        {
            return None;
        }
        let off_x = off_x(match self.is_on_side(point, numbers) {
            true => numbers.beyond_along_side_m,
            false => numbers.beyond_m,
        });
        let (x, y) = (off_x * off_x / variance_x, off_y * off_y / variance_y);
        if x > position_gate {
            return None;
        }
        let (cosine, sine) = point.direction;
        let predicted = self.relative_speed_mps * cosine + self.lateral_speed_mps * sine;
        let residual = point.range_rate_mps - predicted;
        let variance =
            self.variances[2] + point.range_rate_variance + sine * sine * self.variances[3];
        let rate = residual * residual / variance;
        let penalty = if self.confirmed { 0.0 } else { numbers.tentative_penalty };
        (rate <= gate * gate).then_some(x + y + rate + penalty)
    }

    /// A point is on the line of the side that the vehicle shows to the ego.
    fn is_on_side(&self, point: &Point, numbers: &Numbers) -> bool {
        let side_m = self.lateral_m - self.half_width_m * self.aspect_m.signum();
        let sigma_m = (self.variances[1] + point.lateral_variance).sqrt();
        let margin_m = numbers.side_line_m + numbers.likely_sigma * sigma_m;
        self.aspect_m.abs() > numbers.side_shown_m && (point.y_m - side_m).abs() < margin_m
    }

    /// A point is on the vehicle or close to it, however fast it moves.
    #[must_use]
    pub fn covers(&self, point: &Point, numbers: &Numbers) -> bool {
        let gate = numbers.position_gate;
        let sigma_x = (self.variances[0] + point.range_variance).sqrt();
        let sigma_y = (self.variances[1] + point.lateral_variance).sqrt();
        let margin_x = numbers.covers_along_m + gate * sigma_x;
        let margin_y = numbers.covers_across_m + gate * sigma_y;
        let along_m = point.x_m - self.rear_m;
        along_m > -margin_x
            && along_m < self.length_m + numbers.beyond_m + margin_x
            && (point.y_m - self.lateral_m).abs() < self.half_width_m + margin_y
    }
}

/// Gives every point to the track with the nearest outline.
pub fn associate(points: &mut [Point], outlines: &[Outline], gate: f64, numbers: &Numbers) {
    for point in points {
        let mut nearest = f64::INFINITY;
        for outline in outlines {
            if let Some(distance) = outline.distance(point, gate, numbers)
                && distance < nearest
            {
                nearest = distance;
                point.owner = Some(outline.place);
            }
        }
    }
}

/// For each of the first `N` tracks the points from the first one of its own to the last. Points are in the order of
/// their ranges, so that those of a vehicle are close together.
pub(super) fn spans<const N: usize>(points: &[Point]) -> [Range<usize>; N] {
    let mut spans = from_fn(|_| 0..0);
    for (index, point) in points.iter().enumerate() {
        if let Some(span) = point.owner.and_then(|owner| spans.get_mut(owner)) {
            let first = if span.start == span.end { index } else { span.start };
            *span = first..index + 1;
        }
    }
    spans
}

/// Lets go of the points on one side of a track whose points are farther apart than a vehicle is wide. They are of two
/// vehicles abreast. It keeps those on the side on which it is expected.
pub fn part(points: &mut [Point], outline: &Outline, numbers: &Numbers) {
    let own = |point: &&Point| point.owner == Some(outline.place);
    let (mut right_m, mut left_m, mut variance) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for point in points.iter().filter(own) {
        right_m = right_m.min(point.y_m);
        left_m = left_m.max(point.y_m);
        variance = variance.max(point.lateral_variance);
    }
    if left_m - right_m < numbers.widest_m + numbers.position_gate * (2.0 * variance).sqrt() {
        return;
    }
    let middle_m = 0.5 * (left_m + right_m);
    let is_left = outline.lateral_m > middle_m;
    for point in points.iter_mut().filter(|point| point.owner == Some(outline.place)) {
        if (point.y_m > middle_m) != is_left {
            point.owner = None;
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A point of a good detection.
    pub(in super::super) fn point(x_m: f64, y_m: f64, range_rate_mps: f64) -> Point {
        Point {
            x_m,
            y_m,
            direction: (1.0, 0.0),
            aspect_m: y_m,
            range_rate_mps,
            range_variance: 0.01,
            range_rate_variance: 0.01,
            lateral_variance: 0.04,
            ground_speed_mps: 20.0 + range_rate_mps,
            detection: 0,
            owner: None,
        }
    }

    fn outline(place: usize, rear_m: f64, lateral_m: f64) -> Outline {
        Outline {
            place,
            confirmed: true,
            rear_m,
            lateral_m,
            aspect_m: lateral_m,
            length_m: 4.5,
            half_width_m: 0.9,
            relative_speed_mps: 0.0,
            lateral_speed_mps: 0.0,
            variances: [0.1, 0.05, 0.05, 0.1],
        }
    }

    fn owners(points: &[Point], outlines: &[Outline]) -> Vec<Option<usize>> {
        let mut points = points.to_vec();
        associate(&mut points, outlines, 5.0, &Numbers::DEFAULT);
        points.iter().map(|point| point.owner).collect()
    }

    #[test]
    fn a_track_takes_all_echoes_of_its_vehicle() {
        let points = [point(40.0, 0.8, 0.1), point(40.2, -0.9, 0.0), point(44.0, 0.9, -0.1)];
        assert_eq!(owners(&points, &[outline(7, 40.0, 0.0)]), [Some(7); 3]);
    }

    #[test]
    fn between_two_vehicles_the_nearer_gets_the_echo() {
        let outlines = [outline(0, 40.0, 0.0), outline(1, 40.0, 3.5)];
        let points = [point(40.0, 0.9, 0.0), point(40.0, 2.5, 0.0), point(40.0, 3.4, 0.0)];
        assert_eq!(owners(&points, &outlines), [Some(0), Some(1), Some(1)]);
    }

    #[test]
    fn an_echo_elsewhere_or_of_another_motion_belongs_to_no_track() {
        let points = [point(30.0, 0.0, 0.0), point(40.0, 4.0, 0.0), point(40.0, 0.0, -5.0)];
        assert_eq!(owners(&points, &[outline(0, 40.0, 0.0)]), [None; 3]);
    }

    #[test]
    fn a_track_between_two_vehicles_keeps_one_of_them() {
        let mut points = [point(40.0, 2.7, 0.0), point(40.0, -2.7, 0.0), point(40.0, 3.0, 0.0)];
        points.iter_mut().for_each(|point| point.owner = Some(3));
        part(&mut points, &outline(3, 40.0, 0.5), &Numbers::DEFAULT);
        assert_eq!(points.map(|point| point.owner), [Some(3), None, Some(3)]);
        // The two sides of a lorry are one vehicle's.
        let mut lorry = [point(40.0, 1.3, 0.0), point(40.0, -1.3, 0.0)];
        lorry.iter_mut().for_each(|point| point.owner = Some(3));
        part(&mut lorry, &outline(3, 40.0, 0.0), &Numbers::DEFAULT);
        assert_eq!(lorry.map(|point| point.owner), [Some(3); 2]);
    }

    /// The distance of a point from a car whose rear is 40 m ahead.
    fn distance(point: Point) -> Option<f64> {
        outline(0, 40.0, 0.0).distance(&point, 4.0, &Numbers::DEFAULT)
    }

    #[track_caller]
    fn assert_distance(found: Option<f64>, expected: f64) {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-9), "{found:?} {expected}");
    }

    #[test]
    fn a_distance_is_in_deviations_of_rear_sides_and_speed() {
        // Along: 0.1 of the track, 0.01 of the point and 0.3² of the body. Across: 0.05, 0.04 and 0.3².
        assert_distance(distance(point(42.0, 0.5, 0.0)), 0.0);
        assert_distance(distance(point(39.0, 0.0, 0.0)), 1.0 / 0.2);
        assert_distance(distance(point(40.0, 1.4, 0.0)), 0.25 / 0.18);
        assert_distance(distance(point(40.0, -1.4, 0.0)), 0.25 / 0.18);
        // Behind the length of 4.5 m are 2.5 m in which echoes from below arrive.
        assert_distance(distance(point(47.0, 0.0, 0.0)), 0.0);
        assert_distance(distance(point(48.0, 0.0, 0.0)), 1.0 / 0.2);
        // Three deviations are the gate of a place.
        assert_distance(distance(point(38.7, 0.0, 0.0)), 1.69 / 0.2);
        assert_eq!(distance(point(38.6, 0.0, 0.0)), None);
        assert_eq!(distance(point(40.0, 2.2, 0.0)), None);
        // The speed: 0.05 and 0.01.
        assert_distance(distance(point(40.0, 0.0, -0.6)), 0.36 / 0.06);
        assert_eq!(distance(point(40.0, 0.0, -1.0)), None, "beyond four deviations");
    }

    #[test]
    fn across_the_line_of_sight_the_lateral_speed_counts() {
        let moving =
            Outline { relative_speed_mps: 0.2, lateral_speed_mps: 0.1, ..outline(0, 40.0, 0.0) };
        let aside = Point { direction: (0.8, 0.6), ..point(40.0, 0.0, 0.5) };
        // 0.2 · 0.8 + 0.1 · 0.6 are expected; 0.1 · 0.6² of the lateral speed add to 0.05 and 0.01.
        let numbers = &Numbers::DEFAULT;
        assert_distance(moving.distance(&aside, 4.0, numbers), 0.28 * 0.28 / 0.096);
        let tentative = Outline { confirmed: false, ..moving };
        assert_distance(tentative.distance(&aside, 4.0, numbers), 4.0 + 0.28 * 0.28 / 0.096);
    }

    #[test]
    fn along_the_side_that_shows_echoes_come_from_farther() {
        let aside = outline(0, 40.0, 5.0);
        let at = |x_m: f64, y_m: f64| aside.distance(&point(x_m, y_m, 0.0), 4.0, &Numbers::DEFAULT);
        // Its right side, at 4.1 m, looks at the ego.
        assert_distance(at(50.5, 4.1), 0.0);
        assert_distance(at(51.5, 4.1), 1.0 / 0.2);
        assert_eq!(at(50.5, 5.9), None, "the other side does not");
        let ahead = Outline { aspect_m: 0.0, ..aside };
        assert_eq!(ahead.distance(&point(50.5, 4.1, 0.0), 4.0, &Numbers::DEFAULT), None);
    }

    #[test]
    fn a_confirmed_track_keeps_its_echoes_from_a_new_one() {
        let tentative = Outline { confirmed: false, ..outline(1, 40.0, 0.0) };
        let points = [point(39.5, 0.0, 0.0)];
        assert_eq!(owners(&points, &[tentative, outline(0, 40.0, 0.0)]), [Some(0)]);
    }
}

#[cfg(test)]
mod exact_tests;
