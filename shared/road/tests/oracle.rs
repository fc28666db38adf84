//! Roads of our own against tables of pyclothoids and scipy: `oracle/oracle.py` makes them.

use road::{Axis, Piece};

/// Largest distance from the oracle, m.
const TOLERANCE_M: f64 = 1e-3;
/// Largest difference of the heading, rad.
const TOLERANCE_RAD: f64 = 1e-5;

/// The lines of a table behind its head, with their numbers; an empty field is 0.
fn lines(text: &str) -> Vec<(usize, Vec<&str>)> {
    let fields = |line: &'static str| line.split(',').collect::<Vec<_>>();
    let leaked: &'static str = Box::leak(text.to_owned().into_boxed_str());
    let line = |line| {
        let fields = fields(line);
        (fields[0].parse().expect("a road"), fields)
    };
    leaked.lines().skip(1).map(line).collect()
}

fn number(text: &str) -> f64 {
    if text.is_empty() { 0.0 } else { text.parse().expect("a number") }
}

fn piece(fields: &[&str]) -> Piece {
    let length_m = number(fields[2]);
    let c: Vec<f64> = fields[3..].iter().map(|field| number(field)).collect();
    match fields[1] {
        "line" => Piece::Line { length_m },
        "arc" => Piece::Arc { length_m, curvature_perm: c[0] },
        "spiral" => Piece::Spiral { length_m, start_perm: c[0], end_perm: c[1] },
        "cubic" => Piece::Cubic { length_m, v: [c[0], c[1], c[2], c[3]] },
        "param-cubic" => Piece::ParamCubic {
            length_m,
            u: [c[0], c[1], c[2], c[3]],
            v: [c[4], c[5], c[6], c[7]],
            end: c[8],
        },
        other => panic!("{other}"),
    }
}

#[test]
fn axes_agree_with_other_libraries() {
    let mut roads: Vec<Vec<Piece>> = Vec::new();
    for (road, fields) in lines(include_str!("oracle/pieces.csv")) {
        roads.resize(roads.len().max(road + 1), Vec::new());
        roads[road].push(piece(&fields));
    }
    let axes: Vec<Axis> = roads
        .iter()
        .enumerate()
        .map(|(road, pieces)| {
            Axis::new(pieces).unwrap_or_else(|e| panic!("road {road}: {e} {pieces:?}"))
        })
        .collect();
    assert_eq!(axes.len(), 220);
    let (mut worst_m, mut worst_rad, mut worst_back_m) = (0.0_f64, 0.0_f64, 0.0_f64);
    let points = lines(include_str!("oracle/points.csv"));
    for (road, fields) in &points {
        let [p_m, l_m, x_m, y_m, heading_rad] = [1, 2, 3, 4, 5].map(|i| number(fields[i]));
        let axis = &axes[*road];
        let at = axis.point(p_m, l_m);
        worst_m = worst_m.max((at.x_m - x_m).hypot(at.y_m - y_m));
        let turn = libm::remainder(at.heading_rad - heading_rad, std::f64::consts::TAU);
        worst_rad = worst_rad.max(turn.abs());
        let (back_p_m, back_l_m) = axis.project(at.x_m, at.y_m, p_m - 7.0);
        worst_back_m = worst_back_m.max((back_p_m - p_m).abs()).max((back_l_m - l_m).abs());
    }
    println!(
        "{} points: {worst_m:.1e} m, {worst_rad:.1e} rad, back {worst_back_m:.1e} m",
        points.len()
    );
    assert!(worst_m < TOLERANCE_M && worst_rad < TOLERANCE_RAD, "{worst_m} m, {worst_rad} rad");
    assert!(worst_back_m < 1e-6, "projection back: {worst_back_m} m");
}
