//! Objects from detections, by fixed rules.
//!
//! A detection at range R, azimuth φ and range rate ρ is a point at x = R cos φ, y = R sin φ. It moves over ground with
//! the speed v = v_ego + (ρ - w sin φ) / cos φ, where w is its object's lateral speed. Points near an object in place
//! and speed are its own; the rest begin new objects. Each scan then corrects an object by its points:
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
//! The face's echoes merge and fluctuate, so that their middle wanders by 0.3 m. The points of a side differ in range
//! and are as exact as the radar's azimuth. So a vehicle beside the path is located by the side that it shows.
//!
//! If a nearer object hides its face, only one side shows. An object beside the path shows its inner side, one in the
//! path the side with its free corner. Its middle is up to half a width farther to the other side than what is seen.
//! The part of a vehicle beyond [`REACH_M`] along its side becomes further objects, which show their inner side.
//!
//! An object counts once it was seen in three of four scans. A standing one counts after four of five. It counts only
//! up to the neighbouring lanes, so that posts beside the road are left out.
//!
//! While the radar shows little ([`Objects::expect`]) an object has as many scans longer to be seen.
//!
//! On a road with curves x and y are counted along the ego's own circle and left of it ([`mod@crate::circle`]). When
//! the circle changes, the position of every object is computed anew from it. The object stays where it is in the
//! plane, so the estimate of the curvature makes no lateral speed.

use crate::circle::{Circle, OwnWay};
use crate::collision_ahead::where_it_stands;
use crate::decision::Path;
use crate::object::Object;
use crate::point::Point;
use crate::row::Places;
use crate::sighting::{Sums, correct};
use messages::Detection;

/// Most objects that are followed at a time.
pub const MAX_OBJECTS: usize = 48;

/// An object reaches so far behind its nearest face, m: longer ones come out as two.
const REACH_M: f64 = 6.0;
/// A point may be this much nearer than its object, m, and by this speed more while that is not seen, m/s.
const SLACK_M: f64 = 1.5;
const SLACK_MPS: f64 = 3.0;
/// Points of one object differ from it by no more than this: speed, m/s, and lateral position, m.
const SAME: (f64, f64) = (2.5, 1.9);
/// Distance beside the path beyond which an object is not a threat on any row, m: both half widths, and 0.6 m.
const NEAR_PATH_M: f64 = 2.5;
/// An object that counts is dropped after this time without a point, s.
const COAST_S: f64 = 0.4;
/// The same of an object beside the ego, outside of the field of view, s. It is also the most for one that is rarely
/// seen.
const BESIDE_S: f64 = 3.0;
/// Scans in which one that does not count yet must be seen once.
const LATELY: u32 = 2;

