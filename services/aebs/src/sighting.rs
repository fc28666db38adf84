//! Measurement of one object from all its points in one scan.

use crate::filter::Lateral;
use crate::object::{FIRST_SIGMA_M, OVERHANG_M, Object, SIDE_M};
use crate::point::{Point, SIDE_SIGMA_M};

/// Points so near to the nearest face belong to it, m.
const FACE_M: f64 = 0.6;
/// If there are none, those so near show that it was expected elsewhere, m.
const MISSED_FACE_M: f64 = 1.2;
/// Points behind the face by more than this are of a side, m.
const SIDE_BEHIND_M: f64 = 0.45;
/// Points of a face that are this far apart are its two corners, m.
const BOTH_CORNERS_M: f64 = 1.4;
/// Standard deviation of the middle of a face, m; with both corners apart; and by range.
const FACE_SIGMA_M: f64 = 0.3;
const CORNERS_SIGMA_M: f64 = 0.1;
const FACE_SIGMA_RAD: f64 = 0.0025;
/// A point of a side is within this many standard deviations of the side's expected place.
const SIDE_GATE: f64 = 3.0;
/// Standard deviation of a lateral speed from range rates that more points do not improve, m/s.
const SLOPE_SIGMA_MPS: f64 = 0.1;
/// Least information on it of use, s²/m²: a standard deviation of 3 m/s.
const LEAST_INFORMATION: f64 = 0.1;
/// Gains on distance and speed.
const DISTANCE_GAIN: f64 = 0.5;
const SPEED_GAIN: f64 = 0.6;
/// Time constant of the acceleration's low-pass, s.
const ACCELERATION_S: f64 = 0.2;

/// Sums over an object's points of one scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sums {
    points: f64,
    speed_mps: f64,
    farthest_m: f64,
    missed_points: f64,
    missed_x_m: f64,
    face_points: f64,
    face_x_m: f64,
    face_amplitude: f64,
    face_y_m: f64,
    /// Least and largest lateral position of the face.
    face_ends_m: (f64, f64),
    /// Sums over the points of the side: weights, and weighted lateral positions of the middle.
    side_weight: f64,
    side_y_m: f64,
    /// Weighted sums over all points, for the line of the speeds over the tangents.
    line: [f64; 5],
}

impl Sums {
    pub(crate) const NONE: Self = Self {
        points: 0.0,
        speed_mps: 0.0,
        farthest_m: 0.0,
        missed_points: 0.0,
        missed_x_m: 0.0,
        face_points: 0.0,
        face_x_m: 0.0,
        face_amplitude: 0.0,
        face_y_m: 0.0,
        face_ends_m: (f64::INFINITY, f64::NEG_INFINITY),
        side_weight: 0.0,
        side_y_m: 0.0,
        line: [0.0; 5],
    };

    pub(crate) fn add(&mut self, point: &Point, object: &Object) {
        self.points += 1.0;
        self.speed_mps += point.speed_mps - object.lateral.rate_mps * point.tangent;
        let weight = 1.0 / point.speed_variance;
        let (t, v) = (point.tangent, point.speed_mps);
        for (sum, term) in self.line.iter_mut().zip([1.0, t, t * t, v, v * t]) {
            *sum += weight * term;
        }
        let behind_m = point.x_m - object.distance_m;
        self.farthest_m = self.farthest_m.max(behind_m);
        if behind_m.abs() <= MISSED_FACE_M {
            self.missed_points += 1.0;
            self.missed_x_m += point.x_m;
        }
        if behind_m.abs() <= FACE_M {
            self.face_points += 1.0;
            self.face_x_m += point.x_m;
            self.face_amplitude += point.amplitude;
            self.face_y_m += point.amplitude * point.y_m;
            let (least_m, most_m) = self.face_ends_m;
            self.face_ends_m = (least_m.min(point.y_m), most_m.max(point.y_m));
        }
        if let Some((side, shown_m)) = object.shown_side()
            && behind_m > SIDE_BEHIND_M
        {
            let known_m = object.lateral.position_sigma_m();
            let known_m2 = known_m * known_m;
            let gate_m = SIDE_GATE * (known_m2 + point.variance_m2).sqrt();
            if (point.y_m - shown_m).abs() < gate_m {
                self.side_weight += 1.0 / point.variance_m2;
                self.side_y_m += (point.y_m + side * SIDE_M) / point.variance_m2;
            }
        }
    }

