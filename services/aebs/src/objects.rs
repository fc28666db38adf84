//! Objects from detections, by fixed rules.
//!
//! A detection at range R, azimuth φ and range rate ρ is a point at x = R cos φ, y = R sin φ that moves
//! with the speed v = v_ego + (ρ - w sin φ) / cos φ over ground, w being its object's lateral speed. Points
//! near an object in place and speed are its own; the rest begin new objects. Each scan then corrects an
//! object by its points:
//!
//! | quantity | from | filter |
//! |---|---|---|
//! | distance of the nearest face | points of that face | gain on the position, speed from below |
//! | speed over ground | all points | gain |
//! | acceleration | change of the speed | low-pass of [`ACCELERATION_S`] |
//! | lateral position and speed | the side that it shows, else its face | [`Lateral`] |
//! | length | the farthest point | the longest that was seen |
//!
//! The face's echoes merge and fluctuate, so that their middle wanders by [`FACE_SIGMA_M`]; the points of a
//! side are apart from one another in range, and as exact as the radar's azimuth: a vehicle beside the path
//! is located by the side that it shows.
//!
//! An object counts once it was seen in three of four scans; one that stands, in four of five, and only
//! near the ego's path: what stands beside the road is left out.

use crate::filter::Lateral;
use messages::Detection;

/// Most objects that are followed at a time.
pub const MAX_OBJECTS: usize = 48;

/// Half of the width that is assumed of every vehicle, m.
const HALF_WIDTH_M: f64 = 0.95;
/// Distance of what reflects on a side from the middle, m.
const SIDE_M: f64 = 0.9;
/// An object reaches so far behind its nearest face, m: longer ones come out as two.
const REACH_M: f64 = 6.0;
/// Length of an object of which only the face was seen, m.
const LEAST_LENGTH_M: f64 = 4.3;
/// What is behind the farthest point that reflects, m.
const OVERHANG_M: f64 = 0.9;
/// Points so near to the nearest face belong to it, m.
const FACE_M: f64 = 0.6;
/// If there are none, those so near show that it was expected elsewhere, m.
const MISSED_FACE_M: f64 = 1.2;
/// Points behind the face by more than this are of a side, m.
const SIDE_BEHIND_M: f64 = 0.45;
/// A side shows when it is this far from the ego's axis, m.
const SIDE_SHOWS_M: f64 = 0.15;
/// Points of a face that are this far apart are its two corners, m.
const BOTH_CORNERS_M: f64 = 1.4;
/// Points of one object differ from it by no more than this: speed, m/s, and lateral position, m.
const SAME: (f64, f64) = (2.5, 1.9);
/// Below this speed over ground an object stands, m/s.
const STANDING_MPS: f64 = 1.0;
/// Standing points farther off the path than this are left out, m.
const STANDING_OFFSET_M: f64 = 2.4;
/// Gains on distance and speed.
const DISTANCE_GAIN: f64 = 0.5;
const SPEED_GAIN: f64 = 0.6;
/// Time constant of the acceleration's low-pass, s.
const ACCELERATION_S: f64 = 0.2;
/// Standard deviation of the middle of a face, m; with both corners apart; and by range.
const FACE_SIGMA_M: f64 = 0.3;
const CORNERS_SIGMA_M: f64 = 0.1;
const FACE_SIGMA_RAD: f64 = 0.0025;
/// Standard deviation of an azimuth: of a strong echo, rad, and of one as strong as the noise.
const AZIMUTH_SIGMA_RAD: f64 = 0.0018;
const WEAK_SIGMA_RAD: f64 = 0.0205;
/// Standard deviation of the middle of a vehicle of which one point is known, m.
const FIRST_SIGMA_M: f64 = 0.7;
/// Standard deviation of a range, m.
const RANGE_SIGMA_M: f64 = 0.1;
/// Standard deviation of the place that reflects on a side, m.
const SIDE_SIGMA_M: f64 = 0.03;
/// A point of a side is within so many standard deviations of where the side is expected.
const SIDE_GATE: f64 = 3.0;
/// Scans after which an object's lateral speed is believed.
const LATERAL_SCANS: u32 = 5;
/// An object that counts is dropped after this time without a point, s.
const COAST_S: f64 = 0.4;
/// The same of one that is beside the ego, outside of the field of view, s.
const BESIDE_S: f64 = 3.0;
/// Distance over which a reflecting place is at the edge of the field of view, m.
const BLIND_MARGIN_M: f64 = 0.5;
/// Largest amplitude's signal-to-noise ratio in the weights, dB: one strong echo does not decide alone.
const STRONGEST_DB: f64 = 30.0;

