//! Contact of two bodies in the plane: rectangles, by the separating-axis theorem.
//!
//! Two convex bodies are apart exactly if a line between them exists. For rectangles it is enough to try the four
//! directions of their sides.

use messages::{VehiclePose, VehicleTruthItem};

/// A body in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rectangle {
    pub x_m: f64,
    pub y_m: f64,
    /// Cosine and sine of its heading.
    pub direction: (f64, f64),
    pub half_length_m: f64,
    pub half_width_m: f64,
}

impl Rectangle {
    pub fn of(pose: &VehiclePose) -> Self {
        let (sine, cosine) = libm::sincos(pose.heading_rad);
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            direction: (cosine, sine),
            half_length_m: 0.5 * pose.length_m,
            half_width_m: 0.5 * pose.width_m,
        }
    }

    /// The body `length_m` behind a front bumper.
    pub fn behind(front: &road::Pose, length_m: f64, width_m: f64) -> Self {
        let (sine, cosine) = libm::sincos(front.heading_rad);
        let half_length_m = 0.5 * length_m;
        Self {
            x_m: front.x_m - half_length_m * cosine,
            y_m: front.y_m - half_length_m * sine,
            direction: (cosine, sine),
            half_length_m,
            half_width_m: 0.5 * width_m,
        }
    }

    /// The same `way_m` farther along its heading.
    pub fn moved(self, way_m: f64) -> Self {
        let (cosine, sine) = self.direction;
        Self { x_m: self.x_m + way_m * cosine, y_m: self.y_m + way_m * sine, ..self }
    }

    /// True if the bodies overlap. Those that only touch along the sides do not. Those that touch at the ends do, as a
    /// gap of 0 is a collision on the axis.
    pub fn meets(&self, other: &Self) -> bool {
        let (x, y) = (other.x_m - self.x_m, other.y_m - self.y_m);
        let apart = |one: &Self, another: &Self| {
            let (cosine, sine) = one.direction;
            let (ahead, aside) = (x * cosine + y * sine, y * cosine - x * sine);
            // The other's direction in the axes of the one.
            let (c, s) = another.direction;
            let (along, across) = ((c * cosine + s * sine).abs(), (s * cosine - c * sine).abs());
            let (length, width) = (another.half_length_m, another.half_width_m);
            ahead.abs() > one.half_length_m + length * along + width * across
                || aside.abs() >= one.half_width_m + length * across + width * along
        };
        !apart(self, other) && !apart(other, self)
    }
}

