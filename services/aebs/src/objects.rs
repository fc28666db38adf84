//! Objects from detections, by fixed rules and fixed gains.
//!
//! A detection at range R, azimuth φ and range rate ρ is a point at x = R cos φ, y = R sin φ that moves
//! with the speed v = v_ego + ρ / cos φ over ground. Points near an object in place and speed are its
//! own; the rest begin new objects. Each scan then corrects an object by the mean of its points:
//!
//! | quantity | from | filter |
//! |---|---|---|
//! | distance of the nearest face | points of that face | gain on the position, speed from below |
//! | speed over ground | all points | gain |
//! | acceleration | change of the speed | low-pass of [`ACCELERATION_S`] |
//! | lateral position and speed | points of the nearest face, by amplitude | [`AlphaBeta`] |
//!
//! An object counts once it was seen in three of four scans; one that stands, in four of five, and only
//! near the ego's path: what stands beside the road is left out.

use crate::filter::{AlphaBeta, Gains};
use messages::Detection;

/// Most objects that are followed at a time.
pub const MAX_OBJECTS: usize = 48;

/// Half of the width that is assumed of every vehicle, m.
const HALF_WIDTH_M: f64 = 0.95;
/// An object reaches so far behind its nearest face, m: longer ones come out as two.
const REACH_M: f64 = 6.0;
/// Points so near to the nearest face belong to it, m.
const FACE_M: f64 = 1.2;
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
/// Lateral acceleration that the lateral filter follows, m/s².
const LATERAL_ACCELERATION_MPS2: f64 = 3.0;
/// Standard deviation of the lateral position: the least, m, and by range.
const LATERAL_SIGMA_M: f64 = 0.25;
const LATERAL_SIGMA_RAD: f64 = 0.006;
/// Scans after which an object's lateral speed is believed.
const LATERAL_SCANS: u32 = 4;
/// An object that counts is dropped after this time without a point, s.
const COAST_S: f64 = 0.4;
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
    pub lateral: AlphaBeta,
    /// Half of its width, m.
    pub half_width_m: f64,
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
            lateral: AlphaBeta { position_m: offset_m, rate_mps: lateral_mps },
            half_width_m,
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
        later.predict(time_s, ego_mps);
        later
    }

    fn predict(&mut self, time_s: f64, ego_mps: f64) {
        let speed = (self.speed_mps + self.acceleration_mps2 * time_s).max(0.0);
        // An object that comes towards the ego keeps its speed.
        let speed = if self.speed_mps < 0.0 { self.speed_mps } else { speed };
        self.distance_m += (0.5 * (self.speed_mps + speed) - ego_mps) * time_s;
        self.speed_mps = speed;
        self.lateral.predict(time_s);
    }
}

/// A detection as a point.
#[derive(Clone, Copy, Debug)]
struct Point {
    x_m: f64,
    y_m: f64,
    speed_mps: f64,
    amplitude: f64,
}

impl Point {
    /// `None` for what is behind the antenna or stands beside the path.
    fn of(detection: &Detection, ego_mps: f64) -> Option<Self> {
        let (cosine, sine) = (libm::cos(detection.azimuth_rad), libm::sin(detection.azimuth_rad));
        if cosine < 0.1 {
            return None;
        }
        let point = Self {
            x_m: detection.range_m * cosine,
            y_m: detection.range_m * sine,
            speed_mps: ego_mps + detection.range_rate_mps / cosine,
            amplitude: libm::exp10(0.05 * detection.snr_db.clamp(0.0, STRONGEST_DB)),
        };
        let beside = point.y_m.abs() > STANDING_OFFSET_M;
        (!(beside && point.speed_mps.abs() < 2.0 * STANDING_MPS)).then_some(point)
    }
}

/// Sums over an object's points of one scan.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    points: f64,
    speed_mps: f64,
    face_points: f64,
    face_x_m: f64,
    face_amplitude: f64,
    face_y_m: f64,
}

impl Sums {
    fn add(&mut self, point: &Point, distance_m: f64) {
        self.points += 1.0;
        self.speed_mps += point.speed_mps;
        if (point.x_m - distance_m).abs() <= FACE_M {
            self.face_points += 1.0;
            self.face_x_m += point.x_m;
            self.face_amplitude += point.amplitude;
            self.face_y_m += point.amplitude * point.y_m;
        }
    }
}

/// All objects.
#[derive(Clone, Debug)]
pub struct Objects {
    list: Vec<Object>,
    sums: Vec<Sums>,
    last_scan_ns: Option<i64>,
}

impl Default for Objects {
    fn default() -> Self {
        Self {
            list: Vec::with_capacity(MAX_OBJECTS),
            sums: Vec::with_capacity(MAX_OBJECTS),
            last_scan_ns: None,
        }
    }
}

impl Objects {
    /// The objects that count, as of the last scan.
    pub fn confirmed(&self) -> impl Iterator<Item = &Object> {
        self.list.iter().filter(|object| object.is_confirmed)
    }