/// An object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Distance of its nearest face, m ahead of the ego's front.
    pub distance_m: f64,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Lateral position of its middle, m left of the ego's axis, and its rate.
    pub lateral: Lateral,
    /// Half of its width, m.
    pub half_width_m: f64,
    /// Its length as far as it was seen, m.
    pub length_m: f64,
    /// It counts.
    pub is_confirmed: bool,
    /// Scans in which it was seen.
    scans: u32,
    /// Whether it was seen in each of the last scans, the newest in the lowest bit.
    history: u32,
    /// Time since it was last seen, s.
    unseen_s: f64,
}

impl Object {
    /// An object that counts, with a known motion.
    #[must_use]
    pub fn at(
        distance_m: f64,
        speed_mps: f64,
        offset_m: f64,
        lateral_mps: f64,
        half_width_m: f64,
    ) -> Self {
        Self {
            distance_m,
            speed_mps,
            acceleration_mps2: 0.0,
            lateral: Lateral::known(offset_m, lateral_mps),
            half_width_m,
            length_m: LEAST_LENGTH_M,
            is_confirmed: true,
            scans: LATERAL_SCANS,
            history: u32::MAX,
            unseen_s: 0.0,
        }
    }

    /// True once the lateral speed rests on enough scans.
    #[must_use]
    pub fn lateral_is_known(&self) -> bool {
        self.scans >= LATERAL_SCANS
    }

    /// True if it stands.
    #[must_use]
    pub fn stands(&self) -> bool {
        self.speed_mps.abs() < STANDING_MPS
    }

    /// It moved on by `time_s` beside an ego of `ego_mps`.
    #[must_use]
    pub fn moved_on(&self, time_s: f64, ego_mps: f64) -> Self {
        let mut later = *self;
        later.move_on(time_s, ego_mps);
        later.lateral.move_on(time_s);
        later
    }

    fn move_on(&mut self, time_s: f64, ego_mps: f64) {
        let speed = (self.speed_mps + self.acceleration_mps2 * time_s).max(0.0);
        // An object that comes towards the ego keeps its speed.
        let speed = if self.speed_mps < 0.0 { self.speed_mps } else { speed };
        self.distance_m += (0.5 * (self.speed_mps + speed) - ego_mps) * time_s;
        self.speed_mps = speed;
    }

    /// True if the nearer corner of its face is within half of the field of view.
    fn shows_its_face(&self, half_field_of_view_rad: f64) -> bool {
        let off_m = (self.lateral.position_m.abs() - SIDE_M).max(0.0);
        let surely_m = self.distance_m - BLIND_MARGIN_M;
        surely_m > 0.0 && off_m < surely_m * libm::tan(half_field_of_view_rad)
    }

    /// True if all of it that reflects is outside of the field of view, beside the ego.
    fn is_hidden_beside(&self, half_field_of_view_rad: f64) -> bool {
        let off_m = (self.lateral.position_m.abs() - SIDE_M).max(0.0);
        let last_m = self.distance_m + self.length_m - OVERHANG_M - BLIND_MARGIN_M;
        last_m <= 0.0 || off_m > last_m * libm::tan(half_field_of_view_rad)
    }

    /// Is carried on without a point: what has come to the ego's axis stays there.
    fn coast(&mut self) {
        self.acceleration_mps2 = 0.0;
        if self.lateral.position_m * self.lateral.rate_mps > 0.0
            && self.lateral.position_m.abs() < SIDE_M
        {
            self.lateral.rate_mps = 0.0;
        }
    }

    /// The side of the ego's axis on which it is, 1 left, -1 right, and how far off the axis the side is
    /// that it shows, m; `None` if it shows none.
    fn shown_side(&self) -> Option<(f64, f64)> {
        let side = self.lateral.position_m.signum();
        let off_m = self.lateral.position_m.abs() - SIDE_M;
        (off_m > SIDE_SHOWS_M).then_some((side, off_m))
    }
}

/// A detection as a point.
#[derive(Clone, Copy, Debug)]
struct Point {
    x_m: f64,
    y_m: f64,
    /// Speed over ground of what moves along the road.
    speed_mps: f64,
    /// Tangent of the azimuth.
    tangent: f64,
    amplitude: f64,
    /// Variance of the lateral position, m².
    variance_m2: f64,
}

