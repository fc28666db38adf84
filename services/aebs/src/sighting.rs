//! Measurement of one object from all its points in one scan.

use crate::filter::Lateral;
use crate::object::{FIRST_SIGMA_M, OVERHANG_M, Object, SIDE_M};
use crate::point::{Point, SIDE_SIGMA_M};

/// Points so near to the nearest face belong to it, m. If there are none, the second distance shows that it was
/// expected elsewhere.
const FACE_M: [f64; 2] = [0.6, 1.2];
/// Points behind the face by more than this are of a side, m.
const SIDE_BEHIND_M: f64 = 0.45;
/// Standard deviation of the middle of a face, m: of few points, with both corners, and by range.
const FACE_SIGMA_M: f64 = 0.3;
const CORNERS_SIGMA_M: f64 = 0.1;
const FACE_SIGMA_RAD: f64 = 0.0025;
/// A point is within this many standard deviations of where a side is expected.
const GATE: f64 = 3.0;
/// Standard deviation of a lateral speed from range rates that more points do not improve, m/s.
const SLOPE_SIGMA_MPS: f64 = 0.1;
/// Least information on it of use, s²/m²: a standard deviation of 3 m/s.
const LEAST_INFORMATION: f64 = 0.1;
/// Gains on distance and speed.
const DISTANCE_GAIN: f64 = 0.5;
const SPEED_GAIN: f64 = 0.6;
/// Time constant of the acceleration's low-pass, s, and the limits of vehicles, m/s².
const ACCELERATION_S: f64 = 0.2;
const LIMITS_MPS2: (f64, f64) = (-10.0, 5.0);

/// Corrects an object by its points of a scan, if there are any. It is expected to be seen in a `share` of the scans.
pub(crate) fn correct(
    object: &mut Object,
    points: &[Point],
    period_s: f64,
    shows_its_face: bool,
    share: f64,
) {
    let rate_mps = object.lateral.rate_mps;
    let speeds = points.iter().map(|point| point.speed_mps - rate_mps * point.tangent);
    let Some(measured_mps) = mean(speeds) else {
        object.acceleration_mps2 = 0.0;
        return;
    };
    let is_first = object.history == 0 && !object.is_confirmed;
    let shows_its_face = is_first || shows_its_face;
    let lateral = lateral(object, points, shows_its_face);
    let farthest_m = points.iter().map(|point| point.x_m - object.distance_m).fold(0.0, f64::max);
    // Without its face the nearest point is one of its side.
    let face_m = face_m(object, points).filter(|_| shows_its_face).unwrap_or(object.distance_m);
    if is_first {
        (object.speed_mps, object.distance_m) = (measured_mps, face_m);
        if let Some((middle_m, _)) = lateral {
            object.lateral = Lateral::first(middle_m, FIRST_SIGMA_M);
        }
    } else {
        object.distance_m += DISTANCE_GAIN * (face_m - object.distance_m);
        // The prediction has moved the speed by the acceleration already.
        let corrected_mps = SPEED_GAIN * (measured_mps - object.speed_mps);
        object.speed_mps += corrected_mps;
        object.acceleration_mps2 += corrected_mps / (ACCELERATION_S + period_s);
        object.acceleration_mps2 = object.acceleration_mps2.clamp(LIMITS_MPS2.0, LIMITS_MPS2.1);
        if let Some((middle_m, variance_m2)) = lateral {
            object.lateral.update(middle_m, variance_m2);
        }
        if let Some((rate_mps, variance)) = lateral_rate(points) {
            object.lateral.update_rate(rate_mps, variance);
        }
    }
    object.length_m = object.length_m.max(farthest_m + OVERHANG_M);
    object.unseen_s = 0.0;
    object.history |= 1;
    let seen = |scans: u32| object.times_seen(scans, share);
    object.is_confirmed |= if object.stands() { seen(5) >= 4 } else { seen(4) >= 3 };
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Points within `near_m` of the face.
fn face<'a>(
    object: &Object,
    points: &'a [Point],
    near_m: f64,
) -> impl Iterator<Item = &'a Point> + Clone {
    let distance_m = object.distance_m;
    points.iter().filter(move |point| (point.x_m - distance_m).abs() <= near_m)
}

