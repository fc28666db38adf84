//! The ego's motion: by its sensors, and summed up in the plane of dead reckoning.

use libm::sincos;

/// The ego's motion as its sensors and its radar show it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Speed of the front bumper along its way, m/s.
    pub speed_mps: f64,
    /// Yaw rate, rad/s, left positive; `None` without a sensor of use.
    pub yaw_rate_radps: Option<f64>,
    /// Angle from the body's axis to the way of the front bumper, rad.
    pub slip_rad: f64,
}

/// Place and heading in the plane of dead reckoning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Front bumper, m.
    pub x_m: f64,
    pub y_m: f64,
    /// Heading of the body, rad.
    pub heading_rad: f64,
    /// Way of the ego so far, m.
    pub way_m: f64,
}

impl Frame {
    /// Moves the ego on by `dt_s`, with the yaw angle `turn_rad`.
    pub fn advance(&mut self, dt_s: f64, motion: &Motion, turn_rad: f64) {
        let way_m = (motion.speed_mps * dt_s).max(0.0);
        let (sine, cosine) = sincos(self.heading_rad + 0.5 * turn_rad + motion.slip_rad);
        self.x_m += way_m * cosine;
        self.y_m += way_m * sine;
        self.heading_rad += turn_rad;
        self.way_m += way_m;
    }

    /// A point of the plane in the axes of this frame.
    pub fn seen(&self, (x_m, y_m): (f64, f64)) -> (f64, f64) {
        let (sine, cosine) = sincos(self.heading_rad);
        let (dx, dy) = (x_m - self.x_m, y_m - self.y_m);
        (cosine * dx + sine * dy, cosine * dy - sine * dx)
    }

    /// A point of this frame in the plane.
    pub fn placed(&self, (x_m, y_m): (f64, f64)) -> (f64, f64) {
        let (sine, cosine) = sincos(self.heading_rad);
        (self.x_m + cosine * x_m - sine * y_m, self.y_m + sine * x_m + cosine * y_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_sees_what_it_has_placed() {
        let frame = Frame { x_m: 3.0, y_m: -2.0, heading_rad: 0.7, way_m: 0.0 };
        let (x_m, y_m) = frame.seen(frame.placed((10.0, 4.0)));
        assert!((x_m - 10.0).abs() < 1e-12 && (y_m - 4.0).abs() < 1e-12);
    }
}