    /// Takes the detections, nearest first, that were acquired at `scan_ns` by an ego of `ego_mps`. A
    /// scan that is not later than the last one is passed over. Allocates nothing.
    pub fn take_scan(&mut self, scan_ns: i64, ego_mps: f64, detections: &[Detection]) {
        let Some(period_s) = self.advance(scan_ns, ego_mps) else { return };
        self.sums.clear();
        self.sums.resize(self.list.len(), Sums::default());
        for point in detections.iter().filter_map(|detection| Point::of(detection, ego_mps)) {
            self.assign(&point);
        }
        for (object, sums) in self.list.iter_mut().zip(&self.sums) {
            correct(object, sums, period_s);
        }
        self.list.retain(|object| {
            let seen_lately = object.history & 0b11 != 0;
            if object.is_confirmed { object.unseen_s <= COAST_S } else { seen_lately }
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
            object.predict(period_s, ego_mps);
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
            Some((_, index)) => {
                let distance_m = self.list[index].distance_m;
                self.sums[index].add(point, distance_m);
            }
            None if self.list.len() < MAX_OBJECTS => self.begin(point),
            None => {}
        }
    }

    fn begin(&mut self, point: &Point) {
        self.list.push(Object {
            distance_m: point.x_m,
            speed_mps: point.speed_mps,
            acceleration_mps2: 0.0,
            lateral: AlphaBeta { position_m: point.y_m, rate_mps: 0.0 },
            half_width_m: HALF_WIDTH_M,
            is_confirmed: false,
            scans: 0,
            history: 0,
            unseen_s: 0.0,
        });
        let mut sums = Sums::default();
        sums.add(point, point.x_m);
        self.sums.push(sums);
    }
}

/// Corrects an object by the points of a scan, if there are any.
fn correct(object: &mut Object, sums: &Sums, period_s: f64) {
    if sums.points == 0.0 {
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
    if sums.face_points > 0.0 {
        let gain = if first { 1.0 } else { DISTANCE_GAIN };
        object.distance_m += gain * (sums.face_x_m / sums.face_points - object.distance_m);
        let offset_m = sums.face_y_m / sums.face_amplitude;
        if first {
            object.lateral = AlphaBeta { position_m: offset_m, rate_mps: 0.0 };
        } else {
            let sigma_m = LATERAL_SIGMA_M.max(LATERAL_SIGMA_RAD * object.distance_m);
            let index = LATERAL_ACCELERATION_MPS2 * period_s * period_s / sigma_m;
            let gains = Gains::of_index(index).at_least(Gains::of_count(object.scans));
            object.lateral.update(offset_m, period_s, gains);
        }
    }
    let seen = |scans: u32| (object.history & ((1 << scans) - 1)).count_ones();
    object.is_confirmed |= if object.stands() { seen(5) >= 4 } else { seen(4) >= 3 };
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: i64 = 50_000_000;

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
        let mut objects = Objects::default();
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
        let mut objects = Objects::default();
        follow(&mut objects, 2, |t| 40.0 - 5.0 * t, |_| 0.0);
        assert_eq!(objects.confirmed().count(), 0);
        let mut objects = Objects::default();
        follow(&mut objects, 3, |t| 40.0 - 5.0 * t, |_| 0.0);
        assert_eq!(objects.confirmed().count(), 1);
    }

    #[test]
    fn hard_braking_is_found_within_a_quarter_of_a_second() {
        let mut objects = Objects::default();
        let x = |t: f64| 40.0 - if t > 1.0 { 4.5 * (t - 1.0) * (t - 1.0) } else { 0.0 };
        follow(&mut objects, 26, x, |_| 0.0);
        let object = objects.confirmed().next().expect("seen for a second");
        assert!(object.acceleration_mps2 < -4.5, "{object:?}");
    }

    #[test]
    fn a_cut_in_shows_its_lateral_speed() {
        let mut objects = Objects::default();
        follow(&mut objects, 30, |t| 25.0 - 5.0 * t, |t| 3.5 - 1.0 * t);
        let object = objects.confirmed().next().expect("seen for a second");
        assert!((object.lateral.rate_mps + 1.0).abs() < 0.2, "{object:?}");
    }

    #[test]
    fn what_stands_beside_the_road_is_no_object_and_what_stands_ahead_is() {
        let mut objects = Objects::default();
        follow(&mut objects, 10, |t| 80.0 - 20.0 * t, |_| 6.0);
        assert_eq!(objects.confirmed().count(), 0);
        let mut objects = Objects::default();
        follow(&mut objects, 10, |t| 80.0 - 20.0 * t, |_| 0.3);
        assert!(objects.confirmed().next().is_some_and(Object::stands));
    }

    #[test]
    fn scattered_false_alarms_become_nothing() {
        let mut objects = Objects::default();
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
        let mut objects = Objects::default();
        follow(&mut objects, 20, |t| 40.0 - 5.0 * t, |_| 0.0);
        for k in 20..28 {
            objects.take_scan(k * PERIOD_NS, 20.0, &[]);
            assert_eq!(objects.confirmed().count(), 1, "scan {k}");
        }
        objects.take_scan(29 * PERIOD_NS, 20.0, &[]);
        assert_eq!(objects.confirmed().count(), 0);
    }
}
