//! Estimate of the course ([`super::course`]). It is a Kalman filter of the heading at the ego and the curvatures of
//! the knots ahead ([`super::curvature_knots`]).
//!
//! The road does not move. As the ego moves, only the heading changes: by the curvature of the way minus the ego's own
//! turn. New knots at the far end replace those that are passed. Then the state takes in:
//!
//! | source | measurement | variance |
//! |---|---|---|
//! | yaw rate | curvature at the ego = yaw rate / speed | the ego's own steering within the lane |
//! | yaw rate | heading = slip angle of the bumper | the angle of its way to the lane |
//! | standing objects | each is as far from the course as the edge of its side | the strip's depth; one object is met many times |
//! | trails | two places of one trail are equally far from the course | the wander of their vehicle; likewise |
//! | map | curvature ahead | an error of its place |
//!
//! The ego's own measurements are limited to a number of standard deviations. The others count only within them. So
//! wrong echoes do not bend the course. A course that has gone astray comes back to the ego's own way.
//!
//! Only weak objects near the known edge count, and only trails of confirmed tracks. A mirror image or a queue must not
//! bend the course. The course grows from the ego on. An object counts if the nearer ones show its side clearly.
//!
//! The yaw rate alone shows nothing of the road ahead. The course is then the circle of its curvature.
//!
//! Sources: Zomotor and Franke, Sensor fusion for improved vision based lane recognition and object tracking with
//! range-finders (IV 1997). Lundquist and Schön, Joint ego-motion and road geometry estimation, Information Fusion 12
//! (2011) 253: clothoid, guard rails and the motion of others.

use std::array::from_fn;

use kalman::{Gaussian, Innovation};

use super::course::Course;
use super::course_edges::Edges;
use super::course_numbers::CourseNumbers;
pub use super::course_sources::{MapAhead, Sources};
use super::curvature_knots::{self as knots, APART_M, KNOTS, STATES};
pub use super::trail::Motion;
use super::trail::Trails;

mod outlook;

/// Updates by standing objects in a scan at most.
const MOST_POSTS: usize = 16;

/// The estimate.
#[derive(Clone, Copy, Debug)]
pub struct CourseFilter {
    sources: Sources,
    numbers: CourseNumbers,
    state: Gaussian<STATES>,
    /// Way since the first knot, m.
    passed_m: f64,
    course: Course,
    edges: Edges,
    trails: Trails,
    posts: u32,
    trail_points: u32,
}

impl CourseFilter {
    /// The straight course, before the first scan.
    #[must_use]
    pub fn new(sources: Sources, numbers: &CourseNumbers) -> Self {
        let kept = if sources.looks_ahead() { numbers.kept } else { 1.0 };
        let numbers = &CourseNumbers { kept, ..*numbers };
        let mut state = Gaussian::independent([0.0; STATES], [0.0; STATES]);
        state.covariance[0][0] = square(numbers.first_heading_rad);
        forget_curvatures(&mut state, numbers, 1.0);
        Self {
            sources,
            numbers: *numbers,
            state,
            passed_m: 0.0,
            course: Course::STRAIGHT,
            edges: Edges::default(),
            trails: Trails::default(),
            posts: 0,
            trail_points: 0,
        }
    }

    /// Moves the course on to the next scan.
    pub fn advance(&mut self, dt_s: f64, motion: &Motion) {
        if !self.sources.any() {
            return;
        }
        let way_m = (motion.speed_mps * dt_s).max(0.0);
        let sharper = self.numbers.sharper(motion.speed_mps);
        let turn = knots::heading(way_m, self.passed_m);
        let road_rad: f64 = (1..STATES).map(|i| turn[i] * self.state.mean[i]).sum();
        // Without a usable yaw rate the ego follows the course.
        let told = motion.yaw_rate_radps.filter(|_| motion.speed_mps >= self.numbers.slow_mps);
        let turn_rad = told.map_or(road_rad, |radps| radps * dt_s);
        self.state.mean[0] += road_rad - turn_rad;
        self.turn_covariance(&turn);
        if way_m > 0.0 {
            self.state.covariance[0][0] += square(self.numbers.heading_rad);
            self.fade(way_m, sharper);
        }
        self.passed_m += way_m;
        while self.passed_m >= APART_M {
            self.pass_knot(sharper);
        }
        self.trails.advance(dt_s, turn_rad, motion);
        self.course = self.bent();
    }

    /// The curvatures become less certain on the way. A circle has one curvature, and changes as a whole.
    fn fade(&mut self, way_m: f64, sharper: f64) {
        let numbers = &self.numbers;
        if self.sources.looks_ahead() {
            let fading = square(numbers.curvature_perm * sharper) * way_m;
            (1..STATES).for_each(|i| self.state.covariance[i][i] += fading);
        } else {
            let fading = square(numbers.change_perm * sharper) * way_m / APART_M;
            let curvatures = self.state.covariance[1..].iter_mut();
            curvatures.flat_map(|row| &mut row[1..]).for_each(|entry| *entry += fading);
        }
    }

