//! A line of points as a chain of lines and arcs.
//!
//! Shapes of SUMO have kinks, which its vehicles pass at full speed. A car cannot. So the points are taken at even
//! distances, and each is replaced by the mean of its neighbourhood. Straights stay as they are. A right angle becomes a
//! curve of some 2 m radius that leaves the points by at most a metre. A narrower turn makes the neighbourhood wider. Each corner that is left becomes an arc.

use road::{Piece, Pose};

use crate::line::{Line, distance};

/// Distance between two points, m.
const SPACING_M: f64 = 0.75;
/// Points on either side that a mean takes in: more where a turn is too narrow otherwise.
const BESIDE: [usize; 6] = [4, 6, 8, 11, 15, 20];
/// Curvature up to which a turn is wide enough, 1/m.
const WIDE_PERM: f64 = 1.0 / 1.5;
/// Turn below which a line goes straight on, rad.
const STRAIGHT_RAD: f64 = 1e-7;
/// Shortest line between two arcs, m.
const SHORTEST_M: f64 = 1e-6;

/// The chain, and where it is for each way along the points.
pub struct Smooth {
    pub pieces: Vec<Piece>,
    /// Beginning of the chain in the plane of the points.
    pub start: Pose,
    /// Ways along the points with the places on the chain, m.
    places: Vec<[f64; 2]>,
}

impl Smooth {
    /// The chain along points. Two neighbours are never the same point.
    pub fn of(points: &[[f64; 2]]) -> Self {
        let (ways, even) = evenly(points);
        let is_narrow = |piece: &Piece| matches!(piece, Piece::Arc { curvature_perm: c, .. } if c.abs() > WIDE_PERM);
        let with = |beside| Self::through(&averaged(&even, beside), &ways);
        let found =
            BESIDE.into_iter().map(with).find(|smooth| !smooth.pieces.iter().any(is_narrow));
        found.unwrap_or_else(|| with(BESIDE[BESIDE.len() - 1]))
    }

    /// The chain through points at these ways.
    fn through(means: &[[f64; 2]], ways: &[f64]) -> Self {
        let kept = corners(means);
        let (mut pieces, mut places) = (Vec::new(), vec![[0.0, 0.0]]);
        let (mut length_m, mut cut_m) = (0.0, 0.0);
        for (place, pair) in kept.windows(2).enumerate() {
            let (from, to) = (means[pair[0]], means[pair[1]]);
            let way_m = distance(from, to);
            // At the end there is no turn.
            let (tangent_m, turn) = kept.get(place + 2).map_or((0.0, 0.0), |after| {
                let next_m = distance(to, means[*after]);
                (0.5 * way_m.min(next_m), turn(from, to, means[*after]))
            });
            let line_m = way_m - cut_m - tangent_m;
            if line_m > SHORTEST_M {
                pieces.push(Piece::Line { length_m: line_m });
                length_m += line_m;
            }
            let radius_m = tangent_m / libm::tan(0.5 * turn.abs()).max(1e-12);
            let arc_m = radius_m * turn.abs();
            if arc_m > 0.0 {
                let curvature_perm = turn.signum() / radius_m;
                pieces.push(Piece::Arc { length_m: arc_m, curvature_perm });
            }
            places.push([ways[pair[1]], length_m + 0.5 * arc_m]);
            length_m += arc_m;
            cut_m = tangent_m;
        }
        let heading_rad = heading(means[kept[0]], means[kept[1]]);
        let start = Pose { x_m: means[0][0], y_m: means[0][1], heading_rad };
        Self { pieces, start, places }
    }

    /// The place on the chain after a way along the points, m.
    pub fn place_m(&self, way_m: f64) -> f64 {
        road::offset_at(&self.places, way_m)
    }
}

