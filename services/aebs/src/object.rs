//! An object: what is known of one vehicle.

use crate::corridor::Corridor;
use crate::filter::Lateral;

/// Most objects that are kept.
pub(crate) const MAX_OBJECTS: usize = 64;
/// Below this speed over ground an object stands, m/s.
pub(crate) const STANDING_MPS: f64 = 1.0;
/// Width that is assumed of every vehicle and of the ego, m.
pub(crate) const WIDTH_M: f64 = 1.9;
/// Length of an object of which only the face was seen, m.
const LEAST_LENGTH_M: f64 = 4.3;
/// Distance from the farthest point that reflects to the end of the body, m.
pub(crate) const OVERHANG_M: f64 = 0.9;
/// A side shows when it is this far from the ego's axis, m.
const SIDE_SHOWS_M: f64 = 0.15;
/// The place of a face is not surer than this, m. So a face that is nearer by less hides nothing.
const NEARER_M: f64 = 0.5;
/// Standard deviation of the middle of a vehicle of which one point is known, m.
pub(crate) const FIRST_SIGMA_M: f64 = 0.7;
/// Distance of what reflects on a side from the middle, m.
pub(crate) const SIDE_M: f64 = 0.9;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Distance of its nearest face, m ahead of the ego's front.
    pub distance_m: f64,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Lateral position of its middle, m left of the ego's axis, and its rate.
    pub lateral: Lateral,
    /// Its length as far as it was seen, m.
    pub length_m: f64,
    pub is_confirmed: bool,
    /// Probability that it is there.
    pub probability: f64,
    /// It was seen lately.
    pub is_seen: bool,
    /// Bounds of what nearer objects leave open of its face, m left of the way: the right one and the left one.
    pub(crate) open_m: (f64, f64),
    /// Bits of the last scans in which it was seen, the newest in the lowest bit.
    pub(crate) history: u32,
    /// Time since it was last seen, s.
    pub(crate) unseen_s: f64,
    /// Distance of the corridor from the axis of the ego's body there, m to the left, and its heading, rad.
    pub(crate) bow_m: f64,
    pub(crate) road_rad: f64,
    /// Standard deviation of the road across the corridor there, m.
    pub(crate) way_sigma_m: f64,
}

impl Object {
    /// Nothing hides a face.
    pub(crate) const OPEN_M: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    /// An object that counts, with a known motion.
    #[cfg(test)]
    pub(crate) fn at(distance_m: f64, speed_mps: f64, offset_m: f64, lateral_mps: f64) -> Self {
        Self {
            lateral: Lateral::known(offset_m, lateral_mps),
            is_confirmed: true,
            history: u32::MAX,
            ..Self::begin(distance_m, offset_m, speed_mps)
        }
    }

    /// An object that begins with a point, at its place and with its speed.
    pub(crate) fn begin(x_m: f64, y_m: f64, speed_mps: f64) -> Self {
        Self {
            distance_m: x_m,
            speed_mps,
            acceleration_mps2: 0.0,
            lateral: Lateral::first(y_m, FIRST_SIGMA_M),
            length_m: LEAST_LENGTH_M,
            is_confirmed: false,
            probability: 1.0,
            is_seen: true,
            open_m: Self::OPEN_M,
            history: 0,
            unseen_s: 0.0,
            bow_m: 0.0,
            road_rad: 0.0,
            way_sigma_m: 0.0,
        }
    }

    /// Takes the corridor that it is counted from.
    pub(crate) fn see_along(&mut self, corridor: &Corridor) {
        self.bow_m = corridor.to_body(self.distance_m, 0.0).1;
        self.road_rad = corridor.heading_rad(self.distance_m);
        self.way_sigma_m = corridor.sigma_m(self.distance_m);
    }

