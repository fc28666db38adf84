//! The axis of a lane: a curve at a distance from another axis.
//!
//! ```text
//! C(s) = R(s) + t(s) N(s)         A = w (1 - κ t),  B = t'     |C'| = √(A² + B²)
//! θ_C  = θ + atan2(B, A)          κ_C = (w κ + (A B' - B A') / (A² + B²)) / |C'|
//! ```
//!
//! w is the way along R for one metre of s. It is constant in a piece: 1, except for cubics of another length than
//! declared. `s` at an arc length `p` of C comes from Newton's method on the integral of |C'|.

use crate::axis::{goes_on, joined};
use crate::build::Builder;
use crate::piece::Piece;
use crate::smooth::{Smooth, State, integrate};
use crate::{Axis, AxisError, AxisFault, MAX_SHIFT_RAD, Pose, Profile};

/// Most steps of Newton's method.
const MAX_STEPS: u32 = 20;
/// Distance for the change of the curvature, m.
const APART_M: f64 = 0.05;
/// Shortest stretch between two joints, m: a shorter one goes to its neighbour.
const SHORTEST_M: f64 = 1e-6;

/// A part of a road with an axis of its own. Places count along the road, and across it.
#[derive(Clone, Debug)]
pub struct Leg {
    pub axis: Axis,
    /// Start of the axis in the plane of the road.
    pub start: Pose,
    /// Place of that start along the road, m.
    pub from_m: f64,
    /// Place of the axis across the road, m.
    pub shift_m: f64,
}

/// The curve between two joints, from `from_m` to `to_m` of the road; backwards if `to_m` is smaller.
struct Beside<'a> {
    leg: &'a Leg,
    offset: &'a Profile,
    from_m: f64,
    to_m: f64,
    length_m: f64,
    start: Pose,
}

struct Point {
    pose: Pose,
    speed: f64,
    curvature_perm: f64,
}

impl<'a> Beside<'a> {
    fn new(leg: &'a Leg, offset: &'a Profile, from_m: f64, to_m: f64) -> Self {
        let mut beside = Self { leg, offset, from_m, to_m, length_m: 0.0, start: Pose::default() };
        let parts = libm::ceil((to_m - from_m).abs() / crate::cell::CELL_M).max(1.0);
        let step_m = (to_m - from_m) / parts;
        let length = |i: u64| {
            let begin_m = from_m + step_m * i as f64;
            beside.length(begin_m, begin_m + step_m)
        };
        beside.length_m = (0..parts as u64).map(length).sum();
        beside.start = beside.point(from_m).pose;
        beside
    }

    fn sign(&self) -> f64 {
        if self.to_m < self.from_m { -1.0 } else { 1.0 }
    }

    /// A place of the reference inside this stretch: at a joint the curvature of this side counts.
    fn inside(&self, s_m: f64) -> f64 {
        let margin_m = 1e-9_f64.min(0.1 * (self.to_m - self.from_m).abs());
        s_m.clamp(self.from_m.min(self.to_m) + margin_m, self.from_m.max(self.to_m) - margin_m)
    }

    fn speed(&self, s_m: f64) -> f64 {
        let (at_m, Leg { axis, from_m, shift_m, .. }) = (self.inside(s_m), self.leg);
        let (p_m, t_m) = (at_m - from_m, self.offset.at(at_m) - shift_m);
        let a = axis.pace(p_m) * (1.0 - axis.curvature_perm(p_m) * t_m);
        libm::hypot(a, self.offset.slope(at_m))
    }

    /// The way along the curve, m; positive in its own direction.
    fn length(&self, from_m: f64, to_m: f64) -> f64 {
        self.sign() * integrate(from_m, to_m, |s_m| (self.speed(s_m), 0.0)).0
    }

    fn point(&self, s_m: f64) -> Point {
        let (at_m, Leg { axis, start, from_m, shift_m }) = (self.inside(s_m), self.leg);
        let p_m = at_m - from_m;
        let [t, slope, bend] =
            [self.offset.at(at_m) - shift_m, self.offset.slope(at_m), self.offset.bend(at_m)];
        let (curvature, rate) = (axis.curvature_perm(p_m), axis.curvature_rate_perm2(p_m));
        let pace = axis.pace(p_m);
        let a = pace * (1.0 - curvature * t);
        let a_change = -pace * (pace * rate * t + curvature * slope);
        let speed = libm::hypot(a, slope);
        let turned = (a * bend - slope * a_change) / (speed * speed);
        let place = axis.pose(p_m).placed(start);
        let (sin, cos) = libm::sincos(place.heading_rad);
        let turn = if self.sign() < 0.0 { std::f64::consts::PI } else { 0.0 };
        let pose = Pose {
            x_m: place.x_m - t * sin,
            y_m: place.y_m + t * cos,
            heading_rad: place.heading_rad + libm::atan2(slope, a) + turn,
        };
        // Beyond the centre of a curve the lane would run backwards.
        let forward = if a > 0.0 { self.sign() } else { f64::NAN };
        Point { pose, speed, curvature_perm: forward * (pace * curvature + turned) / speed }
    }

