//! Measurement of one vehicle by all its detections in one scan.

use super::association::Point;
use super::longitudinal::Measured;
use super::numbers::Numbers;

/// The detections of one vehicle in one scan, gathered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sighting {
    /// The vehicle, if the radar knows it.
    pub(super) vehicle: Option<usize>,
    count: u32,
    pub(super) farthest_m: f64,
    pub(super) nearest: usize,
    range_weight: f64,
    range_moment: f64,
    rate_weight: f64,
    rate_moment: f64,
    pub(super) right_m: f64,
    pub(super) left_m: f64,
    rear_count: u32,
    lateral_variance: f64,
    /// Mean speed over ground along the line of sight, m/s.
    pub(super) ground_mps: f64,
}

impl Sighting {
    /// Gathers points that belong together; `lateral_mps` is the vehicle's lateral speed.
    pub fn of<'a>(
        points: impl Iterator<Item = &'a Point> + Clone,
        lateral_mps: f64,
        numbers: &Numbers,
    ) -> Option<Self> {
        let nearest = points.clone().min_by(|a, b| a.x_m.total_cmp(&b.x_m))?;
        let mut sighting = Self {
            vehicle: nearest.vehicle,
            nearest: nearest.detection,
            right_m: f64::INFINITY,
            left_m: f64::NEG_INFINITY,
            ..Self::default()
        };
        for point in points {
            sighting.count += 1;
            sighting.farthest_m = sighting.farthest_m.max(point.x_m);
            sighting.ground_mps += point.ground_speed_mps;
            let weight = 1.0 / point.range_rate_variance;
            sighting.rate_weight += weight;
            sighting.rate_moment += weight * point.relative_speed_mps(lateral_mps);
            let noise_m = numbers.surely_sigma * point.range_variance.sqrt();
            let depth_m = numbers.rear_depth_m + noise_m;
            if point.x_m - nearest.x_m <= depth_m {
                let weight = 1.0 / point.range_variance;
                sighting.range_weight += weight;
                sighting.range_moment += weight * point.x_m;
                sighting.right_m = sighting.right_m.min(point.y_m - point.half_width_m);
                sighting.left_m = sighting.left_m.max(point.y_m + point.half_width_m);
                sighting.lateral_variance += point.lateral_variance;
                sighting.rear_count += 1;
            }
        }
        sighting.ground_mps /= f64::from(sighting.count);
        Some(sighting)
    }

    /// Distance of the rear.
    pub(super) fn range(&self, numbers: &Numbers) -> Measured {
        let value = self.range_moment / self.range_weight;
        Measured { value, variance: 1.0 / self.range_weight + square(numbers.rear_sigma_m) }
    }

    /// Speed relative to the ego.
    pub(super) fn relative_speed(&self) -> Measured {
        Measured { value: self.rate_moment / self.rate_weight, variance: 1.0 / self.rate_weight }
    }

    /// Lateral position of the centre of a rear of the given width.
    pub(super) fn lateral(&self, width_m: f64, numbers: &Numbers) -> Measured {
        let count = f64::from(self.rear_count);
        // Part of the rear without an echo.
        let hidden_m = (width_m - (self.left_m - self.right_m)).max(0.0);
        let body = numbers.middle_share * hidden_m * hidden_m / 12.0;
        // The outermost two of several points decide.
        let variance = self.lateral_variance / (count * count.min(2.0)) + body;
        Measured { value: 0.5 * (self.left_m + self.right_m), variance }
    }

    /// Lateral position of the centre of a vehicle of which the inner side is seen.
    pub(super) fn lateral_by_side(&self, width_m: f64, side: f64, numbers: &Numbers) -> Measured {
        let inner_m = if side > 0.0 { self.right_m } else { self.left_m };
        let variance =
            self.lateral_variance / f64::from(self.rear_count) + square(numbers.side_sigma_m);
        Measured { value: inner_m + 0.5 * width_m * side, variance }
    }
}

