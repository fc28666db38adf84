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

use messages::Detection;
use scenario::event::VEHICLE_WIDTH_M;

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
    pub range_rate_mps: f64,
    pub range_variance: f64,
    pub range_rate_variance: f64,
    pub lateral_variance: f64,
    /// Speed over ground along the line of sight, m/s.
    pub ground_speed_mps: f64,
    /// Half of the width of the rear whose middle it is, m; 0 of an echo.
    pub half_width_m: f64,
    pub detection: usize,
    /// Its vehicle, if the radar knows it.
    pub vehicle: Option<usize>,
    /// Place of the track that it belongs to.
    pub owner: Option<usize>,
}

impl Point {
    /// The detection number `index` on a straight road.
    pub fn new(index: usize, detection: &Detection, ego_mps: f64, receiver: &Receiver) -> Self {
        let (sine, cosine) = libm::sincos(detection.azimuth_rad);
        let (ahead_m, left_m) = (detection.range_m * cosine, detection.range_m * sine);
        let snr = snr_of(detection);
        let cross_m = detection.range_m / cosine.max(0.1);
        Self {
            x_m: ahead_m,
            y_m: left_m,
            direction: (cosine, sine),
            aspect_m: left_m,
            range_rate_mps: detection.range_rate_mps,
            range_variance: receiver.range.variance(snr).max(1e-6),
            range_rate_variance: receiver.range_rate.variance(snr).max(1e-6),
            lateral_variance: (receiver.azimuth.variance(snr) * cross_m * cross_m).max(1e-6),
            ground_speed_mps: detection.range_rate_mps + ego_mps * cosine,
            half_width_m: 0.0,
            detection: index,
            vehicle: None,
            owner: None,
        }
    }

    /// The point of a straight road on a course.
    pub fn on(self, course: &Course, detection: &Detection, ego: &Motion) -> Self {
        if course.is_straight {
            return self;
        }
        let (ego_mps, (cosine, sine)) = (ego.speed_mps, self.direction);
        let there = course.locate(self.x_m, self.y_m);
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
            ..self
        }
    }

    /// Speed relative to the ego along the road, for a lateral speed, m/s.
    pub fn relative_speed_mps(&self, lateral_mps: f64) -> f64 {
        let (cosine, sine) = self.direction;
        (self.range_rate_mps - lateral_mps * sine) / cosine.max(0.1)
    }
}

/// The outline that a track predicts, with its uncertainty.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// The vehicle that the radar knows it to be.
    pub vehicle: Option<usize>,
    /// It is confirmed.
    pub confirmed: bool,
    /// Position of the rear and of its lateral centre, m.
    pub rear_m: f64,
    /// Lateral position of its centre, m.
    pub lateral_m: f64,
    /// The same in the axes of the course there, seen from the radar, m.
    pub aspect_m: f64,
    pub length_m: f64,
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
    pub fn distance(&self, point: &Point, gate: f64, numbers: &Numbers) -> Option<f64> {
        let position_gate = numbers.surely_sigma * numbers.surely_sigma;
        let body = numbers.body_sigma_m * numbers.body_sigma_m;
        let along_m = point.x_m - self.rear_m;
        let off_y = ((point.y_m - self.lateral_m).abs() - self.half_width_m).max(0.0);
        let variance_x = self.variances[0] + point.range_variance + body;
        let variance_y = self.variances[1] + point.lateral_variance + body;
        let shows_side = self.aspect_m.abs() > VEHICLE_WIDTH_M;
        let beyond_m = if shows_side { numbers.beyond_along_side_m } else { numbers.beyond_m };
        let off_x = (-along_m).max(along_m - self.length_m - beyond_m).max(0.0);
        let (x, y) = (off_x * off_x / variance_x, off_y * off_y / variance_y);
        if x > position_gate || y > position_gate {
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
}

/// Gives every point to the track of its vehicle, or to the one with the nearest outline. Outlines are in the order of
/// the tracks.
pub fn associate(points: &mut [Point], outlines: &[Outline], gate: f64, numbers: &Numbers) {
    for point in points {
        if point.vehicle.is_some() {
            point.owner = outlines.iter().position(|outline| outline.vehicle == point.vehicle);
            continue;
        }
        let mut nearest = f64::INFINITY;
        for (place, outline) in outlines.iter().enumerate() {
            if let Some(distance) = outline.distance(point, gate, numbers)
                && distance < nearest
            {
                nearest = distance;
                point.owner = Some(place);
            }
        }
    }
}

/// Lets go of the points on one side of a track whose points are farther apart than a vehicle is wide. They are of two
/// vehicles abreast. It keeps those on the side on which it is expected.
pub fn part(points: &mut [Point], place: usize, expected_m: f64, numbers: &Numbers) {
    let (mut right_m, mut left_m, mut variance) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    for point in points.iter().filter(|point| point.owner == Some(place)) {
        right_m = right_m.min(point.y_m);
        left_m = left_m.max(point.y_m);
        variance = variance.max(point.lateral_variance);
    }
    if left_m - right_m < numbers.widest_m + numbers.surely_sigma * (2.0 * variance).sqrt() {
        return;
    }
    let middle_m = 0.5 * (left_m + right_m);
    let is_left = expected_m > middle_m;
    let others = points.iter_mut().filter(|point| (point.y_m > middle_m) != is_left);
    others.filter(|point| point.owner == Some(place)).for_each(|point| point.owner = None);
}

#[cfg(test)]
pub(super) mod tests;

#[cfg(test)]
mod exact_tests;
