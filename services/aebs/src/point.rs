//! A detection as a point on the ego's way, with its accuracy.

use messages::Detection;

use crate::corridor::Corridor;
use crate::object::STANDING_MPS;

/// Standard deviation of an azimuth: of a strong echo, rad, and of one as strong as the noise.
const AZIMUTH_SIGMA_RAD: f64 = 0.0018;
const WEAK_SIGMA_RAD: f64 = 0.0205;
/// Standard deviation of a range rate, m/s.
const RATE_SIGMA_MPS: f64 = 0.04;
const RANGE_SIGMA_M: f64 = 0.1;
/// Least cosine of the angle between a line of sight and a motion. Below it, a range rate shows little of the motion.
const LEAST_COSINE: f64 = 0.1;
/// What stands farther off the way is beside the road, m: beyond the neighbouring lanes.
const ROAD_M: f64 = 5.0;
/// Standard deviation of the place that reflects on a side, m.
pub(crate) const SIDE_SIGMA_M: f64 = 0.03;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Along the way and left of it.
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    /// Speed over ground of what moves along the road.
    pub(crate) speed_mps: f64,
    /// Tangent of the angle between the line of sight and the road there.
    pub(crate) tangent: f64,
    /// Variance of the lateral position, m².
    pub(crate) variance_m2: f64,
    /// Variance of the speed, m²/s².
    pub(crate) speed_variance: f64,
}

impl Point {
    /// `None` for what is behind the antenna, moves across the line of sight, or stands beside the road.
    pub(crate) fn of(detection: &Detection, ego_mps: f64, corridor: &Corridor) -> Option<Self> {
        let (sine, cosine) = libm::sincos(detection.azimuth_rad);
        let (ahead_m, left_m) = (detection.range_m * cosine, detection.range_m * sine);
        let ((x_m, y_m), road_rad) = corridor.to_way(ahead_m, left_m);
        let (road_sine, road_cosine) = libm::sincos(detection.azimuth_rad - road_rad);
        if cosine < LEAST_COSINE || road_cosine < LEAST_COSINE {
            return None;
        }
        // A standing object comes nearer with the ego's own speed along the line of sight.
        let own_mps = ego_mps * libm::cos(detection.azimuth_rad - corridor.heading_rad(0.0));
        let speed_mps = (own_mps + detection.range_rate_mps) / road_cosine;
        if y_m.abs() > ROAD_M && speed_mps.abs() < 2.0 * STANDING_MPS {
            return None;
        }
        let amplitude = libm::exp10(0.05 * detection.snr_db.clamp(0.0, 60.0));
        let weak_rad = WEAK_SIGMA_RAD / amplitude;
        let along_m2 = RANGE_SIGMA_M * RANGE_SIGMA_M * road_sine * road_sine;
        let azimuth_rad2 = AZIMUTH_SIGMA_RAD * AZIMUTH_SIGMA_RAD + weak_rad * weak_rad;
        let lever_m = detection.range_m / cosine;
        let across_m2 = along_m2 + lever_m * lever_m * azimuth_rad2;
        Some(Self {
            x_m,
            y_m,
            speed_mps,
            tangent: road_sine / road_cosine,
            variance_m2: across_m2 + SIDE_SIGMA_M * SIDE_SIGMA_M,
            speed_variance: (RATE_SIGMA_MPS / road_cosine) * (RATE_SIGMA_MPS / road_cosine),
        })
    }
}

#[cfg(test)]
mod tests;
