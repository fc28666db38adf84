//! Objects from detections, by fixed rules.
//!
//! A detection at range R, azimuth φ and range rate ρ is a point at x = R cos φ, y = R sin φ. It moves over ground with
//! the speed v = v_ego + (ρ - w sin φ) / cos φ, where w is its object's lateral speed. Points near an object in place
//! and speed are its own; the rest begin new objects. Each scan then corrects an object by its points
//! (`sighting`), and its lateral motion by [`crate::filter`].
//!
//! The face's echoes merge and fluctuate, so that their middle wanders by 0.3 m. The points of a side differ in range
//! and are as exact as the radar's azimuth. So a vehicle beside the path is located by the side that it shows.
//!
//! A nearer object may hide one corner of its face. What is seen is then the strip from the edge of the shadow to the
//! other corner, and its middle is farther to the hidden side. The part of a vehicle beyond [`REACH_M`] along its side
//! becomes further objects, which show their inner side.
//!
//! An object counts once it was seen in three of four scans. A standing one counts after four of five. It is a threat
//! only up to the neighbouring lanes.
//!
//! While the radar shows little an object has as many scans longer to be seen.
//!
//! On a road with curves x and y are counted along the corridor ahead and left of it ([`mod@crate::corridor`]). When
//! the corridor changes, the position of every object is computed anew from it. The object stays where it is in the
//! plane, so the estimate of the road makes no lateral speed.

use crate::collision_ahead::where_it_stands;
use crate::corridor::Corridor;
use crate::object::{MAX_OBJECTS, Object, WIDTH_M};
use crate::point::Point;
use crate::sighting::correct;
use crate::way::Way;
use messages::{Detection, MAX_DETECTIONS};

/// An object reaches so far behind its nearest face, m: longer ones come out as two.
const REACH_M: f64 = 6.0;
/// A point may be this much nearer than its object, m, and by this speed more while that is not seen, m/s.
const SLACK_M: f64 = 1.5;
const SLACK_MPS: f64 = 3.0;
/// Points of one object differ from its speed by no more than this, m/s.
const SAME_MPS: f64 = 2.5;
/// An object that counts is dropped after this time without a point, s.
const COAST_S: f64 = 0.4;
/// The same of an object beside the ego, outside of the field of view, s. It is also the most for one that is rarely
/// seen.
const BESIDE_S: f64 = 3.0;
/// Scans in which one must be seen once: to be kept until it counts, and to be braked for. Chosen: of ten scans a
/// radar that sees misses one.
const LATELY: u32 = 2;

#[derive(Clone, Debug)]
pub struct Objects {
    list: Vec<Object>,
    /// The points of a scan, each with the number of its object, and those of one object.
    points: Vec<(usize, Point)>,
    own: Vec<Point>,
    last_scan_ns: Option<i64>,
    /// A little less than the tangent of half of the field of view: its edge is not sure.
    view_tangent: f64,
    /// The corridor of the last scan.
    corridor: Corridor,
}

impl Objects {
    /// No objects yet, of a radar with this field of view to each side, rad.
    pub fn new(half_field_of_view_rad: f64) -> Self {
        Self {
            list: Vec::with_capacity(MAX_OBJECTS),
            points: Vec::with_capacity(MAX_DETECTIONS),
            own: Vec::with_capacity(MAX_DETECTIONS),
            last_scan_ns: None,
            view_tangent: half_field_of_view_rad,
            corridor: Corridor::default(),
        }
    }

    /// The objects that count, as of the last scan.
    pub fn confirmed(&self) -> impl Iterator<Item = &Object> {
        self.list.iter().filter(|object| object.is_confirmed)
    }

    /// Those, and each that is about to hit another one in the ego's path within `horizon_s`
    /// ([`mod@crate::collision_ahead`]) as it will stand there.
    pub fn threats(&self, horizon_s: f64) -> impl Iterator<Item = Object> {
        let hits = move |first| {
            self.confirmed().filter_map(move |second| where_it_stands(first, second, horizon_s))
        };
        self.confirmed().copied().chain(self.confirmed().flat_map(hits))
    }