    /// Number of the last `scans` in which it was seen. If only a `share` of them shows what is there, as many more
    /// scans count.
    pub(crate) fn times_seen(&self, scans: u32, share: f64) -> u32 {
        let looked = (f64::from(scans) / share).round().min(f64::from(u32::BITS)) as u32;
        (self.history << (u32::BITS - looked)).count_ones()
    }

    pub fn stands(&self) -> bool {
        self.speed_mps.abs() < STANDING_MPS
    }

    /// Moves on by `time_s` beside an ego of `ego_mps`, along the way and across it.
    pub(crate) fn predict(&mut self, time_s: f64, ego_mps: f64) {
        let speed = (self.speed_mps + self.acceleration_mps2 * time_s).max(0.0);
        // An object that comes towards the ego keeps its speed.
        let speed = if self.speed_mps < 0.0 { self.speed_mps } else { speed };
        self.distance_m += (0.5 * (self.speed_mps + speed) - ego_mps) * time_s;
        self.speed_mps = speed;
        self.lateral.predict(time_s, speed.abs());
    }

    /// True if what reflects on the inner side of its face is surely within half of the field of view, of this tangent.
    pub(crate) fn shows_its_face(&self, view_tangent: f64) -> bool {
        let surely_m = self.distance_m - NEARER_M;
        let off_m = (self.sight_m().abs() - SIDE_M).max(0.0);
        surely_m > 0.0 && off_m < surely_m * view_tangent
    }

    /// Takes the shadow of `nearer` on a corner of its face. If both corners are hidden, what is seen is the side that it
    /// shows.
    pub(crate) fn take_shadow(&mut self, nearer: &Self) {
        let Some((right_m, left_m)) = nearer.covers(self.distance_m) else { return };
        let is_hidden = |corner_m: f64| right_m < corner_m && corner_m < left_m;
        let side = match [1.0, -1.0].map(|side| is_hidden(self.sight_m() + side * SIDE_M)) {
            [false, false] => return,
            [true, true] => self.shown_side().map_or(0.0, |(side, _)| side),
            [left, _] => f64::from(left) * 2.0 - 1.0,
        };
        if side > 0.0 {
            self.open_m.1 = self.open_m.1.min(right_m - self.bow_m);
        } else if side < 0.0 {
            self.open_m.0 = self.open_m.0.max(left_m - self.bow_m);
        }
    }

    /// Right and left bound of what it hides at a distance, m left of the axis of the ego's body. Lines of sight past its
    /// four corners bound it. `None` if it is not nearer, or passed.
    fn covers(&self, x_m: f64) -> Option<(f64, f64)> {
        let end_m = (self.distance_m + self.length_m).min(x_m);
        if self.distance_m + NEARER_M >= x_m || end_m <= 0.0 {
            return None;
        }
        let share = [self.distance_m, end_m].map(|along_m| x_m / along_m.max(NEARER_M));
        let seen_m = |corner_m: f64| share.map(|share| share * corner_m);
        let right_m = seen_m(self.sight_m() - 0.5 * WIDTH_M);
        let left_m = seen_m(self.sight_m() + 0.5 * WIDTH_M);
        Some((right_m[0].min(right_m[1]), left_m[0].max(left_m[1])))
    }

    /// Offset from the axis of the ego's body, m to the left. Lines of sight are straight beside it.
    fn sight_m(&self) -> f64 {
        self.lateral.position_m + self.bow_m
    }

    /// Side of the line of sight on which it is (1 left, -1 right). The second value is the place of the side that it
    /// shows, m left of the way. `None` if it shows none.
    ///
    /// A vehicle on the left of the line shows its right side. A lead in the middle of a left curve is on the right of
    /// it.
    pub(crate) fn shown_side(&self) -> Option<(f64, f64)> {
        let aspect_m = self.sight_m() - self.road_rad * self.distance_m;
        let side = aspect_m.signum();
        let shows = aspect_m.abs() - SIDE_M > SIDE_SHOWS_M;
        shows.then_some((side, self.lateral.position_m - side * SIDE_M))
    }
}

#[cfg(test)]
mod tests;
