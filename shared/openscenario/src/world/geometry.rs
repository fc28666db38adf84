//! Motion of entities, and bodies on the road: extents, distances, overlap.

use serde::{Deserialize, Serialize};

use crate::model::Body;
use crate::model::condition::Along;

/// Position, heading and speed of an entity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// True if it is on the road. If not, the other fields have no meaning.
    pub present: bool,
    /// The row of roads on which it is, by its place in the script.
    #[serde(default)]
    pub row: usize,
    /// Origin along the reference line, m.
    pub s_m: f64,
    /// Origin across it, positive to the left, m.
    pub t_m: f64,
    /// Heading from the reference line, rad.
    pub heading_rad: f64,
    /// Speed along the heading, m/s.
    pub speed_mps: f64,
    /// Speed across the road from a lateral action, m/s.
    pub lateral_mps: f64,
    /// Acceleration along the heading, m/s².
    pub acceleration_mps2: f64,
}

impl Motion {
    /// 1 for an entity that faces along the road, -1 for one that faces against it.
    pub fn direction(&self) -> f64 {
        if libm::cos(self.heading_rad) < 0.0 { -1.0 } else { 1.0 }
    }
}

/// The rectangle along the road's axes around a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Its rear end: the smallest `s`, m.
    pub from_s_m: f64,
    /// Its front end: the largest `s`, m.
    pub to_s_m: f64,
    /// Its right side: the smallest `t`, m.
    pub from_t_m: f64,
    /// Its left side: the largest `t`, m.
    pub to_t_m: f64,
}

impl Extent {
    pub fn of(body: &Body, motion: &Motion) -> Self {
        let s = Interval::of(body, motion, 0.0);
        let t = Interval::of(body, motion, std::f64::consts::FRAC_PI_2);
        Self { from_s_m: s.from, to_s_m: s.to, from_t_m: t.from, to_t_m: t.to }
    }

    /// The end that a body shows which faces along the road (`direction` above 0) or against it, m.
    pub fn front_s_m(&self, direction: f64) -> f64 {
        if direction > 0.0 { self.to_s_m } else { self.from_s_m }
    }
}

/// A body seen along one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    from: f64,
    to: f64,
}

impl Interval {
    /// Along the direction `angle` from the road's.
    pub(super) fn of(body: &Body, motion: &Motion, angle: f64) -> Self {
        let (sin, cos) =
            (libm::sin(motion.heading_rad - angle), libm::cos(motion.heading_rad - angle));
        let origin = motion.s_m * libm::cos(angle) + motion.t_m * libm::sin(angle);
        let center = origin + body.center_ahead_m * cos - body.center_left_m * sin;
        let half = 0.5 * (body.length_m * cos.abs() + body.width_m * sin.abs());
        Self { from: center - half, to: center + half }
    }

    /// The free space to another interval, 0 where they overlap.
    pub(super) fn gap(&self, other: &Self) -> f64 {
        (other.from - self.to).max(self.from - other.to).max(0.0)
    }
}

/// True if two rectangles overlap: no side of either separates them.
pub(super) fn overlap(a: (&Body, Motion), b: (&Body, Motion)) -> bool {
    let angles = [a.1.heading_rad, b.1.heading_rad];
    angles.into_iter().flat_map(|angle| [angle, angle + std::f64::consts::FRAC_PI_2]).all(|angle| {
        let (a, b) = (Interval::of(a.0, &a.1, angle), Interval::of(b.0, &b.1, angle));
        a.from < b.to && b.from < a.to
    })
}

/// A body without an extent.
pub(super) const POINT: Body =
    Body { center_ahead_m: 0.0, center_left_m: 0.0, length_m: 0.0, width_m: 0.0 };

/// The distance from a body, or from its origin, to another body or a point, m.
pub(super) fn distance(
    (body, motion): (&Body, &Motion),
    (other_body, other): (Option<&Body>, &Motion),
    along: Along,
    entity_axes: bool,
    freespace: bool,
) -> f64 {
    let base = if entity_axes { motion.heading_rad } else { 0.0 };
    let (own, far) =
        if freespace { (body, other_body.unwrap_or(&POINT)) } else { (&POINT, &POINT) };
    let measure =
        |angle: f64| Interval::of(own, motion, angle).gap(&Interval::of(far, other, angle));
    let aside = base + std::f64::consts::FRAC_PI_2;
    match along {
        Along::Longitudinal => measure(base),
        Along::Lateral => measure(aside),
        Along::Euclidean => libm::hypot(measure(base), measure(aside)),
    }
}