/// All objects.
#[derive(Clone, Debug)]
pub struct Objects {
    list: Vec<Object>,
    sums: Vec<Sums>,
    last_scan_ns: Option<i64>,
    half_field_of_view_rad: f64,
    /// Share of the scans in which what is there is expected to be seen.
    share: f64,
    /// The circle of the last scan.
    circle: Circle,
    places: Places,
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
            share: 1.0,
            circle: Circle::default(),
            places: Places::default(),
        }
    }

    /// Expects what is there to be seen in this share of the scans from now on, 0 to 1.
    pub fn expect(&mut self, share: f64) {
        self.share = share;
    }

    /// The objects that count, as of the last scan.
    pub fn confirmed(&self) -> impl Iterator<Item = &Object> {
        self.list.iter().filter(|object| object.is_confirmed)
    }

    /// Those, and each that is about to hit another one in the ego's `path` ([`mod@crate::collision_ahead`]) as it
    /// will stand there.
    pub fn threats(&self, path: Path) -> impl Iterator<Item = Object> {
        let hits = move |first| {
            self.confirmed().filter_map(move |second| where_it_stands(first, second, path))
        };
        self.confirmed().copied().chain(self.confirmed().flat_map(hits))
    }

    /// Takes the detections, nearest first, that were acquired at `scan_ns` by an ego of `ego_mps`. Where the road may
    /// have curves, places are counted along the circle of the ego's own `way` and left of it. A scan that is not later
    /// than the last one is passed over. Allocates nothing.
    pub fn take_scan(
        &mut self,
        way: Option<&OwnWay>,
        scan_ns: i64,
        ego_mps: f64,
        detections: &[Detection],
    ) {
        let Some(period_s) = self.advance(scan_ns, ego_mps) else { return };
        if let Some(way) = way {
            self.turn(way, period_s, ego_mps);
        }
        let half_field_of_view_rad = self.half_field_of_view_rad;
        self.sums.clear();
        self.sums.resize(self.list.len(), Sums::NONE);
        let circle = self.circle;
        for point in detections.iter().filter_map(|one| Point::of(one, ego_mps, &circle)) {
            if !point.is_beside_the_road() {
                self.assign(&point, way.is_some());
            }
            if way.is_some() && point.stands() {
                self.places.take(point.x_m, point.y_m);
            }
        }
        for (object, sums) in self.list.iter_mut().zip(&self.sums) {
            let shows_its_face = object.shows_its_face(half_field_of_view_rad);
            correct(object, sums, period_s, shows_its_face, self.share);
        }
        if way.is_some() {
            self.see_rows();
        }
        let share = self.share;
        self.list.retain(|object| {
            let seen_lately = object.times_seen(LATELY, share) > 0;
            let beside = object.is_hidden_beside(half_field_of_view_rad);
            let longest_s = if beside { BESIDE_S } else { (COAST_S / share).min(BESIDE_S) };
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
            self.places.clear();
        }
        for index in 0..self.list.len() {
            let object = &self.list[index];
            let sides = self.list.iter().map(|nearer| object.side_hidden_by(nearer));
            self.list[index].hidden_side = sides.sum::<f64>().clamp(-1.0, 1.0);
        }
        for object in &mut self.list {
            object.move_on(period_s, ego_mps);
            object.lateral.predict(period_s, object.speed_mps.abs());
            object.unseen_s += period_s;
            object.history <<= 1;
        }
        Some(period_s)
    }

    /// Counts all places along the circle of the way as it is now. The ego has driven on for `period_s`, and has turned
    /// by its yaw rate meanwhile. A standing object stays in its place in the plane.
    fn turn(&mut self, way: &OwnWay, period_s: f64, ego_mps: f64) {
        let circle = way.circle();
        let before = std::mem::replace(&mut self.circle, circle);
        let way_m = ego_mps * period_s;
        let step = (way_m, way.yaw_rate_radps() * period_s);
        let seen = |place| before.seen_from(&circle, step, place);
        for object in &mut self.list {
            let off_m = object.lateral.position_m;
            let (along_m, now_m) = seen((object.distance_m, off_m));
            object.distance_m = along_m;
            object.lateral.shift(now_m - off_m);
            object.see_along(&circle);
        }
        self.places.move_on(seen, period_s, way_m);
    }

    /// Standing places, on whose rows an object may be.
    #[must_use]
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Marks objects that may be on a row of standing places.
    fn see_rows(&mut self) {
        for object in &mut self.list {
            let off_m = object.lateral.position_m;
            let may_be = object.stands() && off_m.abs() < NEAR_PATH_M;
            object.row_m = may_be.then_some((object.distance_m, off_m));
        }
    }

    fn assign(&mut self, point: &Point, is_curved: bool) {
        let mut best: Option<(f64, usize)> = None;
        for (index, object) in self.list.iter().enumerate() {
            let dx = point.x_m - object.distance_m;
            if dx > REACH_M || dx < -(SLACK_M + object.unseen_s * SLACK_MPS) {
                continue;
            }
            let dv = (point.speed_mps - object.speed_mps).abs();
            let dy = (point.y_m - object.lateral.position_m).abs();
            if dv > SAME.0 || dy > SAME.1 {
                continue;
            }
            let cost = dv / SAME.0 + dy / SAME.1 + dx.abs() / REACH_M;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, index));
            }
        }
        match best {
            Some((_, index)) => self.sums[index].add(point, &self.list[index]),
            None if self.list.len() < MAX_OBJECTS => self.begin(point, is_curved),
            None => {}
        }
    }

    fn begin(&mut self, point: &Point, is_curved: bool) {
        let mut object = Object::begin(point.x_m, point.y_m, point.speed_mps);
        if is_curved {
            object.see_along(&self.circle);
        }
        let mut sums = Sums::NONE;
        sums.add(point, &object);
        self.list.push(object);
        self.sums.push(sums);
    }
}

#[cfg(test)]
mod tests;
