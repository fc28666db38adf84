//! The lanes of a road with a plan as lines in the plane.

use scenario::plan::{Plan, offset_at};
use serde::Serialize;

/// Largest distance of a line from its chords, m: less than a pixel of the close-up.
const SAGITTA_M: f64 = 0.03;
/// Shortest and longest chord, m.
const CHORD_M: (f64, f64) = (2.0, 60.0);

/// The lanes as lines in the plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadView {
    left: Line,
    right: Line,
    /// Lines between lanes.
    lines: Vec<Line>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct Line {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl RoadView {
    /// The lanes between two positions, m.
    pub fn of(plan: &Plan, from_to_m: (f64, f64)) -> Self {
        let (axis, start, lanes) = (plan.axis(), plan.start.pose(), &plan.lanes);
        let between = lanes.lines(from_to_m.0, from_to_m.1);
        let mut places_m = places(&|p_m| axis.curvature_perm(p_m), from_to_m);
        places_m.extend(between.iter().flatten().map(|point| point[0]));
        places_m.retain(|p_m| (from_to_m.0..=from_to_m.1).contains(p_m));
        places_m.sort_by(f64::total_cmp);
        places_m.dedup();
        let line = |offset_m: &dyn Fn(f64) -> f64, places_m: &mut dyn Iterator<Item = f64>| {
            let mut line = Line::default();
            for p_m in places_m {
                let pose = axis.point(p_m, offset_m(p_m)).placed(&start);
                line.x.push(rounded(pose.x_m));
                line.y.push(rounded(pose.y_m));
            }
            line
        };
        let all = || places_m.iter().copied();
        let edge = |side: usize| line(&|p_m| lanes.edges_m(p_m)[side], &mut all());
        // The first and the last line of a stretch are edges.
        let inner = between.iter().enumerate().filter(|(index, own)| {
            let is_neighbour =
                |other: Option<&Vec<[f64; 2]>>| other.is_some_and(|other| other[0][0] == own[0][0]);
            let before = index.checked_sub(1).and_then(|before| between.get(before));
            is_neighbour(before) && is_neighbour(between.get(index + 1))
        });
        let lines = inner.map(|(_, points)| {
            let (first_m, last_m) = (points[0][0], points[points.len() - 1][0]);
            let mut own = all().filter(|p_m| (first_m..=last_m).contains(p_m));
            line(&|p_m| offset_at(points, p_m), &mut own)
        });
        Self { left: edge(1), right: edge(0), lines: lines.collect() }
    }
}

/// Positions whose chords are near the axis: close together in curves, far apart on straights.
fn places(curvature: &dyn Fn(f64) -> f64, (from_m, to_m): (f64, f64)) -> Vec<f64> {
    let mut places = vec![from_m];
    let mut at_m = from_m;
    while at_m < to_m {
        let mut chord_m = CHORD_M.1;
        while chord_m > CHORD_M.0 {
            let bends =
                [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| curvature(at_m + share * chord_m).abs());
            let most_perm = bends.into_iter().fold(0.0, f64::max);
            if most_perm * chord_m * chord_m <= 8.0 * SAGITTA_M {
                break;
            }
            chord_m *= 0.8;
        }
        at_m = (at_m + chord_m.max(CHORD_M.0)).min(to_m);
        places.push(at_m);
    }
    places
}

/// To a centimetre, as a screen shows it.
pub fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// To a tenth of a milliradian.
pub fn fine(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_are_short_in_curves_alone() {
        let places_m = places(&|p_m| if p_m < 500.0 { 0.0 } else { 0.01 }, (0.0, 1_000.0));
        assert_eq!((places_m[0], places_m.last()), (0.0, Some(&1_000.0)));
        for pair in places_m.windows(2) {
            let chord_m = pair[1] - pair[0];
            assert!(chord_m <= CHORD_M.1);
            assert!(pair[1] <= 500.0 || 0.01 * chord_m.powi(2) <= 8.0 * SAGITTA_M + 1e-9);
        }
        assert!((100..200).contains(&places_m.len()), "{}", places_m.len());
    }
}
