//! The road ahead by the estimate: the course, and how exactly it is known.

use super::super::course::Course;
use super::super::course_numbers::CourseNumbers;
use super::super::curvature_knots as knots;
use super::{CourseFilter, sum};

impl CourseFilter {
    /// Its numbers.
    #[must_use]
    pub fn numbers(&self) -> &CourseNumbers {
        &self.numbers
    }

    /// The course.
    #[must_use]
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// Any source is in use.
    #[must_use]
    pub fn is_used(&self) -> bool {
        self.sources.any()
    }

    /// Standard deviation of the course's place across the road at an arc length, m; 0 of the straight path.
    #[must_use]
    pub fn sigma_m(&self, sigma_m: f64) -> f64 {
        if !self.sources.any() {
            return 0.0;
        }
        let weights = knots::place(sigma_m.max(0.0), self.passed_m);
        self.state.variance_along(&weights).max(0.0).sqrt()
    }

    /// The same for the choice of the target. A circle is followed as it is. How the road leaves it is unknown, and the
    /// limits of a known path decide.
    #[must_use]
    pub fn path_sigma_m(&self, sigma_m: f64) -> f64 {
        if self.sources.looks_ahead() { self.sigma_m(sigma_m) } else { 0.0 }
    }

    /// Standard deviation of the course's heading at an arc length, rad; 0 of the straight path.
    #[must_use]
    pub fn heading_sigma_rad(&self, sigma_m: f64) -> f64 {
        if !self.sources.any() {
            return 0.0;
        }
        let weights = knots::heading(sigma_m.max(0.0), self.passed_m);
        self.state.variance_along(&weights).max(0.0).sqrt()
    }

    /// Heading, rad, curvature, 1/m, and its rate, 1/m², of a clothoid. It begins as the course does, and is at the
    /// same place across the road 100 m ahead.
    #[must_use]
    pub fn clothoid(&self) -> [f64; 3] {
        const FAR_M: f64 = 100.0;
        if !self.sources.any() {
            return [0.0; 3];
        }
        let state = &self.state.mean;
        let curvature_perm = sum(&knots::curvature(0.0, self.passed_m), state);
        let bent_m = sum(&knots::place(FAR_M, self.passed_m), state) - state[0] * FAR_M;
        let rate_perm2 =
            (bent_m - 0.5 * curvature_perm * FAR_M * FAR_M) * 6.0 / (FAR_M * FAR_M * FAR_M);
        [state[0], curvature_perm, rate_perm2]
    }

    /// Standing objects and pairs of trail points that the last scan used.
    #[must_use]
    pub fn used(&self) -> (u32, u32) {
        (self.posts, self.trail_points)
    }
}