/// Speed, m/s, at which the ego's body meets another that it touches; `None` without contact. The others are moved on
/// from their sample, which is `age_s` old.
pub fn closing_at_contact<'a>(
    ego: &Rectangle,
    speed_mps: f64,
    age_s: f64,
    others: impl Iterator<Item = (&'a VehicleTruthItem, &'a VehiclePose)>,
    within_m: f64,
) -> Option<f64> {
    let touched = others.filter_map(|(vehicle, pose)| {
        let (v, a) = (vehicle.speed_mps, vehicle.acceleration_mps2);
        // Braking ends at standstill.
        let moving_s = if a < 0.0 && v > 0.0 { age_s.min(v / -a) } else { age_s };
        // The truth's speed counts along the axis, that of an oncoming body against its heading.
        let sign = if v < 0.0 { -1.0 } else { 1.0 };
        let there =
            Rectangle::of(pose).moved(sign * (v * moving_s + 0.5 * a * moving_s * moving_s));
        let (cosine, sine) = there.direction;
        let along_ego = cosine * ego.direction.0 + sine * ego.direction.1;
        let (x_m, y_m) = (ego.x_m - there.x_m, ego.y_m - there.y_m);
        let near = x_m * x_m + y_m * y_m <= within_m * within_m;
        let closing_mps = speed_mps - sign * (v + a * moving_s) * along_ego;
        (near && ego.meets(&there)).then_some(closing_mps)
    });
    touched.reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use proptest::prelude::*;

    fn body(x_m: f64, y_m: f64, heading_rad: f64, size_m: (f64, f64)) -> Rectangle {
        let (length_m, width_m) = size_m;
        Rectangle::of(&VehiclePose { x_m, y_m, heading_rad, length_m, width_m })
    }

    /// Corners of a body, and points along its sides.
    fn outline(body: &Rectangle) -> Vec<(f64, f64)> {
        let (cosine, sine) = body.direction;
        let at = |ahead: f64, aside: f64| {
            let (l, w) = (ahead * body.half_length_m, aside * body.half_width_m);
            (body.x_m + l * cosine - w * sine, body.y_m + l * sine + w * cosine)
        };
        let steps = (-20..=20).map(|step| f64::from(step) / 20.0);
        steps.flat_map(|t| [at(t, 1.0), at(t, -1.0), at(1.0, t), at(-1.0, t)]).collect()
    }

    fn holds(body: &Rectangle, (x_m, y_m): (f64, f64), spare_m: f64) -> bool {
        let (x, y) = (x_m - body.x_m, y_m - body.y_m);
        let (cosine, sine) = body.direction;
        (x * cosine + y * sine).abs() < body.half_length_m + spare_m
            && (y * cosine - x * sine).abs() < body.half_width_m + spare_m
    }

    proptest! {
        /// The rule on the axis: bodies side by side within their half widths, and a gap of at most 0.
        #[test]
        fn bodies_along_one_direction_meet_as_on_the_axis(
            gap_m in -25.0..5.0f64, lateral_m in -4.0..4.0f64, length_m in 2.0..18.0f64,
            width_m in 1.5..2.6f64,
        ) {
            let ego = body(-2.25, 0.0, 0.0, (4.5, 1.8));
            let other = body(gap_m + 0.5 * length_m, lateral_m, 0.0, (length_m, width_m));
            let in_lane = lateral_m.abs() < 0.5 * (1.8 + width_m);
            let on_axis = in_lane && gap_m <= 0.0 && gap_m > -(4.5 + length_m);
            prop_assert_eq!(ego.meets(&other), on_axis);
            prop_assert_eq!(other.meets(&ego), on_axis);
        }

        #[test]
        fn bodies_meet_where_one_reaches_into_the_other(
            x_m in -8.0..8.0f64, y_m in -8.0..8.0f64, one in -4.0..4.0f64, two in -4.0..4.0f64,
            length_m in 2.0..12.0f64, width_m in 1.5..2.6f64,
        ) {
            let ego = body(0.0, 0.0, one, (4.5, 1.8));
            let other = body(x_m, y_m, two, (length_m, width_m));
            let inside = |spare_m: f64| {
                outline(&other).into_iter().any(|point| holds(&ego, point, spare_m))
                    || outline(&ego).into_iter().any(|point| holds(&other, point, spare_m))
            };
            let meets = ego.meets(&other);
            // The points of an outline are up to 0.6 m apart.
            prop_assert!(!inside(-1e-9) || meets, "points are inside, no contact");
            prop_assert!(inside(0.31) || !meets, "contact, no point near");
        }
    }

    #[test]
    fn a_body_is_moved_on_to_the_instant_and_closes_along_the_ego() {
        let mut truth = [VehicleTruthItem::zeroed(); 2];
        let near =
            VehiclePose { x_m: 6.0, y_m: 0.0, heading_rad: 0.0, length_m: 4.0, width_m: 1.8 };
        let mut poses = [near, VehiclePose { x_m: 60.0, ..near }];
        truth[0].speed_mps = 10.0;
        let ego =
            Rectangle::behind(&road::Pose { x_m: 3.95, y_m: 0.0, heading_rad: 0.0 }, 4.5, 1.8);
        let closing = |truth: &[VehicleTruthItem], poses: &[VehiclePose], age_s: f64| {
            closing_at_contact(&ego, 15.0, age_s, truth.iter().zip(poses), 30.0)
        };
        assert_eq!(closing(&truth, &poses, 0.0), None, "0.05 m apart");
        poses[0].x_m = 5.9;
        assert_eq!(closing(&truth, &poses, 0.0), Some(5.0));
        assert_eq!(closing(&truth, &poses, 0.02), None, "it is 0.2 m farther by then");
        // One that comes towards the ego.
        truth[0].speed_mps = -10.0;
        poses[0].heading_rad = std::f64::consts::PI;
        poses[0].x_m = 6.1;
        let met = closing(&truth, &poses, 0.02).expect("0.2 m nearer");
        assert!((met - 25.0).abs() < 1e-9, "{met}");
    }
}