    /// Distance of the face, m.
    fn face_m(&self) -> Option<f64> {
        if self.face_points > 0.0 {
            Some(self.face_x_m / self.face_points)
        } else {
            (self.missed_points > 0.0).then(|| self.missed_x_m / self.missed_points)
        }
    }

    /// Lateral speed from the range rates' dependence on the direction, m/s, with its variance.
    fn lateral_rate(&self) -> Option<(f64, f64)> {
        let [w, t, tt, v, vt] = self.line;
        let information = tt - t * t / w;
        let variance = 1.0 / information + SLOPE_SIGMA_MPS * SLOPE_SIGMA_MPS;
        (self.points > 1.0 && information > LEAST_INFORMATION)
            .then(|| ((vt - t * v / w) / information, variance))
    }

    /// Lateral position of the middle, m, with its variance, m², from the side and the face. `hidden_side`: the side on
    /// which the face is hidden (1 left, -1 right), from its middle or from beyond on. It is 0 if the face is not
    /// hidden.
    fn lateral(
        &self,
        distance_m: f64,
        shows_its_face: bool,
        hidden_side: f64,
    ) -> Option<(f64, f64)> {
        let (mut weight, mut weighted_m) = (0.0, 0.0);
        if self.side_weight > 0.0 {
            let shared_m2 = SIDE_SIGMA_M * SIDE_SIGMA_M;
            weight = 1.0 / (1.0 / self.side_weight + shared_m2);
            weighted_m = weight * self.side_y_m / self.side_weight;
        }
        if self.face_points > 0.0 && shows_its_face {
            let (least_m, most_m) = self.face_ends_m;
            let (middle_m, sigma_m) = if most_m - least_m > BOTH_CORNERS_M {
                (0.5 * (least_m + most_m), CORNERS_SIGMA_M)
            } else {
                (self.face_y_m / self.face_amplitude, FACE_SIGMA_M)
            };
            let by_range_m = FACE_SIGMA_RAD * distance_m;
            // The middle is between what is seen and half a width beyond, all alike.
            let hidden_m = SIDE_M * hidden_side;
            let hidden_m2 = hidden_m * hidden_m / 12.0;
            let of_face = 1.0 / (sigma_m * sigma_m + by_range_m * by_range_m + hidden_m2);
            weight += of_face;
            weighted_m += of_face * (middle_m + 0.5 * hidden_m);
        }
        (weight > 0.0).then(|| (weighted_m / weight, 1.0 / weight))
    }
}

/// Corrects an object by the points of a scan, if there are any. It is expected to be seen in a `share` of the scans.
pub(crate) fn correct(
    object: &mut Object,
    sums: &Sums,
    period_s: f64,
    shows_its_face: bool,
    share: f64,
) {
    if sums.points == 0.0 {
        object.coast();
        return;
    }
    object.scans += 1;
    object.unseen_s = 0.0;
    object.history |= 1;
    let first = object.scans == 1;
    let before_mps = object.speed_mps;
    let measured_mps = sums.speed_mps / sums.points;
    object.speed_mps += if first { 1.0 } else { SPEED_GAIN } * (measured_mps - before_mps);
    if !first {
        // The prediction has moved the speed by the acceleration already.
        let excess = (object.speed_mps - before_mps) / period_s;
        object.acceleration_mps2 += period_s / (ACCELERATION_S + period_s) * excess;
        object.acceleration_mps2 = object.acceleration_mps2.clamp(-10.0, 5.0);
    }
    // Without its face the nearest point is one of its side.
    if (first || shows_its_face)
        && let Some(face_m) = sums.face_m()
    {
        let gain = if first { 1.0 } else { DISTANCE_GAIN };
        object.distance_m += gain * (face_m - object.distance_m);
    }
    // A face that another object half hides shows its other side, or a part farther along that object's side.
    let hidden_side = if first { 0.0 } else { object.hidden_side };
    let shows_its_face = first || shows_its_face;
    if let Some((middle_m, variance_m2)) =
        sums.lateral(object.distance_m, shows_its_face, hidden_side)
    {
        if first {
            object.lateral = Lateral::first(middle_m, FIRST_SIGMA_M);
        } else {
            object.lateral.update(middle_m, variance_m2);
        }
    }
    if !first && let Some((rate_mps, variance)) = sums.lateral_rate() {
        object.lateral.update_rate(rate_mps, variance);
    }
    object.length_m = object.length_m.max(sums.farthest_m + OVERHANG_M);
    let seen = |scans: u32| object.times_seen(scans, share);
    object.is_confirmed |= if object.stands() { seen(5) >= 4 } else { seen(4) >= 3 };
}

#[cfg(test)]
mod tests;
