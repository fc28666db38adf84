//! A vehicle other than the ego, as it truly is.

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// It is on the road; nothing else here means anything otherwise.
    pub present: bool,
    /// Position of the rear bumper along the road, m.
    pub rear_position_m: f64,
    /// Speed, m/s, negative where it comes towards the ego.
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Lateral position of its centre, m from the centre of the ego's lane, left positive.
    pub lateral_m: f64,
    pub lateral_speed_mps: f64,
    pub length_m: f64,
    pub width_m: f64,
    /// Lateral distance below which its body and the ego's would touch, m.
    pub touches_within_m: f64,
    /// Angle of its body to the axis, rad, left positive: 0 for one that goes along it, either way.
    pub turned_rad: f64,
}

impl Vehicle {
    /// Its body and the ego's would touch if they were at the same place along the road.
    pub fn in_ego_path(&self) -> bool {
        self.present && self.lateral_m.abs() < self.touches_within_m
    }

    /// Half of its extent along the axis, m.
    pub fn half_along_m(&self) -> f64 {
        half_extent_m(self.length_m, self.width_m, self.turned_rad)
    }

    /// Its middle, with the heading of its body, in the frame that begins with the road. The body has the tangent's heading
    /// and its own angle to it, or the opposite one where it comes towards the ego.
    pub fn pose(&self, axis: &road::Axis) -> road::Pose {
        let tangent = axis.point(self.rear_position_m + self.half_along_m(), self.lateral_m);
        let faces_rad = if self.speed_mps < 0.0 { std::f64::consts::PI } else { 0.0 };
        let heading_rad = tangent.heading_rad + self.turned_rad + faces_rad;
        road::Pose { heading_rad, ..tangent }
    }
}

/// Half of the extent of a rectangle in the direction from which it is turned, m.
pub(crate) fn half_extent_m(length_m: f64, width_m: f64, turned_rad: f64) -> f64 {
    if turned_rad == 0.0 {
        return 0.5 * length_m;
    }
    let (sine, cosine) = libm::sincos(turned_rad);
    0.5 * (length_m * cosine.abs() + width_m * sine.abs())
}
