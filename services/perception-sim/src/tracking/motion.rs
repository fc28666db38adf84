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

/// Speed below which the yaw rate shows no curvature, m/s: its noise would decide.
const SLOW_MPS: f64 = 3.0;

/// The ego's own body, by which its bumper leaves the body's axis in a curve.
///
/// In a steady turn of curvature κ the rear axle's tyres slip by their compliance times the lateral acceleration v² κ.
/// The bumper, b before that axle, moves to the left with b κ v:
///
/// ```text
/// slip = b κ - compliance · v² κ        κ = yaw rate / v
/// ```
///
/// Source: Riekert and Schunck, Zur Fahrmechanik des gummibereiften Kraftfahrzeugs, Ingenieur-Archiv 11 (1940) 210.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// From the rear axle to the front bumper, m.
    axle_to_bumper_m: f64,
    /// Slip angle of the rear tyres by lateral acceleration, rad per m/s².
    slip_rad_per_mps2: f64,
}

impl Body {
    /// The ego of a scenario.
    pub fn of(plant: &scenario::plant::Plant) -> Self {
        let wheelbase_m = plant.lateral.wheelbase_m.value();
        let overhang_m = 0.5 * (plant.length_m.value() - wheelbase_m).max(0.0);
        Self {
            axle_to_bumper_m: wheelbase_m + overhang_m,
            slip_rad_per_mps2: plant.lateral.slip_rad_per_mps2.value(),
        }
    }

    /// The motion by a speed and a yaw rate.
    pub fn motion(&self, speed_mps: f64, yaw_rate_radps: Option<f64>) -> Motion {
        let slip = |radps| {
            radps * (self.axle_to_bumper_m / speed_mps - self.slip_rad_per_mps2 * speed_mps)
        };
        let turning = yaw_rate_radps.filter(|_| speed_mps >= SLOW_MPS);
        Motion { speed_mps, yaw_rate_radps, slip_rad: turning.map_or(0.0, slip) }
    }
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
    fn a_slow_bumper_leaves_a_curve_outwards_and_a_fast_one_inwards() {
        let body = Body { axle_to_bumper_m: 3.6, slip_rad_per_mps2: 0.0055 };
        // On a circle of 100 m: 0.036 rad, less 0.0055 rad for each m/s² of v² / 100 m.
        for (speed_mps, expected) in [(10.0, 0.0305), (20.0, 0.014), (30.0, -0.0135), (2.9, 0.0)] {
            let motion = body.motion(speed_mps, Some(0.01 * speed_mps));
            assert!((motion.slip_rad - expected).abs() < 1e-12, "{motion:?}");
        }
        assert_eq!(body.motion(20.0, None).slip_rad, 0.0);
    }

    #[test]
    fn a_frame_sees_what_it_has_placed() {
        let frame = Frame { x_m: 3.0, y_m: -2.0, heading_rad: 0.7, way_m: 0.0 };
        let (x_m, y_m) = frame.seen(frame.placed((10.0, 4.0)));
        assert!((x_m - 10.0).abs() < 1e-12 && (y_m - 4.0).abs() < 1e-12);
    }
}
