//! A short stretch of an axis, as a series: evaluated without transcendental functions.

use crate::Pose;

pub const CELL_M: f64 = 5.0;

/// A stretch of at most 5 m, as a series from its middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub end_m: f64,
    pub middle_m: f64,
    pub pose: Pose,
    pub cos: f64,
    pub sin: f64,
    pub curvature_perm: f64,
    pub rate_perm2: f64,
    /// Metres along the curve for one metre of `p`.
    pub pace: f64,
}

/// A place on the axis or beside it.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub x_m: f64,
    pub y_m: f64,
    /// Heading of the axis, rad; not wrapped.
    pub heading_rad: f64,
    pub cos: f64,
    pub sin: f64,
    pub curvature_perm: f64,
}

impl Cell {
    /// The curvature alone, to the bit that of [`Self::at`].
    #[inline]
    pub fn curvature_at(&self, p_m: f64) -> f64 {
        self.curvature_perm + self.rate_perm2 * (self.pace * (p_m - self.middle_m))
    }

    /// The heading alone, to the bit that of [`Self::at`].
    #[inline]
    pub fn heading_at(&self, p_m: f64) -> f64 {
        let d = self.pace * (p_m - self.middle_m);
        self.pose.heading_rad + d * (self.curvature_perm + 0.5 * self.rate_perm2 * d)
    }

    /// The series for a clothoid, up to the sixth power of the distance from the middle.
    #[inline]
    pub fn at(&self, p_m: f64) -> Place {
        let d = self.pace * (p_m - self.middle_m);
        let (k, m, d2) = (self.curvature_perm, self.rate_perm2, d * d);
        let k2 = k * k;
        let u = d - d2
            * d
            * (k2 / 6.0 + k * m * d / 8.0
                - (k2 * k2 / 120.0 - m * m / 40.0 + k2 * k * m * d / 72.0) * d2);
        let v = d2
            * (0.5 * k + m * d / 6.0
                - (k2 * k / 24.0 + k2 * m * d / 20.0) * d2
                - (k * m * m / 48.0 - k2 * k2 * k / 720.0) * d2 * d2);
        let turn = d * (k + 0.5 * m * d);
        let t2 = turn * turn;
        let sin = turn * (1.0 - t2 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0)));
        let cos = 1.0 - t2 * 0.5 * (1.0 - t2 / 12.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0)));
        Place {
            x_m: self.pose.x_m + u * self.cos - v * self.sin,
            y_m: self.pose.y_m + u * self.sin + v * self.cos,
            heading_rad: self.pose.heading_rad + turn,
            cos: self.cos * cos - self.sin * sin,
            sin: self.sin * cos + self.cos * sin,
            curvature_perm: k + m * d,
        }
    }
}

/// The number of the 5 m in which a place lies.
#[inline]
pub(crate) fn after(p_m: f64) -> usize {
    (p_m / CELL_M).max(0.0) as usize
}