    /// The heading becomes the sum of the state by these weights, of which its own is 1.
    fn turn_covariance(&mut self, weights: &[f64; STATES]) {
        let p = &self.state.covariance;
        let row: [f64; STATES] = from_fn(|j| (0..STATES).map(|i| weights[i] * p[i][j]).sum());
        let corner = (0..STATES).map(|j| weights[j] * row[j]).sum();
        for j in 1..STATES {
            self.state.covariance[0][j] = row[j];
            self.state.covariance[j][0] = row[j];
        }
        self.state.covariance[0][0] = corner;
    }

    /// The first knot gives way to one beyond the last. Curves are `sharper` than at high speed.
    fn pass_knot(&mut self, sharper: f64) {
        self.passed_m -= APART_M;
        let numbers = &self.numbers;
        let before = self.state;
        // Place before: a knot's own, or the last one's for the new knot.
        let from = |i: usize| if i == 0 { 0 } else { (i + 1).min(KNOTS) };
        let share = |i: usize| if i == KNOTS { numbers.kept } else { 1.0 };
        self.state.mean = from_fn(|i| share(i) * before.mean[from(i)]);
        self.state.covariance =
            from_fn(|i| from_fn(|j| share(i) * share(j) * before.covariance[from(i)][from(j)]));
        if self.sources.looks_ahead() {
            self.state.covariance[KNOTS][KNOTS] += square(numbers.change_perm * sharper);
        }
    }

    /// The course of the state.
    fn bent(&self) -> Course {
        let (state, passed_m) = (&self.state.mean, self.passed_m);
        Course::bent(state[0], |sigma_m| knots::curvature_of(state, sigma_m, passed_m))
    }

    /// Takes in a scan: the ego's motion, the map, and the standing echoes. These are in the body's axes, in the order
    /// of their ranges. The course before it was that of [`Self::advance`]. Allocates nothing.
    pub fn take(&mut self, motion: &Motion, map: Option<&MapAhead>, standing: &[(f64, f64)]) {
        if !self.sources.any() {
            return;
        }
        (self.posts, self.trail_points) = (0, 0);
        let numbers = self.numbers;
        if self.sources.yaw_rate
            && motion.speed_mps >= numbers.slow_mps
            && let Some(radps) = motion.yaw_rate_radps
        {
            let curvature_perm = radps / motion.speed_mps;
            let weights = knots::curvature(0.0, self.passed_m);
            let off_perm = curvature_perm - sum(&weights, &self.state.mean);
            self.forget_if_wrong(&weights, off_perm, motion.speed_mps);
            self.see_limited(weights, off_perm, numbers.own_way_perm);
            let off_rad = motion.slip_rad - self.state.mean[0];
            self.see_limited(knots::heading(0.0, 0.0), off_rad, numbers.own_angle_rad);
        }
        if let Some(map) = map.filter(|_| self.sources.map) {
            self.take_map(map);
        }
        // All places are compared with one course: that of now.
        self.course = self.bent();
        let before = self.state.mean;
        if self.sources.standing {
            self.take_standing(&before, standing);
        }
        if self.sources.trails {
            self.take_trails(&before);
        }
        self.course = self.bent();
    }

    /// Forgets how exactly the road ahead is known if the ego's own way contradicts it: `off_perm` is beyond the gate. The
    /// mean stays.
    ///
    /// Objects of the wrong edge can keep a course straight while the road bends. Only the ego's own turn shows that,
    /// when the ego gets there.
    fn forget_if_wrong(&mut self, h: &[f64; STATES], off_perm: f64, speed_mps: f64) {
        let CourseNumbers { own_way_perm, gate, .. } = self.numbers;
        let variance = self.state.variance_along(h) + square(own_way_perm);
        if self.sources.looks_ahead() && square(off_perm) > square(gate) * variance {
            forget_curvatures(&mut self.state, &self.numbers, self.numbers.sharper(speed_mps));
        }
    }

    /// Takes in `residual` of the sum `h · state`, at most as much as the gate.
    fn see_limited(&mut self, h: [f64; STATES], residual: f64, sigma: f64) {
        let mut innovation = self.state.innovation_along(&h, residual, sigma * sigma);
        let limit = self.numbers.gate * innovation.variance.sqrt();
        innovation.residual = residual.clamp(-limit, limit);
        if innovation.residual.is_finite() {
            self.state.correct_along(&h, &innovation);
        }
    }

