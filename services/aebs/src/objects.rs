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
//! | acceleration | change of the speed | low-pass of 0.2 s |
//! | lateral position | the side that it shows, else its face | [`crate::filter`] |
//! | lateral speed | the range rates of points in different directions | the same |
//! | length | the farthest point | the longest that was seen |
//!
//! The face's echoes merge and fluctuate, so that their middle wanders by 0.3 m; the points of a
//! side are apart from one another in range, and as exact as the radar's azimuth: a vehicle beside the path
//! is located by the side that it shows.
//!
//! Where a nearer object stands before its face, only the inner part shows; and of a vehicle longer than
//! [`REACH_M`] what is farther along its side comes out as objects of their own. Their middle is up to half a
//! width farther from the path than what is seen of the face.
//!
//! An object counts once it was seen in three of four scans; one that stands, in four of five, and not
//! beyond the neighbouring lanes: what stands beside the road is left out.

use crate::object::Object;
use crate::point::Point;
use crate::sighting::{Sums, correct};
use messages::Detection;

/// Most objects that are followed at a time.
pub const MAX_OBJECTS: usize = 48;

/// An object reaches so far behind its nearest face, m: longer ones come out as two.
const REACH_M: f64 = 6.0;
/// Points of one object differ from it by no more than this: speed, m/s, and lateral position, m.
const SAME: (f64, f64) = (2.5, 1.9);
/// An object that counts is dropped after this time without a point, s.
const COAST_S: f64 = 0.4;
/// The same of one that is beside the ego, outside of the field of view, s.
const BESIDE_S: f64 = 3.0;

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
        for index in 0..self.list.len() {
            let object = &self.list[index];
            let is_behind = self.list.iter().any(|nearer| object.is_hidden_by(nearer));
            self.list[index].is_behind = is_behind;
        }
        for object in &mut self.list {
            object.move_on(period_s, ego_mps);
            object.lateral.predict(period_s, object.speed_mps.abs());
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
        let object = Object::begin(point.x_m, point.y_m, point.speed_mps);
        let mut sums = Sums::NONE;
        sums.add(point, &object);
        self.list.push(object);
        self.sums.push(sums);
    }
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

    #[test]
    fn a_long_vehicle_beside_the_path_stays_beside_it_along_all_of_its_side() {
        // What is farther along it than an object reaches comes out as others. All are 3.5 m off; taken for a
        // face, a place of the side would be 2.6 m off.
        let mut objects = Objects::new(HALF_FIELD_RAD);
        let mut worst_m = 3.5_f64;
        for k in 0..100 {
            let x_m = 90.0 - 1.2 * f64::from(k);
            let mut list = vec![detection(x_m, 3.5, -24.0)];
            // The places that reflect are not all seen in each scan.
            let side = (0..6).filter(|place| (place + k) % 4 != 0);
            let ahead = |detection: &Detection| {
                detection.range_m > 0.5 && detection.azimuth_rad.abs() < 0.5
            };
            list.extend(
                side.map(|place| detection(x_m + 0.9 + 3.2 * f64::from(place), 2.6, -24.0)),
            );
            list.retain(ahead);
            objects.take_scan(i64::from(k) * PERIOD_NS, 29.0, &list);
            let seen = objects.confirmed().filter(|object| k > 20 && object.unseen_s == 0.0);
            worst_m = seen.fold(worst_m, |worst, object| worst.min(object.lateral.position_m));
        }
        assert!(worst_m > 2.9, "{worst_m}");
    }

    #[test]
    fn a_standing_queue_beside_the_lane_stays_there() {
        // Its points are on both sides of any limit that leaves out what stands beside the road.
        let mut objects = Objects::new(HALF_FIELD_RAD);
        for k in 0..40 {
            let x_m = 90.0 - f64::from(k);
            let noise_m = [0.5, -0.4, 0.3, -0.5, 0.1][k as usize % 5] * x_m / 90.0;
            let places = [(0.0, 2.6), (0.0, 3.5), (0.9, 2.6), (3.6, 2.6)];
            let list = places.map(|(dx, y_m)| detection(x_m + dx, y_m + noise_m, -20.0));
            objects.take_scan(i64::from(k) * PERIOD_NS, 20.0, &list);
        }
        let object = objects.confirmed().next().expect("it is followed");
        assert!((object.lateral.position_m - 3.5).abs() < 0.2, "{object:?}");
        assert!(object.lateral.rate_mps.abs() < 1e-6, "what stands does not move: {object:?}");
    }
}