/// Distance of the face, m.
fn face_m(object: &Object, points: &[Point]) -> Option<f64> {
    let seen = |near_m| mean(face(object, points, near_m).map(|point| point.x_m));
    FACE_M.into_iter().find_map(seen)
}

/// Lateral position of the middle, m, with its variance, m², from the side and the face.
fn lateral(object: &Object, points: &[Point], shows_its_face: bool) -> Option<(f64, f64)> {
    let of_face = shows_its_face.then(|| middle_of_face(object, points)).flatten();
    let seen = middle_by_side(object, points).into_iter().chain(of_face);
    let (weight, sum_m) = seen.fold((0.0, 0.0), |(weight, sum_m), (middle_m, variance_m2)| {
        (weight + 1.0 / variance_m2, sum_m + middle_m / variance_m2)
    });
    let by_range_m = FACE_SIGMA_RAD * object.distance_m;
    (weight > 0.0).then(|| (sum_m / weight, 1.0 / weight + by_range_m * by_range_m))
}

fn middle_by_side(object: &Object, points: &[Point]) -> Option<(f64, f64)> {
    let is_open = |shown_m: f64| object.open_m.0 < shown_m && shown_m < object.open_m.1;
    let (side, shown_m) = object.shown_side().filter(|(_, shown_m)| is_open(*shown_m))?;
    let sigma_m = object.lateral.position_sigma_m();
    let (mut weight, mut sum_m) = (0.0, 0.0);
    for point in points {
        let gate_m = GATE * (sigma_m * sigma_m + point.variance_m2).sqrt();
        let is_behind = point.x_m - object.distance_m > SIDE_BEHIND_M;
        if is_behind && (point.y_m - shown_m).abs() < gate_m {
            weight += 1.0 / point.variance_m2;
            sum_m += (point.y_m + side * SIDE_M) / point.variance_m2;
        }
    }
    // All points share the error of the place that reflects.
    (weight > 0.0).then(|| (sum_m / weight, 1.0 / weight + SIDE_SIGMA_M * SIDE_SIGMA_M))
}

/// The middle of a face is between its outermost points. In the room that they leave on the body it is equally probable.
fn middle_of_face(object: &Object, points: &[Point]) -> Option<(f64, f64)> {
    let places_m = face(object, points, FACE_M[0]).map(|point| point.y_m);
    let (least_m, most_m) = (places_m.clone().reduce(f64::min)?, places_m.reduce(f64::max)?);
    let middle_m = 0.5 * (least_m + most_m);
    let room_m = (2.0 * SIDE_M - (most_m - least_m)).max(0.0);
    let sigma_m = (room_m / 12.0_f64.sqrt()).clamp(CORNERS_SIGMA_M, FACE_SIGMA_M);
    // Seen is the middle of a strip from the shadow to a corner. Half of the strip is missing to half of the body.
    let hidden = |open_m: f64| (SIDE_M - open_m.max(0.0)).max(0.0);
    let hidden_m = hidden(object.open_m.1 - middle_m) - hidden(middle_m - object.open_m.0);
    let variance_m2 = sigma_m * sigma_m + hidden_m * hidden_m / 12.0;
    Some((middle_m + hidden_m, variance_m2))
}

/// Lateral speed from the range rates' dependence on the direction, m/s, with its variance.
fn lateral_rate(points: &[Point]) -> Option<(f64, f64)> {
    let (mut w, mut t, mut tt, mut v, mut vt) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for point in points {
        let weight = 1.0 / point.speed_variance;
        let (tangent, speed) = (weight * point.tangent, weight * point.speed_mps);
        (w, t, v) = (w + weight, t + tangent, v + speed);
        (tt, vt) = (tt + tangent * point.tangent, vt + speed * point.tangent);
    }
    let information = tt - t * t / w;
    let variance = 1.0 / information + SLOPE_SIGMA_MPS * SLOPE_SIGMA_MPS;
    (points.len() > 1 && information > LEAST_INFORMATION)
        .then(|| ((vt - t * v / w) / information, variance))
}

#[cfg(test)]
mod tests;