impl Point {
    /// `None` for what is behind the antenna or stands beside the path.
    fn of(detection: &Detection, ego_mps: f64) -> Option<Self> {
        let (cosine, sine) = (libm::cos(detection.azimuth_rad), libm::sin(detection.azimuth_rad));
        if cosine < 0.1 {
            return None;
        }
        let x_m = detection.range_m * cosine;
        let weak_rad = WEAK_SIGMA_RAD * libm::exp10(-0.05 * detection.snr_db.clamp(0.0, 60.0));
        let along_m2 = RANGE_SIGMA_M * RANGE_SIGMA_M * sine * sine;
        let across_m2 = along_m2
            + x_m * x_m * (AZIMUTH_SIGMA_RAD * AZIMUTH_SIGMA_RAD + weak_rad * weak_rad)
                / (cosine * cosine * cosine * cosine);
        let point = Self {
            x_m,
            y_m: detection.range_m * sine,
            speed_mps: ego_mps + detection.range_rate_mps / cosine,
            tangent: sine / cosine,
            amplitude: libm::exp10(0.05 * detection.snr_db.clamp(0.0, STRONGEST_DB)),
            variance_m2: across_m2 + SIDE_SIGMA_M * SIDE_SIGMA_M,
        };
        let beside = point.y_m.abs() > STANDING_OFFSET_M;
        (!(beside && point.speed_mps.abs() < 2.0 * STANDING_MPS)).then_some(point)
    }
}

/// Sums over an object's points of one scan.
#[derive(Clone, Copy, Debug)]
struct Sums {
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
    /// Of the side's points: sum of the weights, and of the weighted lateral positions of the middle.
    side_weight: f64,
    side_y_m: f64,
}

impl Sums {
    const NONE: Self = Self {
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
    };