    /// Takes in `residual` of the sum `h · state`, if it is within the gate.
    fn see(&mut self, h: [f64; STATES], residual: f64, sigma: f64) -> bool {
        let variance = self.state.variance_along(&h);
        self.see_known(h, variance, residual, sigma)
    }

    /// The same where the variance of the sum is known.
    fn see_known(&mut self, h: [f64; STATES], variance: f64, residual: f64, sigma: f64) -> bool {
        let innovation = Innovation { residual, variance: variance + sigma * sigma };
        let passes = innovation.passes(self.numbers.gate);
        if passes {
            self.state.correct_along(&h, &innovation);
        }
        passes
    }

    /// The same of a residual against the course of the state `before`.
    fn see_from(
        &mut self,
        before: &[f64; STATES],
        h: [f64; STATES],
        residual: f64,
        sigma: f64,
    ) -> bool {
        let moved: f64 = (0..STATES).map(|i| h[i] * (self.state.mean[i] - before[i])).sum();
        self.see(h, residual - moved, sigma)
    }

    fn take_map(&mut self, map: &MapAhead) {
        // One value for each knot ahead.
        for knot in 0..KNOTS {
            let sigma_m = (knot as f64 * APART_M - self.passed_m).max(0.0);
            let Some(curvature_perm) = map.curvature_perm(sigma_m) else { return };
            let weights = knots::curvature(sigma_m, self.passed_m);
            let off_perm = curvature_perm - sum(&weights, &self.state.mean);
            self.see(weights, off_perm, self.numbers.map_perm);
        }
    }

    fn take_standing(&mut self, before: &[f64; STATES], standing: &[(f64, f64)]) {
        let numbers = self.numbers;
        let course = self.course;
        let mut taken = 0;
        // The nearest first: each one shows the course to the next.
        for &(x_m, y_m) in standing {
            let there = course.locate(x_m, y_m);
            let weights = knots::place(there.sigma_m, self.passed_m);
            let moved_m = sum(&weights, &self.state.mean) - sum(&weights, before);
            let d_m = there.d_m - moved_m;
            let variance = self.state.variance_along(&weights);
            let doubt_m = 3.0 * variance.max(0.0).sqrt();
            let reach_m = numbers.post_reach_m + doubt_m;
            let Some(off_m) = self.edges.take((there.sigma_m, d_m), reach_m, &numbers) else {
                continue;
            };
            if taken >= MOST_POSTS {
                continue;
            }
            let sigma_m = (square(numbers.post_sigma_m) * numbers.post_scans
                + square(numbers.post_azimuth_rad * there.sigma_m))
            .sqrt();
            if self.see_known(weights, variance, off_m, sigma_m) {
                taken += 1;
            }
        }
        self.posts = taken as u32;
    }

    fn take_trails(&mut self, before: &[f64; STATES]) {
        let (trails, course, numbers) = (self.trails, self.course, self.numbers);
        trails.pairs(|near, far| {
            let (near, far) = (course.locate(near.0, near.1), course.locate(far.0, far.1));
            let a = knots::place(near.sigma_m, self.passed_m);
            let b = knots::place(far.sigma_m, self.passed_m);
            let h = from_fn(|i| b[i] - a[i]);
            let growth = 1.0 + square(far.sigma_m / numbers.trail_grows_m);
            let sigma_m = numbers.trail_sigma_m * (numbers.trail_scans * growth).sqrt();
            if self.see_from(before, h, far.d_m - near.d_m, sigma_m) {
                self.trail_points += 1;
            }
        });
    }

    /// A confirmed track is at a place of the course, and moves across it with `lateral_mps`.
    pub fn leave_trail(&mut self, id: u32, (sigma_m, d_m): (f64, f64), lateral_mps: f64) {
        if !self.sources.trails {
        } else if lateral_mps.abs() > self.numbers.trail_lateral_mps {
            self.trails.forget(id);
        } else {
            self.trails.leave(id, self.course.place(sigma_m, d_m));
        }
    }
}

/// Sets the covariance of the curvatures as before any measurement. Curves are `sharper` than at high speed.
fn forget_curvatures(state: &mut Gaussian<STATES>, numbers: &CourseNumbers, sharper: f64) {
    let variance = square(numbers.first_curvature_perm * sharper);
    for a in 1..STATES {
        (state.covariance[0][a], state.covariance[a][0]) = (0.0, 0.0);
        for b in 1..STATES {
            state.covariance[a][b] = variance * libm::pow(numbers.kept, a.abs_diff(b) as f64);
        }
    }
}

fn sum(weights: &[f64; STATES], state: &[f64; STATES]) -> f64 {
    (0..STATES).map(|i| weights[i] * state[i]).sum()
}

fn square(value: f64) -> f64 {
    value * value
}

#[cfg(test)]
mod exact_tests;
#[cfg(test)]
mod tests;