/// Points at even distances along a line of points, with their ways along it.
fn evenly(points: &[[f64; 2]]) -> (Vec<f64>, Vec<[f64; 2]>) {
    let line = Line::of(points);
    let count = libm::ceil(line.length_m() / SPACING_M).max(2.0);
    let way_m = |k: u32| line.length_m() * (f64::from(k) / count);
    (0..=count as u32).map(|k| (way_m(k), line.at(way_m(k)))).unzip()
}

/// Each point as the mean of its neighbourhood; the ends stay.
fn averaged(points: &[[f64; 2]], most: usize) -> Vec<[f64; 2]> {
    let mean = |index: usize| {
        let beside = most.min(index).min(points.len() - 1 - index);
        let near = &points[index - beside..=index + beside];
        [0, 1].map(|axis| {
            // About the point itself, so that a straight keeps its digits.
            let off: f64 = near.iter().map(|point| point[axis] - points[index][axis]).sum();
            points[index][axis] + off / near.len() as f64
        })
    };
    (0..points.len()).map(mean).collect()
}

/// Indices of the ends and of the points at which the line turns.
fn corners(points: &[[f64; 2]]) -> Vec<usize> {
    let mut kept = vec![0];
    for index in 1..points.len() - 1 {
        let before = kept[kept.len() - 1];
        if turn(points[before], points[index], points[index + 1]).abs() > STRAIGHT_RAD {
            kept.push(index);
        }
    }
    kept.push(points.len() - 1);
    kept
}

fn heading(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::atan2(b[1] - a[1], b[0] - a[0])
}

/// The turn at `b`, rad, left positive.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    libm::remainder(heading(b, c) - heading(a, b), std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(points: &[[f64; 2]]) -> (Smooth, road::Axis) {
        let smooth = Smooth::of(points);
        let axis = road::Axis::narrow(&smooth.pieces, 1.0).expect("an axis");
        (smooth, axis)
    }

    #[test]
    fn a_straight_stays_one_line() {
        let (smooth, axis) = axis(&[[10.0, 5.0], [60.0, 5.0], [210.0, 5.0]]);
        assert_eq!(smooth.pieces.len(), 1);
        assert!((axis.length_m() - 200.0).abs() < 1e-9);
        assert!((smooth.place_m(50.0) - 50.0).abs() < 1e-9);
    }

    #[test]
    fn a_right_angle_becomes_a_curve_that_a_car_can_drive() {
        let points = [[0.0, 0.0], [50.0, 0.0], [50.0, 50.0]];
        let (smooth, axis) = axis(&points);
        let curvatures = (0..1000).map(|k| axis.curvature_perm(0.1 * f64::from(k)));
        let sharpest = curvatures.fold(0.0, f64::max);
        assert!((0.2..0.6).contains(&sharpest), "{sharpest}");
        let end = axis.pose(axis.length_m()).placed(&smooth.start);
        assert!(libm::hypot(end.x_m - 50.0, end.y_m - 50.0) < 1e-6, "{end:?}");
        assert!((end.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-6);
        let corner = axis.pose(smooth.place_m(50.0)).placed(&smooth.start);
        assert!(libm::hypot(corner.x_m - 50.0, corner.y_m) < 1.3, "{corner:?}");
    }

    #[test]
    fn no_point_of_a_long_way_with_many_kinks_drifts_off() {
        let mut points = vec![[0.0, 0.0]];
        for k in 1..200 {
            let angle = 0.4 * libm::sin(f64::from(k));
            let [x, y]: [f64; 2] = points[points.len() - 1];
            points.push([x + 20.0 * libm::cos(angle), y + 20.0 * libm::sin(angle)]);
        }
        let (smooth, axis) = axis(&points);
        let mut way_m = 0.0;
        for pair in points.windows(2) {
            way_m += distance(pair[0], pair[1]);
            let at = axis.pose(smooth.place_m(way_m)).placed(&smooth.start);
            assert!(libm::hypot(at.x_m - pair[1][0], at.y_m - pair[1][1]) < 0.7);
        }
    }
}