    fn add(&mut self, point: &Point, object: &Object) {
        self.points += 1.0;
        self.speed_mps += point.speed_mps - object.lateral.rate_mps * point.tangent;
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
        if let Some((side, off_m)) = object.shown_side()
            && behind_m > SIDE_BEHIND_M
        {
            let known_m2 = object.lateral.position_sigma_m() * object.lateral.position_sigma_m();
            let gate_m = SIDE_GATE * (known_m2 + point.variance_m2).sqrt();
            if (point.y_m - side * off_m).abs() < gate_m {
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

    /// Lateral position of the middle, m, with its variance, m², from the side and the face.
    fn lateral(&self, distance_m: f64, shows_its_face: bool) -> Option<(f64, f64)> {
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
            let of_face = 1.0 / (sigma_m * sigma_m + by_range_m * by_range_m);
            weight += of_face;
            weighted_m += of_face * middle_m;
        }
        (weight > 0.0).then(|| (weighted_m / weight, 1.0 / weight))
    }
}

/// All objects.
#[derive(Clone, Debug)]
pub struct Objects {
    list: Vec<Object>,
    sums: Vec<Sums>,
    last_scan_ns: Option<i64>,
    half_field_of_view_rad: f64,
}

impl Objects {
    /// No objects yet, of a radar with this field of view to each side, rad.
    #[must_use]
    pub fn new(half_field_of_view_rad: f64) -> Self {
        Self {
            list: Vec::with_capacity(MAX_OBJECTS),
            sums: Vec::with_capacity(MAX_OBJECTS),
            last_scan_ns: None,
            half_field_of_view_rad,
        }
    }

    /// The objects that count, as of the last scan.
    pub fn confirmed(&self) -> impl Iterator<Item = &Object> {
        self.list.iter().filter(|object| object.is_confirmed)
    }

    /// Takes the detections, nearest first, that were acquired at `scan_ns` by an ego of `ego_mps`. A
    /// scan that is not later than the last one is passed over. Allocates nothing.
    pub fn take_scan(&mut self, scan_ns: i64, ego_mps: f64, detections: &[Detection]) {
        let Some(period_s) = self.advance(scan_ns, ego_mps) else { return };
        let half_field_of_view_rad = self.half_field_of_view_rad;
        self.sums.clear();
        self.sums.resize(self.list.len(), Sums::NONE);
        for point in detections.iter().filter_map(|detection| Point::of(detection, ego_mps)) {
            self.assign(&point);
        }
        for (object, sums) in self.list.iter_mut().zip(&self.sums) {
            let shows_its_face = object.shows_its_face(half_field_of_view_rad);
            correct(object, sums, period_s, shows_its_face);
        }
        self.list.retain(|object| {
            let seen_lately = object.history & 0b11 != 0;
            let beside = object.is_hidden_beside(half_field_of_view_rad);
            let longest_s = if beside { BESIDE_S } else { COAST_S };
            if object.is_confirmed { object.unseen_s <= longest_s } else { seen_lately }
        });
    }

    /// Predicts all objects to the scan's time; returns the time since the last scan, s.
    fn advance(&mut self, scan_ns: i64, ego_mps: f64) -> Option<f64> {
        let elapsed_ns = self.last_scan_ns.map_or(i64::MAX, |last_ns| scan_ns - last_ns);
        if elapsed_ns <= 0 {
            return None;
        }
        let had_one = self.last_scan_ns.replace(scan_ns).is_some();
        let period_s = if had_one { elapsed_ns as f64 / 1e9 } else { 0.05 };
        if period_s > 1.0 {
            // Nothing is left of what was known.
            self.list.clear();
        }
        for object in &mut self.list {
            object.move_on(period_s, ego_mps);
            object.lateral.predict(period_s);
            object.unseen_s += period_s;
            object.history <<= 1;
        }
        Some(period_s)
    }

    fn assign(&mut self, point: &Point) {
        let mut best: Option<(f64, usize)> = None;
        for (index, object) in self.list.iter().enumerate() {
            let (dx, dv, dy) = (
                point.x_m - object.distance_m,
                (point.speed_mps - object.speed_mps).abs(),
                (point.y_m - object.lateral.position_m).abs(),
            );
            let slack_m = 1.5 + object.unseen_s * 3.0;
            if dx < -slack_m || dx > REACH_M || dv > SAME.0 || dy > SAME.1 {
                continue;
            }
            let cost = dv / SAME.0 + dy / SAME.1 + dx.abs() / REACH_M;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, index));
            }
        }
        match best {
            Some((_, index)) => self.sums[index].add(point, &self.list[index]),
            None if self.list.len() < MAX_OBJECTS => self.begin(point),
            None => {}
        }
    }

    fn begin(&mut self, point: &Point) {
        let object = Object {
            distance_m: point.x_m,
            speed_mps: point.speed_mps,
            acceleration_mps2: 0.0,
            lateral: Lateral::first(point.y_m, FIRST_SIGMA_M),
            half_width_m: HALF_WIDTH_M,
            length_m: LEAST_LENGTH_M,
            is_confirmed: false,
            scans: 0,
            history: 0,
            unseen_s: 0.0,
        };
        let mut sums = Sums::NONE;
        sums.add(point, &object);
        self.list.push(object);
        self.sums.push(sums);
    }
}

