//! Parametric cubics by arc length.
//!
//! The parameter of a place is found by Newton's method on the Gauss-Legendre integral of the speed
//! `√(u'² + v'²)`. A parameter that is proportional to the length is off by millimetres on real roads.

use crate::Pose;
use crate::smooth::{Smooth, State, integrate};

/// Largest difference of true and declared length that stays at the end of a cubic, m. A larger one is spread
/// over the cubic, so that no gap arises.
const MAX_REST_M: f64 = 1e-3;
/// Parts of a whole cubic for its length.
const PARTS: u32 = 64;
/// Most steps of Newton's method; three or four are usual.
const MAX_STEPS: u32 = 20;

/// `u(t)`, `v(t)`.
#[derive(Clone, Copy, Debug)]
pub struct Parametric {
    length_m: f64,
    u: [f64; 4],
    v: [f64; 4],
    pace: f64,
}

impl Parametric {
    pub fn new(length_m: f64, u: [f64; 4], v: [f64; 4], end: f64) -> Self {
        let true_m = length_between(&u, &v, 0.0, end);
        let pace = if (true_m - length_m).abs() > MAX_REST_M { true_m / length_m } else { 1.0 };
        Self { length_m, u, v, pace }
    }

    /// `poly3`: the parameter is `u` itself.
    pub fn of_cubic(length_m: f64, v: [f64; 4]) -> Self {
        Self { length_m, u: [0.0, 1.0, 0.0, 0.0], v, pace: 1.0 }
    }

    /// The parameter at a length from the start.
    pub fn end_of(&self, length_m: f64) -> f64 {
        let part_m = length_m / f64::from(PARTS);
        (0..PARTS).fold(0.0, |parameter, _| self.parameter_after(parameter, part_m))
    }

    fn parameter_after(&self, from: f64, way_m: f64) -> f64 {
        let mut parameter = from + way_m / speed(&self.u, &self.v, from);
        for _ in 0..MAX_STEPS {
            let error_m = arc(&self.u, &self.v, from, parameter) - way_m;
            let step = error_m / speed(&self.u, &self.v, parameter);
            parameter -= step;
            if step.abs() <= 1e-13 * parameter.abs().max(1e-3) {
                break;
            }
        }
        parameter
    }

    /// The state at a parameter; its heading from the direction at another parameter.
    fn state(&self, q_m: f64, parameter: f64, from: (f64, f64)) -> State {
        let (u, v) = (&self.u, &self.v);
        let (du, dv) = (slope(u, parameter), slope(v, parameter));
        let (ddu, ddv) = (bend(u, parameter), bend(v, parameter));
        let speed = libm::hypot(du, dv);
        let cube = speed * speed * speed;
        let curvature_perm = (du * ddv - dv * ddu) / cube;
        let change = 6.0 * (du * v[3] - dv * u[3]) / cube
            - 3.0 * curvature_perm * (du * ddu + dv * ddv) / (speed * speed);
        let first = libm::hypot(u[1], v[1]);
        let (cos, sin) = (u[1] / first, v[1] / first);
        let (x, y) = (value(u, parameter) - u[0], value(v, parameter) - v[0]);
        let (cross, dot) = (from.0 * dv - from.1 * du, from.0 * du + from.1 * dv);
        let pose = Pose {
            x_m: x * cos + y * sin,
            y_m: y * cos - x * sin,
            heading_rad: libm::atan2(cross, dot),
        };
        State { q_m, pose, curvature_perm, rate_perm2: change / speed, parameter }
    }
}

impl Smooth for Parametric {
    fn length_m(&self) -> f64 {
        self.length_m
    }

    fn begin(&self) -> State {
        self.state(0.0, 0.0, (self.u[1], self.v[1]))
    }

    fn advance(&self, from: &State, q_m: f64) -> State {
        let way_m = self.pace * (q_m - from.q_m);
        let direction = (slope(&self.u, from.parameter), slope(&self.v, from.parameter));
        let parameter = self.parameter_after(from.parameter, way_m);
        let mut state = self.state(q_m, parameter, direction);
        state.pose.heading_rad += from.pose.heading_rad;
        state
    }

    fn pace(&self) -> f64 {
        self.pace
    }
}

/// The length between two parameters, m.
pub fn length_between(u: &[f64; 4], v: &[f64; 4], from: f64, to: f64) -> f64 {
    let part = (to - from) / f64::from(PARTS);
    (0..PARTS).map(|i| from + part * f64::from(i)).map(|at| arc(u, v, at, at + part)).sum()
}

fn arc(u: &[f64; 4], v: &[f64; 4], from: f64, to: f64) -> f64 {
    integrate(from, to, |t| (speed(u, v, t), 0.0)).0
}

fn speed(u: &[f64; 4], v: &[f64; 4], t: f64) -> f64 {
    libm::hypot(slope(u, t), slope(v, t))
}

fn value([a, b, c, d]: &[f64; 4], t: f64) -> f64 {
    a + t * (b + t * (c + t * d))
}

fn slope([_, b, c, d]: &[f64; 4], t: f64) -> f64 {
    b + t * (2.0 * c + 3.0 * t * d)
}

fn bend([_, _, c, d]: &[f64; 4], t: f64) -> f64 {
    2.0 * c + 6.0 * t * d
}
