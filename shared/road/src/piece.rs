//! Pieces of an axis, and how to go along them.

use serde::{Deserialize, Serialize};

use crate::cubic::Parametric;
use crate::smooth::{Smooth, State, integrate};
use crate::{AxisError, AxisFault, MAX_LENGTH_M, Pose};

/// Largest difference between declared and true length of a cubic, as a share.
const MAX_DECLARED: f64 = 0.1;

/// A piece of an axis. It begins where the one before ends, in its direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Piece {
    Line {
        length_m: f64,
    },
    Arc {
        length_m: f64,
        /// Curvature, 1/m, positive to the left.
        curvature_perm: f64,
    },
    /// A clothoid: the curvature changes evenly.
    Spiral {
        length_m: f64,
        /// Curvature at its start, 1/m.
        start_perm: f64,
        /// Curvature at its end, 1/m.
        end_perm: f64,
    },
    /// `v = a + b u + c u² + d u³` in axes of its own: `poly3` of OpenDRIVE.
    Cubic {
        /// Length along the curve, m.
        length_m: f64,
        /// a, b, c, d.
        v: [f64; 4],
    },
    /// `u(t)` and `v(t)`, each `a + b t + c t² + d t³`, in axes of their own: `paramPoly3` of OpenDRIVE.
    ParamCubic {
        /// Length along the curve, m. The piece is passed evenly where its true length is another one.
        length_m: f64,
        /// Coefficients of u, m.
        u: [f64; 4],
        /// Coefficients of v, m.
        v: [f64; 4],
        /// The parameter at its end; it begins at 0.
        end: f64,
    },
}

/// A piece with the place where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Laid {
    /// Its first point, and the direction of the curve there.
    pub start: Pose,
    pub piece: Piece,
}

/// Line, arc and clothoid.
struct Clothoid {
    length_m: f64,
    start_perm: f64,
    rate_perm2: f64,
}

impl Clothoid {
    fn heading_rad(&self, q_m: f64) -> f64 {
        q_m * (self.start_perm + 0.5 * self.rate_perm2 * q_m)
    }
}

impl Smooth for Clothoid {
    fn length_m(&self) -> f64 {
        self.length_m
    }

    fn begin(&self) -> State {
        State { curvature_perm: self.start_perm, rate_perm2: self.rate_perm2, ..State::default() }
    }

    fn advance(&self, from: &State, q_m: f64) -> State {
        let is_straight = self.start_perm == 0.0 && self.rate_perm2 == 0.0;
        let (dx_m, dy_m) = match is_straight {
            true => (q_m - from.q_m, 0.0),
            false => integrate(from.q_m, q_m, |q| {
                let (sin, cos) = libm::sincos(self.heading_rad(q));
                (cos, sin)
            }),
        };
        let x_m = if is_straight { q_m } else { from.pose.x_m + dx_m };
        State {
            q_m,
            pose: Pose { x_m, y_m: from.pose.y_m + dy_m, heading_rad: self.heading_rad(q_m) },
            curvature_perm: self.start_perm + self.rate_perm2 * q_m,
            rate_perm2: self.rate_perm2,
            parameter: 0.0,
        }
    }

    fn is_clothoid(&self) -> bool {
        true
    }
}

impl Piece {
    pub fn length_m(&self) -> f64 {
        match *self {
            Self::Line { length_m }
            | Self::Arc { length_m, .. }
            | Self::Spiral { length_m, .. }
            | Self::Cubic { length_m, .. }
            | Self::ParamCubic { length_m, .. } => length_m,
        }
    }

    /// The piece from its end to its start: what was left is right.
    ///
    /// ```
    /// use road::Piece;
    /// let spiral = Piece::Spiral { length_m: 50.0, start_perm: 0.0, end_perm: 0.01 };
    /// assert_eq!(spiral.reversed(), Piece::Spiral { length_m: 50.0, start_perm: -0.01, end_perm: 0.0 });
    /// ```
    pub fn reversed(&self) -> Self {
        match *self {
            Self::Line { .. } => *self,
            Self::Arc { length_m, curvature_perm } => {
                Self::Arc { length_m, curvature_perm: -curvature_perm }
            }
            Self::Spiral { length_m, start_perm, end_perm } => {
                Self::Spiral { length_m, start_perm: 0.0 - end_perm, end_perm: 0.0 - start_perm }
            }
            Self::Cubic { length_m, v } => {
                let end = Parametric::of_cubic(length_m, v).end_of(length_m);
                Self::ParamCubic { length_m, u: [0.0, 1.0, 0.0, 0.0], v, end }.reversed()
            }
            Self::ParamCubic { length_m, u, v, end } => {
                Self::ParamCubic { length_m, u: mirrored(u, end), v: mirrored(v, end), end }
            }
        }
    }

    /// The length along a cubic from its first to its last parameter, m; the declared length of other pieces.
    pub fn true_length_m(&self) -> f64 {
        match *self {
            Self::ParamCubic { u, v, end, .. } => crate::cubic::length_between(&u, &v, 0.0, end),
            _ => self.length_m(),
        }
    }

    pub(crate) fn check(&self, piece: usize) -> Result<(), AxisError> {
        let length_m = self.length_m();
        let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        let is_finite = length_m.is_finite()
            && match self {
                Self::Line { .. } => true,
                Self::Arc { curvature_perm, .. } => curvature_perm.is_finite(),
                Self::Spiral { start_perm, end_perm, .. } => finite(&[*start_perm, *end_perm]),
                Self::Cubic { v, .. } => finite(v),
                Self::ParamCubic { u, v, end, .. } => finite(u) && finite(v) && end.is_finite(),
            };
        if !is_finite {
            return Err(AxisFault::NotFinite.of(piece));
        }
        if length_m <= 0.0 || length_m > MAX_LENGTH_M {
            return Err(AxisFault::Length(length_m).of(piece));
        }
        if let Self::ParamCubic { end, .. } = self
            && *end <= 0.0
        {
            return Err(AxisFault::Cusp.of(piece));
        }
        let true_m = self.true_length_m();
        if !((true_m / length_m - 1.0).abs() <= MAX_DECLARED) {
            return Err(AxisFault::Declared { length_m, true_m }.of(piece));
        }
        Ok(())
    }

    /// The curve to go along.
    pub(crate) fn smooth(&self) -> Box<dyn Smooth> {
        let clothoid = |length_m, start_perm, rate_perm2| {
            Box::new(Clothoid { length_m, start_perm, rate_perm2 })
        };
        match *self {
            Self::Line { length_m } => clothoid(length_m, 0.0, 0.0),
            Self::Arc { length_m, curvature_perm } => clothoid(length_m, curvature_perm, 0.0),
            Self::Spiral { length_m, start_perm, end_perm } => {
                clothoid(length_m, start_perm, (end_perm - start_perm) / length_m)
            }
            Self::Cubic { length_m, v } => Box::new(Parametric::of_cubic(length_m, v)),
            Self::ParamCubic { length_m, u, v, end } => {
                Box::new(Parametric::new(length_m, u, v, end))
            }
        }
    }
}

/// The coefficients of `f(end - t)`.
fn mirrored([a, b, c, d]: [f64; 4], end: f64) -> [f64; 4] {
    [
        a + end * (b + end * (c + end * d)),
        -(b + end * (2.0 * c + 3.0 * end * d)),
        c + 3.0 * end * d,
        -d,
    ]
}
