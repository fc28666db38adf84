//! Heights of a road and its grades, over the distance along it: points, straight between them.
//!
//! Plain data that every simulator of the environment agrees on: the plant feels the grade, the roadside unit announces
//! it.
//!
//! ```
//! use road::grade::{GradeProfile, Point};
//! let points = [(0.0, 0.0), (100.0, 3.0)].map(|(distance_m, height_m)| Point { distance_m, height_m });
//! let hill = GradeProfile::new(points.to_vec())?;
//! assert_eq!((hill.grade(50.0), hill.height_m(50.0), hill.grade(150.0)), (0.03, 1.5, 0.0));
//! # Ok::<(), road::grade::ProfileError>(())
//! ```

mod generator;

pub use generator::{Alignment, generate};

use crate::lines::around;

/// Steepest grade that is accepted, as a fraction: the steepest streets of the world have 0.35, the
/// steepest motorways 0.1.
pub const MAX_GRADE: f64 = 0.2;
/// Longest distance between two points that does not count as a gap in the data, m.
pub const MAX_SPACING_M: f64 = 500.0;
/// Most points of a profile.
pub const MAX_POINTS: usize = 20_000;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Distance along the road, m from the ego's start.
    pub distance_m: f64,
    pub height_m: f64,
}

/// Reason why points are not a profile.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{fault}")]
pub struct ProfileError {
    /// Index of the offending point.
    pub index: usize,
    pub fault: ProfileFault,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileFault {
    /// A road has two ends.
    #[error("a road of one point")]
    OnePoint,
    /// More than [`MAX_POINTS`].
    #[error("a road of {0} points")]
    TooManyPoints(usize),
    #[error("not a number")]
    NotANumber,
    /// A distance is not beyond the one before, m.
    #[error("distances must increase")]
    OutOfOrder(f64),
    /// The point is too far from the one before, m.
    #[error("a gap of {0:.0} m in the road")]
    Gap(f64),
    /// The way to the point is too steep: its grade.
    #[error("a grade of {:.1} %", 100.0 * .0)]
    TooSteep(f64),
}

impl ProfileError {
    pub fn expected(&self) -> String {
        match self.fault {
            ProfileFault::OnePoint => "at least two points".into(),
            ProfileFault::TooManyPoints(_) => format!("at most {MAX_POINTS}"),
            ProfileFault::NotANumber => "distance and height in m".into(),
            ProfileFault::OutOfOrder(before_m) => {
                format!("a distance of more than {before_m} m")
            }
            ProfileFault::Gap(_) => format!("points at most {MAX_SPACING_M:.0} m apart"),
            ProfileFault::TooSteep(_) => {
                format!("at most {:.0} % up or down", 100.0 * MAX_GRADE)
            }
        }
    }
}

/// Height and grade over distance. Beyond its ends the road is level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GradeProfile {
    /// Distances increase strictly; none or at least two.
    points: Vec<Point>,
}

impl GradeProfile {
    /// A profile through `points`, in order of distance.
    ///
    /// # Errors
    /// The first point that is not a number, out of order, after a gap, at the end of an absurd
    /// grade, or alone.
    pub fn new(points: Vec<Point>) -> Result<Self, ProfileError> {
        let refuse = |index, fault| Err(ProfileError { index, fault });
        if points.len() == 1 {
            return refuse(0, ProfileFault::OnePoint);
        }
        if points.len() > MAX_POINTS {
            return refuse(MAX_POINTS, ProfileFault::TooManyPoints(points.len()));
        }
        for (index, point) in points.iter().enumerate() {
            if !(point.distance_m.is_finite() && point.height_m.is_finite()) {
                return refuse(index, ProfileFault::NotANumber);
            }
            let Some(before) = index.checked_sub(1).map(|before| points[before]) else { continue };
            let spacing_m = point.distance_m - before.distance_m;
            if spacing_m <= 0.0 {
                return refuse(index, ProfileFault::OutOfOrder(before.distance_m));
            }
            if spacing_m > MAX_SPACING_M {
                return refuse(index, ProfileFault::Gap(spacing_m));
            }
            let grade = (point.height_m - before.height_m) / spacing_m;
            if grade.abs() > MAX_GRADE {
                return refuse(index, ProfileFault::TooSteep(grade));
            }
        }
        Ok(Self { points })
    }

    /// The points; none for a level road.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// End of the profile, m; 0 for a level road.
    pub fn end_m(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.distance_m)
    }

    pub fn height_m(&self, distance_m: f64) -> f64 {
        let around = around(&self.points, |point| point.distance_m, distance_m);
        around.map_or(0.0, |(a, b, part)| a.height_m + part * (b.height_m - a.height_m))
    }

    /// Grade at a distance: rise over run, positive uphill. At a point it is that of what follows.
    pub fn grade(&self, distance_m: f64) -> f64 {
        match around(&self.points, |point| point.distance_m, distance_m) {
            Some((a, b, _)) if b.distance_m > a.distance_m => {
                (b.height_m - a.height_m) / (b.distance_m - a.distance_m)
            }
            _ => 0.0,
        }
    }

    /// Mean grade from one distance to another.
    pub fn mean_grade(&self, from_m: f64, to_m: f64) -> f64 {
        if to_m == from_m {
            return self.grade(from_m);
        }
        (self.height_m(to_m) - self.height_m(from_m)) / (to_m - from_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[(f64, f64)]) -> Vec<Point> {
        list.iter().map(|&(distance_m, height_m)| Point { distance_m, height_m }).collect()
    }

    #[test]
    fn heights_are_straight_between_points_and_level_beyond_them() {
        let road = GradeProfile::new(points(&[(100.0, 5.0), (200.0, 8.0), (300.0, 6.0)]));
        let road = road.expect("a right road");
        assert_eq!(
            [0.0, 100.0, 150.0, 250.0, 400.0].map(|x| road.height_m(x)),
            [5.0, 5.0, 6.5, 7.0, 6.0]
        );
        assert_eq!(
            [99.0, 100.0, 199.0, 200.0, 300.0].map(|x| road.grade(x)),
            [0.0, 0.03, 0.03, -0.02, 0.0]
        );
        assert_eq!(road.mean_grade(100.0, 300.0), 0.005);
        assert_eq!(road.mean_grade(150.0, 150.0), 0.03);
        assert_eq!(road.end_m(), 300.0);
        let level = GradeProfile::default();
        assert_eq!(level.grade(5.0) + level.height_m(5.0), 0.0);
    }

    #[test]
    fn an_invalid_road_is_refused_at_its_place() {
        let cases = [
            (&[(0.0, 0.0)][..], 0, "a road of one point"),
            (&[(0.0, 0.0), (0.0, 1.0)], 1, "distances must increase"),
            (&[(0.0, 0.0), (50.0, 1.0), (40.0, 1.0)], 2, "distances must increase"),
            (&[(0.0, 0.0), (900.0, 1.0)], 1, "a gap of 900 m in the road"),
            (&[(0.0, 0.0), (50.0, -20.0)], 1, "a grade of -40.0 %"),
            (&[(0.0, 0.0), (50.0, f64::NAN)], 1, "not a number"),
            (&[(f64::INFINITY, 0.0), (50.0, 1.0)], 0, "not a number"),
        ];
        for (list, index, message) in cases {
            let fault = GradeProfile::new(points(list)).expect_err("no road");
            assert_eq!((fault.index, fault.to_string().as_str()), (index, message));
        }
    }
}