/// Corrects an object by the points of a scan, if there are any.
fn correct(object: &mut Object, sums: &Sums, period_s: f64, shows_its_face: bool) {
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
    if let Some((middle_m, variance_m2)) = sums.lateral(object.distance_m, first || shows_its_face)
    {
        if first {
            object.lateral = Lateral::first(middle_m, FIRST_SIGMA_M);
        } else {
            object.lateral.update(middle_m, variance_m2);
        }
    }
    object.length_m = object.length_m.max(sums.farthest_m + OVERHANG_M);
    let seen = |scans: u32| (object.history & ((1 << scans) - 1)).count_ones();
    object.is_confirmed |= if object.stands() { seen(5) >= 4 } else { seen(4) >= 3 };
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: i64 = 50_000_000;
    const HALF_FIELD_RAD: f64 = 0.52;

    fn detection(x_m: f64, y_m: f64, relative_mps: f64) -> Detection {
        let azimuth_rad = libm::atan2(y_m, x_m);
        Detection {
            range_m: (x_m * x_m + y_m * y_m).sqrt(),
            range_rate_mps: relative_mps * libm::cos(azimuth_rad),
            azimuth_rad,
            snr_db: 25.0,
            rcs_dbsm: 10.0,
            flags: 0,
            ambiguity_group: 0,
        }
    }

    /// Scans a vehicle of five points whose rear is at `x(t)` and middle at `y(t)`.
    fn follow(objects: &mut Objects, scans: i64, x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64) {
        let ego_mps = 20.0;
        for k in 0..scans {
            let t = k as f64 * 0.05;
            let relative_mps = (x(t + 1e-6) - x(t)) / 1e-6;
            let points = [(0.0, 0.0), (0.0, 0.9), (0.0, -0.9), (0.8, 0.9), (3.4, 0.9)];
            let list = points.map(|(dx, dy)| detection(x(t) + dx, y(t) + dy, relative_mps));
            objects.take_scan(k * PERIOD_NS, ego_mps, &list);
        }
    }

    #[test]
    fn one_vehicle_of_many_points_is_one_object() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 20, |t| 40.0 - 5.0 * t, |_| 0.2);
        let list: Vec<_> = objects.confirmed().collect();
        assert_eq!(list.len(), 1, "{list:?}");
        let object = list[0];
        assert!((object.distance_m - (40.0 - 5.0 * 0.95)).abs() < 0.3, "{object:?}");
        assert!((object.speed_mps - 15.0).abs() < 0.1);
        assert!((object.lateral.position_m - 0.2).abs() < 0.3);
    }

    #[test]
    fn three_scans_confirm_what_moves() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 2, |t| 40.0 - 5.0 * t, |_| 0.0);
        assert_eq!(objects.confirmed().count(), 0);
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 3, |t| 40.0 - 5.0 * t, |_| 0.0);
        assert_eq!(objects.confirmed().count(), 1);
    }

    #[test]
    fn hard_braking_is_found_within_a_quarter_of_a_second() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        let x = |t: f64| 40.0 - if t > 1.0 { 4.5 * (t - 1.0) * (t - 1.0) } else { 0.0 };
        follow(&mut objects, 26, x, |_| 0.0);
        let object = objects.confirmed().next().expect("seen for a second");
        assert!(object.acceleration_mps2 < -4.5, "{object:?}");
    }

    #[test]
    fn a_cut_in_shows_its_lateral_speed() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 30, |t| 25.0 - 5.0 * t, |t| 3.5 - 1.0 * t);
        let object = objects.confirmed().next().expect("seen for a second");
        assert!((object.lateral.rate_mps + 1.0).abs() < 0.2, "{object:?}");
    }

    #[test]
    fn what_stands_beside_the_road_is_no_object_and_what_stands_ahead_is() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 10, |t| 80.0 - 20.0 * t, |_| 6.0);
        assert_eq!(objects.confirmed().count(), 0);
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 10, |t| 80.0 - 20.0 * t, |_| 0.3);
        assert!(objects.confirmed().next().is_some_and(Object::stands));
    }

    #[test]
    fn scattered_false_alarms_become_nothing() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31)
        };
        for k in 0..20_000 {
            let scattered =
                detection(150.0 * random(), 20.0 * random() - 10.0, 60.0 * random() - 50.0);
            objects.take_scan(k * PERIOD_NS, 25.0, &[scattered]);
            assert_eq!(objects.confirmed().count(), 0, "scan {k}");
        }
    }

    #[test]
    fn an_object_out_of_sight_is_kept_for_a_while_and_then_dropped() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 20, |t| 40.0 - 5.0 * t, |_| 0.0);
        for k in 20..28 {
            objects.take_scan(k * PERIOD_NS, 20.0, &[]);
            assert_eq!(objects.confirmed().count(), 1, "scan {k}");
        }
        objects.take_scan(29 * PERIOD_NS, 20.0, &[]);
        assert_eq!(objects.confirmed().count(), 0);
    }

    #[test]
    fn what_is_beside_the_ego_and_out_of_sight_is_carried_on() {
        // Its rear passes the edge of the field of view, then all of it does.
        let mut objects = Objects::new(HALF_FIELD_RAD);
        let x = |t: f64| 12.0 - 6.0 * t;
        for k in 0..80 {
            let t = k as f64 * 0.05;
            let places = [(0.0, 0.0), (0.0, 0.9), (0.0, -0.9), (0.9, -0.9), (3.4, -0.9)];
            let list: Vec<_> = places
                .map(|(dx, dy)| detection(x(t) + dx, 3.5 + dy, -6.0))
                .into_iter()
                .filter(|detection| detection.azimuth_rad.abs() < HALF_FIELD_RAD)
                .collect();
            objects.take_scan(k * PERIOD_NS, 20.0, &list);
            let kept = objects.confirmed().next();
            if k >= 3 && x(t) > -4.0 {
                let object = kept.unwrap_or_else(|| panic!("it is lost at {} m", x(t)));
                assert!((object.distance_m - x(t)).abs() < 0.6, "{} {object:?}", x(t));
                assert!((object.lateral.position_m - 3.5).abs() < 0.3, "{} {object:?}", x(t));
            }
        }
    }
}
