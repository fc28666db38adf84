//! The corridor that the ego is about to sweep, as a chain of arcs.
//!
//! A point (x, y) of the *body* counts from the middle of the front bumper: x along the body, y to the left. It becomes
//! (σ, d): the length along the corridor's middle and the distance left of it. In the axes at the begin of an arc of
//! curvature κ, with the circle's centre at (0, 1/κ):
//!
//! ```text
//! q = κ (x² + y²) - 2 y
//! d = -q / (1 + √(1 + κ q))
//! σ = atan2(κ x, 1 - κ y) / κ
//! ```
//!
//! which is (x, y) where κ = 0. The first arc goes on behind the bumper, and the last one ahead. A chain of one arc is
//! a circle.
//!
//! The curvature of the road deviates from that of the corridor. So the standard deviation of the road across the corridor
//! grows with the square of the distance.
//!
//! ```
//! use aebs::corridor::Corridor;
//!
//! let circle = Corridor::circle(1.0 / 250.0, 0.0, 0.0);
//! let (x_m, y_m) = circle.to_body(60.0, -3.5);
//! let ((along_m, off_m), _) = circle.to_way(x_m, y_m);
//! assert!((along_m - 60.0).abs() < 1e-9 && (off_m + 3.5).abs() < 1e-9);
//! ```

use messages::{COURSE_CELL_M, COURSE_CELLS};

/// An arc, from its begin in the axes of the body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Arc {
    from_m: f64,
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    curvature_perm: f64,
}

/// A corridor through the middle of the ego's front bumper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corridor {
    arcs: [Arc; COURSE_CELLS],
    /// Arcs behind the first one.
    more: usize,
    /// Standard deviation of the road's curvature, 1/m.
    sigma_perm: f64,
}

/// A vector in axes that are turned to the left by `rad`.
pub(crate) fn seen_turned((x_m, y_m): (f64, f64), rad: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(rad);
    (x_m * cosine + y_m * sine, y_m * cosine - x_m * sine)
}

impl Arc {
    /// A point of the body in the axes at its begin.
    fn seen(&self, (x_m, y_m): (f64, f64)) -> (f64, f64) {
        seen_turned((x_m - self.x_m, y_m - self.y_m), self.heading_rad)
    }

    /// The point of the body that is `along_m` from its begin, and `off_m` left of it.
    fn place(&self, along_m: f64, off_m: f64) -> (f64, f64) {
        let half_rad = 0.5 * self.curvature_perm * along_m;
        // A chord has the heading of half of its turn.
        let chord_m =
            if half_rad == 0.0 { along_m } else { along_m * libm::sin(half_rad) / half_rad };
        let (x_m, y_m) = seen_turned((0.0, off_m), -half_rad);
        let (x_m, y_m) = seen_turned((chord_m + x_m, y_m), -half_rad - self.heading_rad);
        (self.x_m + x_m, self.y_m + y_m)
    }

    fn heading_rad(&self, along_m: f64) -> f64 {
        self.heading_rad + self.curvature_perm * along_m
    }
}

impl Corridor {
    /// A circle that leaves the bumper with a heading, rad to the left of the body.
    pub fn circle(curvature_perm: f64, heading_rad: f64, sigma_perm: f64) -> Self {
        let mut corridor = Self { sigma_perm, ..Self::default() };
        corridor.arcs[0] = Arc { heading_rad, curvature_perm, ..Arc::default() };
        corridor
    }

    /// The corridor of cells of a length, each with its curvature. The ego has driven `driven_m` since the begin of the
    /// first cell, and leaves the bumper with a heading.
    pub(crate) fn of_cells(
        cells_perm: &[f64; COURSE_CELLS],
        driven_m: f64,
        heading_rad: f64,
        sigma_perm: f64,
    ) -> Self {
        let first = ((driven_m / COURSE_CELL_M) as usize).min(COURSE_CELLS - 1);
        let mut corridor = Self::circle(cells_perm[first], heading_rad, sigma_perm);
        for (cell, curvature_perm) in cells_perm.iter().enumerate().skip(first + 1) {
            let before = &corridor.arcs[corridor.more];
            let from_m = cell as f64 * COURSE_CELL_M - driven_m;
            let length_m = from_m - before.from_m;
            let (x_m, y_m) = before.place(length_m, 0.0);
            let heading_rad = before.heading_rad(length_m);
            corridor.more += 1;
            corridor.arcs[corridor.more] =
                Arc { from_m, x_m, y_m, heading_rad, curvature_perm: *curvature_perm };
        }
        corridor
    }

    /// Length along the corridor and distance left of it, m, of a point of the body. The second value is the corridor's
    /// heading there, rad to the left of the body.
    pub fn to_way(&self, x_m: f64, y_m: f64) -> ((f64, f64), f64) {
        let behind = self.arcs[1..=self.more].iter();
        let begun = behind.take_while(|arc| arc.seen((x_m, y_m)).0 > 0.0).count();
        let arc = &self.arcs[begun];
        let (x_m, y_m) = arc.seen((x_m, y_m));
        let k = arc.curvature_perm;
        if k == 0.0 {
            return ((arc.from_m + x_m, y_m), arc.heading_rad);
        }
        let q_m = k * (x_m * x_m + y_m * y_m) - 2.0 * y_m;
        let root = (1.0 + k * q_m).max(0.0).sqrt();
        let turn_rad = libm::atan2(k * x_m, 1.0 - k * y_m);
        ((arc.from_m + turn_rad / k, -q_m / (1.0 + root)), arc.heading_rad + turn_rad)
    }

    /// The point of the body that is `along_m` along the corridor and `off_m` left of it.
    pub fn to_body(&self, along_m: f64, off_m: f64) -> (f64, f64) {
        let arc = self.arc_at(along_m);
        arc.place(along_m - arc.from_m, off_m)
    }

    /// Its heading at a distance ahead, rad to the left of the body.
    pub(crate) fn heading_rad(&self, along_m: f64) -> f64 {
        let arc = self.arc_at(along_m);
        arc.heading_rad(along_m - arc.from_m)
    }

    /// Standard deviation of the road across it at a distance ahead, m; 0 on a straight road.
    pub(crate) fn sigma_m(&self, along_m: f64) -> f64 {
        0.5 * self.sigma_perm * along_m * along_m
    }

    fn arc_at(&self, along_m: f64) -> &Arc {
        let behind = self.arcs[1..=self.more].iter();
        &self.arcs[behind.take_while(|arc| arc.from_m < along_m).count()]
    }
}

#[cfg(test)]
mod tests;
