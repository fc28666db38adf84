//! A grade profile: heights at points along the road, straight between them.

/// Steepest grade that is accepted, as a fraction: the steepest streets of the world have 0.35, the
/// steepest motorways 0.1.
pub const MAX_GRADE: f64 = 0.2;
/// Longest distance between two points that does not count as a gap in the data, m.
pub const MAX_SPACING_M: f64 = 500.0;
/// Most points of a profile.
pub const MAX_POINTS: usize = 20_000;

/// A point of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Distance along the road, m from the ego's start.
    pub distance_m: f64,
    /// Height, m.
    pub height_m: f64,
}

/// Reason why points are not a profile.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// A road has two ends.
    #[error("a road of one point")]
    OnePoint,
    /// More than [`MAX_POINTS`].
    #[error("a road of {0} points")]
    TooManyPoints(usize),
    /// A distance or a height is NaN or infinite.
    #[error("not a number")]
    NotANumber {
        /// Index of the point.
        index: usize,
    },
    /// A distance is not beyond the one before.
    #[error("distances must increase")]
    OutOfOrder {
        /// Index of the point.
        index: usize,
        /// Distance of the point before, m.
        before_m: f64,
    },
    /// The point is too far from the one before.
    #[error("a gap of {spacing_m:.0} m in the road")]
    Gap {
        /// Index of the point.
        index: usize,
        /// Distance from the point before, m.
        spacing_m: f64,
    },
    /// The way to the point is too steep.
    #[error("a grade of {:.1} %", 100.0 * grade)]
    TooSteep {
        /// Index of the point.
        index: usize,
        /// Grade from the point before.
        grade: f64,
    },
}

impl ProfileError {
    /// Index of the offending point.
    #[must_use]
    pub const fn index(&self) -> usize {
        match *self {
            Self::OnePoint => 0,
            Self::TooManyPoints(_) => MAX_POINTS,
            Self::NotANumber { index }
            | Self::OutOfOrder { index, .. }
            | Self::Gap { index, .. }
            | Self::TooSteep { index, .. } => index,
        }
    }

    /// Expected value.
    #[must_use]
    pub fn expected(&self) -> String {
        match self {
            Self::OnePoint => "at least two points".into(),
            Self::TooManyPoints(_) => format!("at most {MAX_POINTS}"),
            Self::NotANumber { .. } => "distance and height in m".into(),
            Self::OutOfOrder { before_m, .. } => format!("a distance of more than {before_m} m"),
            Self::Gap { .. } => format!("points at most {MAX_SPACING_M:.0} m apart"),
            Self::TooSteep { .. } => format!("at most {:.0} % up or down", 100.0 * MAX_GRADE),
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
        if points.len() == 1 {
            return Err(ProfileError::OnePoint);
        }
        if points.len() > MAX_POINTS {
            return Err(ProfileError::TooManyPoints(points.len()));
        }
        for (index, point) in points.iter().enumerate() {
            if !(point.distance_m.is_finite() && point.height_m.is_finite()) {
                return Err(ProfileError::NotANumber { index });
            }
            let Some(before) = index.checked_sub(1).map(|before| points[before]) else { continue };
            let spacing_m = point.distance_m - before.distance_m;
            if spacing_m <= 0.0 {
                return Err(ProfileError::OutOfOrder { index, before_m: before.distance_m });
            }
            if spacing_m > MAX_SPACING_M {
                return Err(ProfileError::Gap { index, spacing_m });
            }
            let grade = (point.height_m - before.height_m) / spacing_m;
            if grade.abs() > MAX_GRADE {
                return Err(ProfileError::TooSteep { index, grade });
            }
        }
        Ok(Self { points })
    }

    /// The points; none for a level road.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// End of the profile, m; 0 for a level road.
    #[must_use]
    pub fn end_m(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.distance_m)
    }

    /// Height at a distance, m.
    #[must_use]
    pub fn height_m(&self, distance_m: f64) -> f64 {
        let [Some(first), Some(last)] = [self.points.first(), self.points.last()] else {
            return 0.0;
        };
        match self.segment(distance_m) {
            Some([a, b]) => {
                let part = (distance_m - a.distance_m) / (b.distance_m - a.distance_m);
                a.height_m + part * (b.height_m - a.height_m)
            }
            None if distance_m < first.distance_m => first.height_m,
            None => last.height_m,
        }
    }

    /// Grade at a distance: rise over run, positive uphill. At a point it is that of what follows.
    #[must_use]
    pub fn grade(&self, distance_m: f64) -> f64 {
        self.segment(distance_m)
            .map_or(0.0, |[a, b]| (b.height_m - a.height_m) / (b.distance_m - a.distance_m))
    }

    /// Mean grade from one distance to another.
    #[must_use]
    pub fn mean_grade(&self, from_m: f64, to_m: f64) -> f64 {
        if to_m == from_m {
            return self.grade(from_m);
        }
        (self.height_m(to_m) - self.height_m(from_m)) / (to_m - from_m)
    }

    /// The two points around a distance.
    fn segment(&self, distance_m: f64) -> Option<[Point; 2]> {
        let after = self.points.partition_point(|point| point.distance_m <= distance_m);
        let before = after.checked_sub(1)?;
        Some([*self.points.get(before)?, *self.points.get(after)?])
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
            assert_eq!((fault.index(), fault.to_string().as_str()), (index, message));
        }
    }
}
