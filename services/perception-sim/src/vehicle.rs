//! A vehicle other than the ego, as it truly is.

/// A vehicle as it truly is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// It is on the road; nothing else here means anything otherwise.
    pub present: bool,
    /// Position of the rear bumper along the road, m.
    pub rear_position_m: f64,
    /// Speed, m/s, negative where it comes towards the ego.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Lateral position of its centre, m from the centre of the ego's lane, left positive.
    pub lateral_m: f64,
    /// Lateral speed, m/s, left positive.
    pub lateral_speed_mps: f64,
    /// Length, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Lateral distance below which its body and the ego's would touch, m.
    pub touches_within_m: f64,
}

impl Vehicle {
    /// Its body and the ego's would touch if they were at the same place along the road.
    #[must_use]
    pub fn in_ego_path(&self) -> bool {
        self.present && self.lateral_m.abs() < self.touches_within_m
    }

    /// Its middle, with the heading of its body, in the frame that begins with the road. The body has the tangent's heading,
    /// or the opposite one where it comes towards the ego.
    #[must_use]
    pub fn pose(&self, axis: &road::Axis) -> road::Pose {
        let tangent = axis.point(self.rear_position_m + 0.5 * self.length_m, self.lateral_m);
        let turned_rad = if self.speed_mps < 0.0 { std::f64::consts::PI } else { 0.0 };
        road::Pose { heading_rad: tangent.heading_rad + turned_rad, ..tangent }
    }
}
