//! An object: what is known of one vehicle.

use crate::corridor::Corridor;
use crate::filter::Lateral;

/// Most objects that are kept.
pub(crate) const MAX_OBJECTS: usize = 64;
/// Below this speed over ground an object stands, m/s.
pub(crate) const STANDING_MPS: f64 = 1.0;
/// Half of the width that is assumed of every vehicle, m.
pub(crate) const HALF_WIDTH_M: f64 = 0.95;
/// Length of an object of which only the face was seen, m.
const LEAST_LENGTH_M: f64 = 4.3;
/// Distance from the farthest point that reflects to the end of the body, m.
pub(crate) const OVERHANG_M: f64 = 0.9;
/// A side shows when it is this far from the ego's axis, m.
const SIDE_SHOWS_M: f64 = 0.15;
/// Distance over which a reflecting place is at the edge of the field of view, m.
const BLIND_MARGIN_M: f64 = 0.5;
/// Standard deviation of the middle of a vehicle of which one point is known, m.
pub(crate) const FIRST_SIGMA_M: f64 = 0.7;
/// Distance of what reflects on a side from the middle, m.
pub(crate) const SIDE_M: f64 = 0.9;
/// Standing objects farther off the way are beside the road, m: beyond the neighbouring lanes.
pub(crate) const ROAD_M: f64 = 5.0;

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
    /// The shadow of a nearer object on its face.
    pub(crate) shadow: Option<Shadow>,
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

/// The part of a face that a nearer object hides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shadow {
    /// The hidden side: 1 left, -1 right.
    pub(crate) side: f64,
    /// Its edge, m left of the way.
    pub(crate) edge_m: f64,
}

impl Shadow {
    /// The larger one of two; `None` if they are on both sides.
    pub(crate) fn and(self, other: Self) -> Option<Self> {
        let is_larger = self.side * (self.edge_m - other.edge_m) < 0.0;
        (self.side == other.side).then_some(if is_larger { self } else { other })
    }
}

impl Object {
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
            shadow: None,
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

    /// True if it stands beyond the neighbouring lanes.
    pub(crate) fn is_beside_the_road(&self) -> bool {
        self.stands() && self.lateral.position_m.abs() > ROAD_M
    }

    /// It moved on by `time_s` beside an ego of `ego_mps`, along the way and across it.
    pub fn moved_on(mut self, time_s: f64, ego_mps: f64) -> Self {
        self.move_along(time_s, ego_mps);
        self.lateral.move_on(time_s);
        self
    }

    pub(crate) fn move_along(&mut self, time_s: f64, ego_mps: f64) {
        let speed = (self.speed_mps + self.acceleration_mps2 * time_s).max(0.0);
        // An object that comes towards the ego keeps its speed.
        let speed = if self.speed_mps < 0.0 { self.speed_mps } else { speed };
        self.distance_m += (0.5 * (self.speed_mps + speed) - ego_mps) * time_s;
        self.speed_mps = speed;
    }

    /// Is carried on without a point: what has come to the ego's axis stays there.
    pub(crate) fn coast(&mut self) {
        self.acceleration_mps2 = 0.0;
        if self.lateral.position_m * self.lateral.rate_mps > 0.0
            && self.lateral.position_m.abs() < SIDE_M
        {
            self.lateral.rest();
        }
    }

    /// True if the nearer corner of its face is within half of the field of view, of this tangent.
    pub(crate) fn shows_its_face(&self, view_tangent: f64) -> bool {
        self.is_in_view(self.distance_m, view_tangent)
    }

    /// True if all of it that reflects is outside of the field of view, beside the ego.
    pub(crate) fn is_hidden_beside(&self, view_tangent: f64) -> bool {
        !self.is_in_view(self.distance_m + self.length_m - OVERHANG_M, view_tangent)
    }

    /// True if what reflects on its inner side at `x_m` ahead is surely in the field of view.
    fn is_in_view(&self, x_m: f64, view_tangent: f64) -> bool {
        let (surely_m, off_m) = (x_m - BLIND_MARGIN_M, (self.sight_m().abs() - SIDE_M).max(0.0));
        surely_m > 0.0 && off_m < surely_m * view_tangent
    }

    /// The shadow of `nearer` on its face; `None` if it hides neither corner. If both are hidden, what is seen is the side
    /// that it shows.
    pub(crate) fn shadow_of(&self, nearer: &Self) -> Option<Shadow> {
        if nearer.distance_m + BLIND_MARGIN_M >= self.distance_m {
            return None;
        }
        let is_hidden = |side: f64| nearer.hides(self.distance_m, self.sight_m() + side * SIDE_M);
        let side = match (is_hidden(1.0), is_hidden(-1.0)) {
            (false, false) => return None,
            (true, true) => self.shown_side()?.0,
            (left, _) => f64::from(left) * 2.0 - 1.0,
        };
        // The lines of sight past the nearer one's two corners on the open side: one of them bounds the shadow.
        let corner_m = nearer.sight_m() - side * HALF_WIDTH_M;
        let past_m = |along_m: f64| corner_m * self.distance_m / along_m.max(BLIND_MARGIN_M);
        let bounds = [past_m(nearer.distance_m), past_m(nearer.distance_m + nearer.length_m)];
        let edge_m =
            bounds.into_iter().reduce(|a, b| if side > 0.0 { a.min(b) } else { a.max(b) })?;
        Some(Shadow { side, edge_m: edge_m - self.bow_m })
    }

    /// True if the straight line to a place passes through it.
    fn hides(&self, x_m: f64, y_m: f64) -> bool {
        let (begin_m, end_m) = (self.distance_m.max(0.0), self.distance_m + self.length_m);
        if x_m <= 0.0 || end_m <= 0.0 {
            return false;
        }
        let off_m = |along_m: f64| y_m / x_m * along_m - self.sight_m();
        let (begins_m, ends_m) = (off_m(begin_m), off_m(end_m.min(x_m)));
        begins_m.max(ends_m) > -HALF_WIDTH_M && begins_m.min(ends_m) < HALF_WIDTH_M
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
