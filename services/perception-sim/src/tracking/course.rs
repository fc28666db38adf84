//! The course: perception's estimate of the road ahead, and road coordinates along it.
//!
//! The course begins at the middle of the ego's front bumper. Its heading is given in the body's axes (x ahead, y
//! left). Its curvature is a function of the arc length σ. d is the distance to its left. [`Course::locate`] gives σ
//! and d of a point in the body's axes, and [`Course::place`] is the inverse. The curve is evaluated once, at [`NODES`]
//! places; in between it is the arc of a circle. A straight course is the identity, bit for bit.
//!
//! ```
//! use perception_sim::tracking::course::Course;
//!
//! // A left curve of 500 m radius: its middle lies 2.5 m to the left after 50 m.
//! let course = Course::bent(0.0, |_| 1.0 / 500.0);
//! let there = course.locate(50.0, 2.5);
//! assert!((there.sigma_m - 50.0).abs() < 0.2 && there.d_m.abs() < 0.02);
//! assert_eq!(Course::STRAIGHT.locate(50.0, 2.5).d_m, 2.5);
//! ```

use super::belief::road::{Node, nearest};

/// Places at which the course is evaluated.
pub const NODES: usize = 24;
/// Distance between two of them, m. The last one is beyond the radar's range.
const SPACING_M: f64 = 8.0;

/// A node at the bumper along the body.
const AHEAD: Node =
    Node { x_m: 0.0, y_m: 0.0, cosine: 1.0, sine: 0.0, turn_rad: 0.0, curvature_perm: 0.0 };

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    pub is_straight: bool,
    /// Heading at the bumper in the body's axes, rad.
    pub heading_rad: f64,
    nodes: [Node; NODES],
}

/// Place of a point on the course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// Arc length, m.
    pub sigma_m: f64,
    /// Distance to the left, m.
    pub d_m: f64,
    /// Cosine and sine of the course's heading there, in the body's axes.
    pub tangent: (f64, f64),
    pub curvature_perm: f64,
}

impl Course {
    /// The course of a straight road along the body.
    pub const STRAIGHT: Self = Self { is_straight: true, heading_rad: 0.0, nodes: [AHEAD; NODES] };

    /// The course of a heading at the bumper, rad, and a curvature by the arc length, 1/m.
    pub fn bent(heading_rad: f64, curvature_perm: impl Fn(f64) -> f64) -> Self {
        let mut course = Self { is_straight: false, heading_rad, ..Self::STRAIGHT };
        let (sine, cosine) = libm::sincos(heading_rad);
        let mut node = Node { cosine, sine, curvature_perm: curvature_perm(0.0), ..AHEAD };
        for index in 0..NODES {
            course.nodes[index] = node;
            let (from_m, from_perm) = (index as f64 * SPACING_M, node.curvature_perm);
            let middle_perm = curvature_perm(from_m + 0.5 * SPACING_M);
            let to_perm = curvature_perm(from_m + SPACING_M);
            // Turn to the middle, and to the mean heading of the stretch; the chord of an arc is shorter than the arc.
            let middle_rad = 0.25 * SPACING_M * (from_perm + middle_perm);
            let mean_rad = middle_rad + (to_perm - from_perm) * (SPACING_M / 24.0);
            let turn_rad = middle_perm * SPACING_M;
            let chord_m = SPACING_M * (1.0 - turn_rad * turn_rad * (1.0 / 24.0));
            let along = node.turned(mean_rad);
            let turn_rad = (SPACING_M / 6.0) * (from_perm + 4.0 * middle_perm + to_perm);
            (node.cosine, node.sine) = node.turned(turn_rad);
            node.x_m += chord_m * along.0;
            node.y_m += chord_m * along.1;
            node.curvature_perm = to_perm;
        }
        course
    }

    /// Curvature, 1/m, left positive.
    pub fn curvature_perm(&self, sigma_m: f64) -> f64 {
        let place = (sigma_m / SPACING_M).clamp(0.0, (NODES - 1) as f64);
        let index = (place as usize).min(NODES - 2);
        let (a, b) = (self.nodes[index].curvature_perm, self.nodes[index + 1].curvature_perm);
        a + (b - a) * (place - index as f64)
    }

    /// Place of a point of the body's axes on the course.
    pub fn locate(&self, x_m: f64, y_m: f64) -> Located {
        if self.is_straight {
            return Located { sigma_m: x_m, d_m: y_m, tangent: (1.0, 0.0), curvature_perm: 0.0 };
        }
        let (index, along_m, across_m) = nearest(&self.nodes, (SPACING_M, 0.0), (x_m, y_m));
        let curvature = self.arc_of(index, along_m);
        // Polar coordinates about the middle of the arc, without a division by the curvature.
        let (a, g) = (curvature * along_m, 1.0 - curvature * across_m);
        let radius = (a * a + g * g).sqrt();
        let square = along_m * along_m + across_m * across_m;
        let slope = a / g;
        let arc_m = along_m / g * (1.0 - slope * slope * (1.0 / 3.0 - slope * slope / 5.0));
        let sigma_m = index as f64 * SPACING_M + arc_m;
        Located {
            sigma_m,
            d_m: (2.0 * across_m - curvature * square) / (1.0 + radius),
            tangent: self.nodes[index].turned(curvature * arc_m),
            curvature_perm: self.curvature_perm(sigma_m),
        }
    }

