//! Positions with a heading.

use serde::{Deserialize, Serialize};

/// A position and a heading in a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    pub x_m: f64,
    /// y, m, to the left of x.
    pub y_m: f64,
    /// Heading from the x axis, counter-clockwise, rad; not wrapped.
    pub heading_rad: f64,
}

impl Pose {
    /// A point of the plane as seen from here: ahead and to the left, m.
    ///
    /// ```
    /// let body = road::Pose { x_m: 10.0, y_m: 2.0, heading_rad: 0.0 };
    /// assert_eq!(body.to_local(15.0, 1.0), (5.0, -1.0));
    /// ```
    pub fn to_local(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.heading_rad);
        let (dx_m, dy_m) = (x_m - self.x_m, y_m - self.y_m);
        (dx_m * cos + dy_m * sin, dy_m * cos - dx_m * sin)
    }

    /// The point of the plane that lies `x_m` ahead and `y_m` to the left of here, m.
    pub fn to_world(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.heading_rad);
        (self.x_m + x_m * cos - y_m * sin, self.y_m + x_m * sin + y_m * cos)
    }

    /// This pose, given in the frame of `at`, in the frame that `at` is given in.
    ///
    /// ```
    /// let start = road::Pose { x_m: 100.0, y_m: 50.0, heading_rad: 0.0 };
    /// let on_road = road::Pose { x_m: 7.0, y_m: -1.0, heading_rad: 0.1 };
    /// assert_eq!(on_road.placed(&start), road::Pose { x_m: 107.0, y_m: 49.0, heading_rad: 0.1 });
    /// ```
    pub fn placed(&self, at: &Self) -> Self {
        let (x_m, y_m) = at.to_world(self.x_m, self.y_m);
        Self { x_m, y_m, heading_rad: at.heading_rad + self.heading_rad }
    }

    /// This pose as seen from `at`: the opposite of [`Self::placed`].
    pub fn seen_from(&self, at: &Self) -> Self {
        let (x_m, y_m) = at.to_local(self.x_m, self.y_m);
        Self { x_m, y_m, heading_rad: self.heading_rad - at.heading_rad }
    }

    /// True if all three numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.heading_rad.is_finite()
    }
}
