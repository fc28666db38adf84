//! The course by the yaw rate alone: the circle on which the ego is.

use super::course::Course;
use super::motion::Motion;

/// Memory of the curvature, s: the noise of the yaw rate, and the driver's corrections.
const MEMORY_S: f64 = 0.5;
/// Speed below which the yaw rate does not show the curvature, m/s: its offset of 0.1 °/s makes 6e-4 1/m there.
const SLOW_MPS: f64 = 3.0;
/// Error of the heading, rad, and of the curvature, 1/m: a wander of 0.2 m within the lane.
const HEADING_RAD: f64 = 0.012;
const CURVATURE_PERM: f64 = 3e-4;

/// The circle.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    curvature_perm: f64,
    course: Course,
}

impl Default for Circle {
    fn default() -> Self {
        Self { curvature_perm: 0.0, course: Course::bent(0.0, |_| 0.0) }
    }
}

impl Circle {
    /// Takes the ego's motion in a scan.
    pub fn take(&mut self, dt_s: f64, motion: &Motion) {
        if let Some(radps) = motion.yaw_rate_radps.filter(|_| motion.speed_mps >= SLOW_MPS) {
            let share = (dt_s / MEMORY_S).min(1.0);
            self.curvature_perm += share * (radps / motion.speed_mps - self.curvature_perm);
        }
        self.course = Course::bent(motion.slip_rad, |_| self.curvature_perm);
    }

    /// The course.
    #[must_use]
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// Standard deviation of its place across the road at an arc length, m, while the road keeps its curvature.
    #[must_use]
    pub fn sigma_m(sigma_m: f64) -> f64 {
        libm::hypot(HEADING_RAD * sigma_m, 0.5 * CURVATURE_PERM * sigma_m * sigma_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_ego_s_own_circle() {
        let mut circle = Circle::default();
        let motion = Motion { speed_mps: 20.0, yaw_rate_radps: Some(0.1), slip_rad: 0.01 };
        (0..100).for_each(|_| circle.take(0.05, &motion));
        assert!((circle.course().curvature_perm(50.0) - 0.005).abs() < 1e-6);
        assert_eq!(circle.course().heading_rad(), 0.01);
        let slow = Motion { speed_mps: 2.0, yaw_rate_radps: Some(1.0), ..motion };
        circle.take(0.05, &slow);
        assert!((circle.course().curvature_perm(50.0) - 0.005).abs() < 1e-6);
        assert!((Circle::sigma_m(100.0) - libm::hypot(1.2, 1.5)).abs() < 1e-9);
    }
}