    /// Point of the body's axes at a place of the course, m ahead and to the left.
    pub fn place(&self, sigma_m: f64, d_m: f64) -> (f64, f64) {
        if self.is_straight {
            return (sigma_m, d_m);
        }
        let index = node_at(sigma_m / SPACING_M);
        let arc_m = sigma_m - index as f64 * SPACING_M;
        let turn_rad = self.arc_of(index, arc_m) * arc_m;
        let square = turn_rad * turn_rad;
        let along_m = arc_m * (1.0 - square / 6.0 * (1.0 - square / 20.0));
        let across_m = arc_m * turn_rad * (0.5 - square / 24.0 * (1.0 - square / 30.0));
        let node = &self.nodes[index];
        let (cosine, sine) = node.turned(turn_rad);
        (
            node.x_m + node.cosine * along_m - node.sine * across_m - sine * d_m,
            node.y_m + node.sine * along_m + node.cosine * across_m + cosine * d_m,
        )
    }

    /// Cosine and sine of the heading at an arc length.
    pub fn tangent(&self, sigma_m: f64) -> (f64, f64) {
        if self.is_straight {
            return (1.0, 0.0);
        }
        let index = node_at(sigma_m / SPACING_M);
        let arc_m = sigma_m - index as f64 * SPACING_M;
        self.nodes[index].turned(self.arc_of(index, arc_m) * arc_m)
    }

    /// Curvature of the arc around a node; beyond both ends the course is a line.
    fn arc_of(&self, index: usize, along_m: f64) -> f64 {
        if along_m.abs() > SPACING_M { 0.0 } else { self.nodes[index].curvature_perm }
    }
}

/// The node nearest to a multiple of their distance.
fn node_at(place: f64) -> usize {
    (place.round().max(0.0) as usize).min(NODES - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The clothoid of a heading, a curvature and its rate.
    fn clothoid(shape: [f64; 3]) -> Course {
        Course::bent(shape[0], |sigma_m| shape[1] + shape[2] * sigma_m)
    }

    /// Point of a clothoid by small steps, m.
    fn integrated(shape: [f64; 3], sigma_m: f64) -> (f64, f64) {
        let steps = 20_000;
        let step_m = sigma_m / f64::from(steps);
        (0..steps).fold((0.0, 0.0), |(x, y), k| {
            let s = (f64::from(k) + 0.5) * step_m;
            let (sine, cosine) = libm::sincos(shape[0] + s * (shape[1] + 0.5 * shape[2] * s));
            (x + step_m * cosine, y + step_m * sine)
        })
    }

    #[test]
    fn it_follows_the_clothoid_to_millimetres() {
        for shape in [[0.01, 1.0 / 125.0, 0.0], [-0.02, 0.0, 2e-5], [0.0, -1.0 / 250.0, 4e-5]] {
            let course = clothoid(shape);
            for sigma_m in [3.0, 40.0, 77.0, 150.0] {
                let (x, y) = integrated(shape, sigma_m);
                let (at_x, at_y) = course.place(sigma_m, 0.0);
                assert!((x - at_x).abs() + (y - at_y).abs() < 5e-3, "{shape:?} at {sigma_m}");
            }
        }
    }

    #[test]
    fn a_straight_course_changes_no_bit_and_a_flat_clothoid_next_to_nothing() {
        let flat = clothoid([0.0; 3]);
        for (x, y) in [(0.3, -7.0), (61.7, 3.456), (149.9, -20.0)] {
            let there = Course::STRAIGHT.locate(x, y);
            assert_eq!((there.sigma_m, there.d_m, there.tangent), (x, y, (1.0, 0.0)));
            assert_eq!(Course::STRAIGHT.place(x, y), (x, y));
            let there = flat.locate(x, y);
            assert!((there.sigma_m - x).abs() < 1e-9 && (there.d_m - y).abs() < 1e-9);
        }
    }

    #[test]
    fn a_curve_to_the_right_mirrors_one_to_the_left() {
        let left = clothoid([0.01, 1.0 / 300.0, 1e-5]);
        let right = clothoid([-0.01, -1.0 / 300.0, -1e-5]);
        for (x, y) in [(20.0, 1.0), (90.0, 12.0), (120.0, 30.0)] {
            let (a, b) = (left.locate(x, y), right.locate(x, -y));
            assert_eq!((a.sigma_m, a.d_m, a.tangent.0), (b.sigma_m, -b.d_m, b.tangent.0));
        }
    }

    proptest! {
        #[test]
        fn a_place_is_located_where_it_is(
            heading in -0.05_f64..0.05,
            curvature in -0.008_f64..0.008,
            rate in -4e-5_f64..4e-5,
            sigma_m in 0.0_f64..150.0,
            d_m in -15.0_f64..15.0,
        ) {
            // A road whose curvature keeps its neighbourhood free of the centre of its circle.
            prop_assume!((curvature + rate * sigma_m).abs() < 0.01);
            let course = clothoid([heading, curvature, rate]);
            let (x, y) = course.place(sigma_m, d_m);
            prop_assume!(x.hypot(y) < 160.0 && x > 0.0);
            let there = course.locate(x, y);
            prop_assert!((there.sigma_m - sigma_m).abs() < 0.02, "{there:?}");
            prop_assert!((there.d_m - d_m).abs() < 5e-3, "{there:?}");
            let (cosine, sine) = there.tangent;
            prop_assert!((cosine * cosine + sine * sine - 1.0).abs() < 1e-5);
        }
    }
}

#[cfg(test)]
mod exact_tests;