fn square(value: f64) -> f64 {
    value * value
}

#[cfg(test)]
mod tests {
    use super::super::association::tests::point;
    use super::*;

    const NUMBERS: Numbers = Numbers::DEFAULT;

    /// Two points of a rear, at 2.0 and 3.2 m to the left.
    fn seen() -> Sighting {
        Sighting {
            range_weight: 50.0,
            range_moment: 2000.0,
            rate_weight: 400.0,
            rate_moment: -1200.0,
            right_m: 2.0,
            left_m: 3.2,
            rear_count: 2,
            lateral_variance: 0.08,
            ..Sighting::default()
        }
    }

    #[track_caller]
    fn assert_measured(found: Measured, value: f64, variance: f64) {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(found.value, value) && near(found.variance, variance), "{found:?}");
    }

    #[test]
    fn the_rear_is_measured_by_its_own_points_and_the_speed_by_all() {
        let points = [point(40.0, 2.0, -3.0), point(40.2, 3.2, -2.0), point(44.0, 1.0, -1.0)];
        let seen = Sighting::of(points.iter(), 0.0, &NUMBERS).expect("points");
        assert_measured(seen.range(&NUMBERS), 40.1, 0.005 + 0.1 * 0.1);
        assert_measured(seen.relative_speed(), -2.0, 0.01 / 3.0);
        assert_eq!((seen.right_m, seen.left_m, seen.farthest_m), (2.0, 3.2, 44.0));
        assert_measured(seen.lateral(1.2, &NUMBERS), 2.6, 0.08 / 4.0);
        assert!((seen.ground_mps - 18.0).abs() < 1e-12);
        // The rear is 0.8 m deep, and three deviations of the range deeper.
        let deep = [point(40.0, 0.0, 0.0), point(41.0, 0.0, 0.0)];
        let seen = Sighting::of(deep.iter(), 0.0, &NUMBERS).expect("points");
        assert_measured(seen.range(&NUMBERS), 40.5, 0.005 + 0.1 * 0.1);
        let deeper = [point(40.0, 0.0, 0.0), point(41.2, 0.0, 0.0)];
        let seen = Sighting::of(deeper.iter(), 0.0, &NUMBERS).expect("points");
        assert_measured(seen.range(&NUMBERS), 40.0, 0.01 + 0.1 * 0.1);
        assert!(Sighting::of([].iter(), 0.0, &NUMBERS).is_none());
    }

    #[test]
    fn a_lateral_speed_is_no_part_of_the_relative_speed() {
        let aside = Point { direction: (0.8, 0.6), ..point(30.0, 22.5, -2.0) };
        let seen = Sighting::of([aside].iter(), 1.0, &NUMBERS).expect("a point");
        assert_measured(seen.relative_speed(), -3.25, 0.01);
        // Nearly square to the road the speed is not divided by nothing.
        let square = Point { direction: (0.05, 1.0), ..point(1.0, 20.0, -0.5) };
        assert_eq!(square.relative_speed_mps(0.0), -5.0);
    }

    #[test]
    fn range_and_rate_are_weighted_means_that_no_number_of_points_makes_exact() {
        assert_measured(seen().range(&NUMBERS), 40.0, 0.02 + 0.1 * 0.1);
        assert_measured(seen().relative_speed(), -3.0, 0.0025);
    }

    #[test]
    fn a_middle_is_between_its_outermost_points_and_as_sure_as_little_is_hidden() {
        // 0.6 m of a rear of 1.8 m are without an echo.
        let hidden = 0.4 * 0.6 * 0.6 / 12.0;
        assert_measured(seen().lateral(1.8, &NUMBERS), 2.6, 0.08 / 4.0 + hidden);
        assert_measured(seen().lateral(1.0, &NUMBERS), 2.6, 0.02);
        let four = Sighting { rear_count: 4, ..seen() };
        assert_measured(four.lateral(1.0, &NUMBERS), 2.6, 0.08 / 8.0);
    }
}