    /// Takes the detections, nearest first, that were acquired at `scan_ns` by an ego of `ego_mps`. Places are counted
    /// along the `way` ahead and left of it. What is there is expected to be seen in a `share` of the scans, 0 to 1. A
    /// scan that is not later than the last one is passed over. Allocates nothing.
    pub fn take_scan(
        &mut self,
        way: &Way,
        share: f64,
        scan_ns: i64,
        ego_mps: f64,
        detections: &[Detection],
    ) {
        let Some(period_s) = self.advance(scan_ns, ego_mps) else { return };
        self.turn(way, period_s, ego_mps);
        self.points.clear();
        for detection in detections {
            if let Some(point) = Point::of(detection, ego_mps, &self.corridor)
                && let Some(index) = self.object_of(&point)
            {
                self.points.push((index, point));
            }
        }
        let view_tangent = self.view_tangent;
        for (index, object) in self.list.iter_mut().enumerate() {
            let own = self.points.iter().filter(|(of, _)| *of == index);
            self.own.clear();
            self.own.extend(own.map(|(_, point)| point));
            let shows_its_face = object.shows_its_face(view_tangent);
            correct(object, &self.own, period_s, shows_its_face, share);
            object.is_seen = object.times_seen(LATELY, share) > 0;
        }
        self.list.retain(|object| {
            let beside = object.distance_m < 0.0;
            let longest_s = if beside { BESIDE_S } else { (COAST_S / share).min(BESIDE_S) };
            match object.is_confirmed {
                true => object.unseen_s <= longest_s,
                false => object.is_seen,
            }
        });
    }

    /// Predicts all objects to the scan's time; returns the time since the last scan, s.
    fn advance(&mut self, scan_ns: i64, ego_mps: f64) -> Option<f64> {
        let elapsed_ns = self.last_scan_ns.map_or(50_000_000, |last_ns| scan_ns - last_ns);
        if elapsed_ns <= 0 {
            return None;
        }
        self.last_scan_ns = Some(scan_ns);
        let period_s = elapsed_ns as f64 / 1e9;
        for index in 0..self.list.len() {
            let mut object = Object { open_m: Object::OPEN_M, ..self.list[index] };
            self.list.iter().for_each(|nearer| object.take_shadow(nearer));
            self.list[index].open_m = object.open_m;
        }
        for object in &mut self.list {
            object.predict(period_s, ego_mps);
            object.unseen_s += period_s;
            object.history <<= 1;
        }
        Some(period_s)
    }

    /// Counts all places along the corridor as it is now. The ego has driven on for `period_s`, and has turned by its
    /// yaw rate meanwhile. A standing object stays in its place in the plane.
    fn turn(&mut self, way: &Way, period_s: f64, ego_mps: f64) {
        if !way.is_curved {
            return;
        }
        let before = std::mem::replace(&mut self.corridor, way.corridor);
        for object in &mut self.list {
            let off_m = object.lateral.position_m;
            let from_before_m = object.distance_m + ego_mps * period_s;
            let place = way.passed(before.to_body(from_before_m, off_m), ego_mps, period_s);
            let ((along_m, now_m), _) = self.corridor.to_way(place.0, place.1);
            object.distance_m = along_m;
            object.lateral.shift(now_m - off_m);
            object.see_along(&self.corridor);
        }
    }

    /// Number of the object of a point; a new one if none fits. `None` if there is no room.
    fn object_of(&mut self, point: &Point) -> Option<usize> {
        let cost = |object: &Object| {
            let dx = point.x_m - object.distance_m;
            let dv = (point.speed_mps - object.speed_mps).abs();
            let slack_m = SLACK_M + object.unseen_s * SLACK_MPS;
            if !(-slack_m..=REACH_M).contains(&dx) || dv > SAME_MPS {
                return None;
            }
            // It reflects on its body alone, whose middle may be at either side.
            let dy = (point.y_m - object.lateral.position_m).abs();
            (dy <= WIDTH_M).then_some(dv / SAME_MPS + dy / WIDTH_M + dx.abs() / REACH_M)
        };
        let costs = self.list.iter().enumerate();
        let fitting = costs.filter_map(|(index, object)| cost(object).map(|cost| (index, cost)));
        let best = fitting.min_by(|one, other| one.1.total_cmp(&other.1));
        if best.is_none() && self.list.len() < MAX_OBJECTS {
            let mut object = Object::begin(point.x_m, point.y_m, point.speed_mps);
            object.see_along(&self.corridor);
            self.list.push(object);
            return Some(self.list.len() - 1);
        }
        best.map(|(index, _)| index)
    }
}

#[cfg(test)]
mod tests;