    fn state(&self, q_m: f64, s_m: f64) -> State {
        let here = self.point(s_m);
        let apart_m = APART_M.min(0.2 * (self.to_m - self.from_m).abs());
        let middle_m = self
            .inside(s_m)
            .clamp(self.from_m.min(self.to_m) + apart_m, self.from_m.max(self.to_m) - apart_m);
        let [before, behind] = [-apart_m, apart_m]
            .map(|apart_m| self.point(middle_m + self.sign() * apart_m).curvature_perm);
        State {
            q_m,
            pose: here.pose.seen_from(&self.start),
            curvature_perm: here.curvature_perm,
            rate_perm2: (behind - before) / (2.0 * apart_m * here.speed),
            parameter: s_m,
        }
    }
}

impl Smooth for Beside<'_> {
    fn length_m(&self) -> f64 {
        self.length_m
    }

    fn begin(&self) -> State {
        self.state(0.0, self.from_m)
    }

    fn tolerance(&self) -> (f64, f64) {
        (2e-6, 1e-6)
    }

    fn advance(&self, from: &State, q_m: f64) -> State {
        let way_m = q_m - from.q_m;
        let mut s_m = from.parameter + self.sign() * way_m / self.speed(from.parameter);
        for _ in 0..MAX_STEPS {
            let step_m = (self.length(from.parameter, s_m) - way_m) / self.speed(s_m);
            s_m -= self.sign() * step_m;
            if step_m.abs() < 1e-12 {
                break;
            }
        }
        self.state(q_m, s_m)
    }
}

impl Leg {
    /// The axis that lies `offset` to the left of a road of these legs, from one place to another. It begins at (0, 0, 0),
    /// and runs against the road if the second place is smaller. The pose is its start in the plane of the road.
    ///
    /// ```
    /// use road::{Axis, Leg, MIN_RADIUS_M, Piece, Pose, Profile};
    /// let axis = Axis::new(&[Piece::Arc { length_m: 300.0, curvature_perm: 0.01 }])?;
    /// let legs = [Leg { axis, start: Pose::default(), from_m: 0.0, shift_m: 0.0 }];
    /// let offset = Profile::constant(-1.75);
    /// let (lane, start) = Leg::beside(&legs, &offset, (0.0, 300.0), MIN_RADIUS_M)?;
    /// // The outer lane of a left curve is longer.
    /// assert!((lane.length_m() - 300.0 * 1.0175).abs() < 1e-6 && (start.y_m + 1.75).abs() < 1e-8);
    /// # Ok::<(), road::AxisError>(())
    /// ```
    ///
    /// # Errors
    /// When the curve at that distance has a smaller radius, a gap or a kink. Its pieces are counted between the joints of
    /// both.
    pub fn beside(
        legs: &[Self],
        offset: &Profile,
        (from_m, to_m): (f64, f64),
        min_radius_m: f64,
    ) -> Result<(Axis, Pose), AxisError> {
        let (low_m, high_m) = (from_m.min(to_m), from_m.max(to_m));
        let end_m = legs.last().map(|leg| leg.from_m + leg.axis.length_m());
        let starts = legs.iter().flat_map(|leg| leg.axis.starts.iter().map(|p_m| leg.from_m + p_m));
        let joints = starts.chain(end_m);
        let changes = offset.stretches().iter().map(|stretch| stretch.from_m);
        let mut joints: Vec<f64> = joints
            .chain(changes)
            .filter(|at_m| *at_m > low_m + SHORTEST_M && *at_m < high_m - SHORTEST_M)
            .chain([low_m, high_m])
            .collect();
        joints.sort_by(f64::total_cmp);
        joints.dedup_by(|a, b| *a - *b < SHORTEST_M);
        if to_m < from_m {
            joints.reverse();
        }
        let mut builder = Builder { min_radius_m, ..Builder::new() };
        let (mut end, mut straight_m) = (Pose::default(), 0.0);
        let (mut origin, mut starts) = (None, Vec::new());
        for (number, ends) in joints.windows(2).enumerate() {
            let middle_m = 0.5 * (ends[0] + ends[1]);
            let begun = legs.partition_point(|leg| leg.from_m <= middle_m).max(1);
            let leg = legs.get(begun - 1).ok_or(AxisFault::Empty.of(number))?;
            let beside = Beside::new(leg, offset, ends[0], ends[1]);
            let origin = origin.get_or_insert(beside.start);
            let start = beside.start.seen_from(origin);
            let start = joined(&start, &end, number, MAX_SHIFT_RAD)?;
            starts.push(builder.length_m);
            let is_line = ends.iter().chain([&middle_m]).all(|at_m| {
                let at_m = beside.inside(*at_m);
                leg.axis.curvature_perm(at_m - leg.from_m) == 0.0
                    && offset.slope(at_m) == 0.0
                    && offset.bend(at_m) == 0.0
            });
            if is_line {
                let length_m = (ends[1] - ends[0]).abs();
                if straight_m == builder.length_m && goes_on(&start, straight_m) {
                    straight_m += length_m;
                }
                end = builder.add(&*Piece::Line { length_m }.smooth(), number, start)?;
            } else {
                end = builder.add(&beside, number, start)?;
            }
        }
        let origin = origin.ok_or(AxisFault::Empty.of(0))?;
        Ok((Axis::of(builder, starts, end, straight_m)?, origin))
    }
}
