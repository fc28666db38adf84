//! The ego's way ahead: along the road that perception believes in, or on the circle that the ego drives.
//!
//! The circle's curvature is
//!
//! ```text
//! κ = r / v          r: yaw rate, rad/s; v: speed, m/s
//! ```
//!
//! behind a low-pass of [`LAG_S`]. Below [`SLOWEST_MPS`] the quotient is worthless: the curvature stays as it was. The
//! body does not point along the way of its bumper. It turns about its rear axle, and the tyres slip. The way's heading
//! there is κ (l - k v²). l is the distance from the bumper to the rear axle. k is the slip of the rear tyres per lateral
//! acceleration ([`Way::new`]).
//!
//! The circle checks the belief. An ego that stays on its road turns as much as the road does, but not at once: a driver
//! follows a bend late and makes up for it. So the curvatures of course and circle are compared by the mean of their
//! difference over [`MEMORY_S`]. Without a course that is young and of use, and with one that contradicts, the way is the
//! circle.

use crate::corridor::{Corridor, seen_turned};
use messages::{COURSE_CELL_M, COURSE_CELLS, Course};

/// Time constant of the curvature's low-pass, s. Chosen: five samples of the sensor. Its noise of 0.1 °/s would be 3 cm
/// at the last point to brake. A curve that begins or ends must show at once.
const LAG_S: f64 = 0.05;
/// Speed below which a yaw rate does not show a curvature, m/s. Chosen: 0.1 °/s of offset is 1/1,700 m there.
const SLOWEST_MPS: f64 = 3.0;
/// Standard deviation of the road's curvature around that of the circle, 1/m. Chosen: the driver's own steering (0.2 m
/// of wander in 3 s), and a yaw rate that is off by 0.1 °/s.
const SIGMA_PERM: f64 = 3e-4;
/// Time over which ego and road turn alike, s. Chosen: a driver corrects an offset in the lane within it.
const MEMORY_S: f64 = 2.0;
/// Standard deviations by which their curvatures may differ in the mean.
const GATE: f64 = 3.0;

/// The way ahead. The default is that of a straight road.
#[derive(Clone, Debug, Default)]
pub struct Way {
    bumper_m: f64,
    slip_rad_per_mps2: f64,
    /// The road may have curves.
    pub(crate) is_curved: bool,
    curvature_perm: f64,
    yaw_rate_radps: f64,
    speed_mps: f64,
    last_ns: Option<i64>,
    /// Time of the last scan, ns.
    scan_ns: Option<i64>,
    /// Mean curvature of the course less that of the circle, 1/m.
    differs_perm: f64,
    pub corridor: Corridor,
}

impl Way {
    /// The way of a car on a road with curves, before its first yaw rate. Its front bumper is `bumper_m` ahead of the
    /// rear axle (0: the body points along its way). The rear tyres slip by an angle per lateral acceleration.
    pub fn new(bumper_m: f64, slip_rad_per_mps2: f64) -> Self {
        let mut way = Self { bumper_m, slip_rad_per_mps2, is_curved: true, ..Self::default() };
        way.corridor = way.circle();
        way
    }

    /// Takes the yaw rate that was acquired at `acquired_ns` by an ego of `speed_mps`. A sample that is not later than
    /// the last one, or that is not a number, is passed over.
    pub fn take(&mut self, acquired_ns: i64, yaw_rate_radps: f64, speed_mps: f64) {
        let elapsed_ns = self.last_ns.map_or(i64::MAX, |last_ns| acquired_ns - last_ns);
        if elapsed_ns <= 0 || !yaw_rate_radps.is_finite() || !speed_mps.is_finite() {
            return;
        }
        self.last_ns = Some(acquired_ns);
        (self.yaw_rate_radps, self.speed_mps) = (yaw_rate_radps, speed_mps);
        if speed_mps < SLOWEST_MPS {
            return;
        }
        let gain = 1.0 - libm::exp(-1e-9 * elapsed_ns as f64 / LAG_S);
        self.curvature_perm += gain * (yaw_rate_radps / speed_mps - self.curvature_perm);
    }

    /// Chooses the corridor of the scan at `scan_ns`, by the newest course that is no older than `stale_ns`.
    pub fn look(&mut self, scan_ns: i64, course: Option<&Course>, stale_ns: i64) {
        if !self.is_curved {
            return;
        }
        let period_s =
            self.scan_ns.replace(scan_ns).map_or(0.0, |last| 1e-9 * (scan_ns - last) as f64);
        self.corridor = self.circle();
        let age_ns = |course: &&Course| scan_ns - course.header.acquisition_ns;
        let Some(course) = course.filter(|course| is_of_use(course) && age_ns(course) <= stale_ns)
        else {
            return;
        };
        let age_s = 1e-9 * age_ns(&course).max(0) as f64;
        let driven_m = self.speed_mps * age_s;
        let cell = ((driven_m / COURSE_CELL_M) as usize).min(COURSE_CELLS - 1);
        // Most last points to brake are some 50 m ahead.
        let spread_perm = 2.0 * course.sigma_50_m / (50.0 * 50.0);
        let here_perm = course.curvatures_perm[cell];
        let off_perm = here_perm - self.curvature_perm;
        self.differs_perm += (period_s / MEMORY_S).min(1.0) * (off_perm - self.differs_perm);
        let sigma_perm = libm::hypot(SIGMA_PERM, spread_perm);
        if self.differs_perm.abs() <= GATE * sigma_perm {
            // The road turns on the way as its cells say, and the body by its yaw rate.
            let turned_rad = here_perm * driven_m - self.yaw_rate_radps * age_s;
            let heading_rad = course.heading_rad + turned_rad;
            self.corridor =
                Corridor::of_cells(&course.curvatures_perm, driven_m, heading_rad, spread_perm);
        }
    }

    /// A point of the body as seen when the ego has driven on for `time_s` with `ego_mps`.
    pub(crate) fn passed(&self, (x_m, y_m): (f64, f64), ego_mps: f64, time_s: f64) -> (f64, f64) {
        let turn_rad = self.yaw_rate_radps * time_s;
        // A chord has the heading of half of its turn.
        let chord_rad = self.heading_rad() + 0.5 * turn_rad;
        let (driven_m, aside_m) = seen_turned((ego_mps * time_s, 0.0), -chord_rad);
        seen_turned((x_m - driven_m, y_m - aside_m), turn_rad)
    }

    fn heading_rad(&self) -> f64 {
        let lever_m = self.bumper_m - self.slip_rad_per_mps2 * self.speed_mps * self.speed_mps;
        self.curvature_perm * lever_m
    }

    fn circle(&self) -> Corridor {
        Corridor::circle(self.curvature_perm, self.heading_rad(), SIGMA_PERM)
    }
}

/// The course is one, and all of it are numbers.
fn is_of_use(course: &Course) -> bool {
    let spread = [course.sigma_50_m, course.sigma_100_m];
    let numbers = course.curvatures_perm.iter().chain(&spread).chain([&course.heading_rad]);
    course.valid_m > 0.0 && spread[0] > 0.0 && numbers.copied().all(f64::is_finite)
}

#[cfg(test)]
mod tests;
