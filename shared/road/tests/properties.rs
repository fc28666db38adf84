//! Properties of every road.

use proptest::prelude::*;
use road::random::{Recipe, pieces};
use road::{Axis, AxisError, AxisFault, Laid, MIN_RADIUS_M, Piece, Pose};

const RECIPE: Recipe =
    Recipe { length_m: 3e3, min_radius_m: 60.0, max_radius_m: 2e3, spiral_m: [30.0, 200.0] };

fn axis(pieces: &[Piece]) -> Axis {
    Axis::new(pieces).unwrap_or_else(|error| panic!("{error}: {pieces:?}"))
}

fn mirrored(piece: &Piece) -> Piece {
    match *piece {
        Piece::Line { .. } => *piece,
        Piece::Arc { length_m, curvature_perm } => {
            Piece::Arc { length_m, curvature_perm: -curvature_perm }
        }
        Piece::Spiral { length_m, start_perm, end_perm } => {
            Piece::Spiral { length_m, start_perm: -start_perm, end_perm: -end_perm }
        }
        Piece::Cubic { length_m, v } => Piece::Cubic { length_m, v: v.map(|c| -c) },
        Piece::ParamCubic { length_m, u, v, end } => {
            Piece::ParamCubic { length_m, u, v: v.map(|c| -c), end }
        }
    }
}

/// The pieces with the places where a chain has them, seen from a place in the plane.
fn laid(pieces: &[Piece], start: &Pose) -> Vec<Laid> {
    let chain = axis(pieces);
    let mut p_m = 0.0;
    let at = |piece: &Piece| {
        let start = chain.pose(p_m).placed(start);
        p_m += piece.length_m();
        Laid { start, piece: *piece }
    };
    pieces.iter().map(at).collect()
}

proptest! {
    #[test]
    fn a_point_is_found_again(seed in 0_u64..1000, share in -0.05..1.05, l_m in -20.0..20.0, off_m in -15.0..15.0) {
        let axis = axis(&pieces(&RECIPE, seed));
        let p_m = share * axis.length_m();
        let at = axis.point(p_m, l_m);
        let (back_m, left_m) = axis.project(at.x_m, at.y_m, p_m + off_m);
        prop_assert!((back_m - p_m).abs() < 1e-6 && (left_m - l_m).abs() < 1e-6, "{} {}", back_m - p_m, left_m - l_m);
        let (back_m, left_m) = axis.nearest(at.x_m, at.y_m);
        prop_assert!((back_m - p_m).abs() < 1e-6 && (left_m - l_m).abs() < 1e-6);
    }

    #[test]
    fn a_mirrored_road_is_the_mirrored_one_to_the_last_bit(seed in 0_u64..1000, share in 0.0..1.0, l_m in -9.0..9.0) {
        let road = pieces(&RECIPE, seed);
        let (left, right) = (axis(&road), axis(&road.iter().map(mirrored).collect::<Vec<_>>()));
        let p_m = share * left.length_m();
        let (a, b) = (left.point(p_m, l_m), right.point(p_m, -l_m));
        prop_assert_eq!((a.x_m, a.y_m, a.heading_rad), (b.x_m, -b.y_m, -b.heading_rad));
        let (a, b) = (left.project(a.x_m, a.y_m, p_m - 5.0), right.project(b.x_m, b.y_m, p_m - 5.0));
        prop_assert_eq!(a, (b.0, -b.1));
    }

    #[test]
    fn an_arc_of_a_million_kilometres_is_a_straight_line(p_m in 0.0..1000.0, l_m in -20.0..20.0, left: bool) {
        let curvature_perm = if left { 1e-9 } else { -1e-9 };
        let axis = axis(&[Piece::Arc { length_m: 1e3, curvature_perm }]);
        let at = axis.point(p_m, l_m);
        // The sagitta p²/2R of the arc itself is 0.5 mm at 1 km.
        prop_assert!((at.x_m - p_m).abs() < 1e-6 + 20.0 * p_m * 1e-9);
        prop_assert!((at.y_m - l_m - 0.5 * curvature_perm * p_m * p_m).abs() < 1e-6);
        let (back_m, left_m) = axis.project(p_m, l_m, p_m);
        prop_assert!((back_m - p_m).abs() < 1e-6 + 20.0 * p_m * 1e-9 && (left_m - l_m).abs() < 0.6e-3);
    }

    #[test]
    fn a_straight_road_gives_back_what_it_got(p_m in -1e5..1e5, l_m in -50.0..50.0, near_m in -1e5..1e5) {
        let axis = axis(&[Piece::Line { length_m: 300.0 }, Piece::Line { length_m: 0.1 }, Piece::Line { length_m: 7.3 }]);
        prop_assert!(axis.is_straight());
        prop_assert_eq!(axis.point(p_m, l_m), Pose { x_m: p_m, y_m: l_m, heading_rad: 0.0 });
        prop_assert_eq!(axis.project(p_m, l_m, near_m), (p_m, l_m));
        prop_assert_eq!((axis.curvature_perm(p_m), axis.curvature_rate_perm2(p_m)), (0.0, 0.0));
    }

    #[test]
    fn pieces_that_are_laid_make_the_same_road_wherever_it_lies(
        seed in 0_u64..100, x_m in -1e4..1e4, y_m in -1e4..1e4, heading_rad in -9.0..9.0, share in 0.0..1.0
    ) {
        let road = pieces(&RECIPE, seed);
        let chain = axis(&road);
        let moved = Axis::laid(&laid(&road, &Pose { x_m, y_m, heading_rad }), MIN_RADIUS_M).expect("no gaps");
        let p_m = share * chain.length_m();
        let (a, b) = (chain.pose(p_m), moved.pose(p_m));
        prop_assert!((a.x_m - b.x_m).abs().max((a.y_m - b.y_m).abs()) < 1e-7, "{a:?} {b:?}");
        prop_assert!((a.heading_rad - b.heading_rad).abs() < 1e-9);
    }

    #[test]
    fn a_reversed_road_has_the_same_points(
        seed in 0_u64..100, share in 0.0..1.0, l_m in -9.0..9.0, slope in -0.2..0.2, bend in -1e-3..1e-3,
        twist in -1e-5..1e-5
    ) {
        let mut road = pieces(&RECIPE, seed);
        road.insert(1, Piece::Cubic { length_m: 60.0, v: [0.3, slope, bend, twist] });
        let there = axis(&road);
        let back: Vec<Piece> = road.iter().rev().map(Piece::reversed).collect();
        let back = axis(&back);
        let (length_m, end) = (there.length_m(), there.pose(there.length_m()));
        let turned = Pose { heading_rad: end.heading_rad + std::f64::consts::PI, ..end };
        let p_m = share * length_m;
        let (a, b) = (there.point(p_m, l_m), back.point(length_m - p_m, -l_m).placed(&turned));
        prop_assert!((a.x_m - b.x_m).abs().max((a.y_m - b.y_m).abs()) < 1e-5, "{a:?} {b:?}");
    }

    #[test]
    fn no_numbers_make_a_road_that_is_not_finite(
        kinds in prop::collection::vec((0_u8..5, any::<[f64; 9]>(), any::<bool>()), 1..6), p_m in -10.0..1e4
    ) {
        let piece = |(kind, c, tame): &(u8, [f64; 9], bool)| {
            let c = if *tame { c.map(|c| libm::remainder(c, 0.04)) } else { *c };
            let length_m = if *tame { 20.0 } else { c[8] };
            match kind {
                0 => Piece::Line { length_m },
                1 => Piece::Arc { length_m, curvature_perm: c[0] },
                2 => Piece::Spiral { length_m, start_perm: c[0], end_perm: c[1] },
                3 => Piece::Cubic { length_m, v: [c[0], c[1], c[2], c[3]] },
                _ => Piece::ParamCubic { length_m, u: [c[0], 1.0, c[2], c[3]], v: [c[4], c[5], c[6], c[7]], end: 20.0 },
            }
        };
        if let Ok(axis) = Axis::new(&kinds.iter().map(piece).collect::<Vec<_>>()) {
            let at = axis.pose(p_m);
            prop_assert!(at.x_m.is_finite() && at.y_m.is_finite() && at.heading_rad.is_finite());
            let (p_m, l_m) = axis.nearest(at.x_m + 3.0, at.y_m - 2.0);
            prop_assert!(p_m.is_finite() && l_m.is_finite());
        }
    }
}

#[test]
fn a_road_that_cannot_be_driven_is_refused_with_its_piece() {
    let line = Piece::Line { length_m: 100.0 };
    let arc = |length_m, curvature_perm| Piece::Arc { length_m, curvature_perm };
    let refused = |pieces: &[Piece]| Axis::new(pieces).expect_err("no road");
    let of = |piece, fault| AxisError { piece, fault };
    assert_eq!(refused(&[]), of(0, AxisFault::Empty));
    assert_eq!(refused(&[line, arc(10.0, f64::NAN)]), of(1, AxisFault::NotFinite));
    assert_eq!(refused(&[line, arc(0.0, 0.0)]), of(1, AxisFault::Length(0.0)));
    assert_eq!(refused(&[arc(1.0, -0.1)]), of(0, AxisFault::Radius(10.0)));
    let narrow = Piece::Spiral { length_m: 9.0, start_perm: 0.0, end_perm: 0.1 };
    assert!(matches!(
        refused(&[line, narrow]),
        AxisError { piece: 1, fault: AxisFault::Radius(_) }
    ));
    let cusp =
        Piece::ParamCubic { length_m: 10.0, u: [0.0, 0.0, 10.0, 0.0], v: [0.0; 4], end: 1.0 };
    assert_eq!(refused(&[cusp]), of(0, AxisFault::Cusp));
    let long =
        Piece::ParamCubic { length_m: 12.0, u: [0.0, 10.0, 0.0, 0.0], v: [0.0; 4], end: 1.0 };
    assert!(matches!(refused(&[long]), AxisError { piece: 0, fault: AxisFault::Declared { .. } }));
    // A whole circle of 25 m radius meets itself after 157 m, one of 40 m after 251 m.
    assert!(matches!(
        refused(&[line, arc(170.0, 0.04)]),
        AxisError { piece: 1, fault: AxisFault::Crossing { .. } }
    ));
    assert!(Axis::new(&[line, arc(300.0, 0.025)]).is_ok());
}

#[test]
fn gaps_and_kinks_of_laid_pieces_are_refused() {
    let lines = |x_m, y_m, heading_rad| {
        let piece = Piece::Line { length_m: 10.0 };
        let start = Pose { x_m: 5.0, y_m: 5.0, heading_rad: 0.0 };
        Axis::laid(
            &[Laid { start, piece }, Laid { start: Pose { x_m, y_m, heading_rad }, piece }],
            MIN_RADIUS_M,
        )
    };
    assert!(lines(15.0, 5.0, 0.0).expect("no gap").is_straight());
    assert!(lines(15.0, 5.0, std::f64::consts::TAU).is_ok(), "headings are angles");
    assert!(
        matches!(lines(15.2, 5.0, 0.0), Err(AxisError { piece: 1, fault: AxisFault::Gap(gap_m) }) if (gap_m - 0.2).abs() < 1e-9)
    );
    assert!(matches!(
        lines(15.0, 5.0, 0.1),
        Err(AxisError { piece: 1, fault: AxisFault::Kink(_) })
    ));
}

#[test]
fn a_cubic_of_another_length_is_passed_evenly() {
    let straight =
        |length_m| Piece::ParamCubic { length_m, u: [0.0, 10.0, 0.0, 0.0], v: [0.0; 4], end: 1.0 };
    let axis = axis(&[straight(10.5), Piece::Line { length_m: 5.0 }]);
    assert!(
        (axis.pose(10.5).x_m - 10.0).abs() < 1e-12 && (axis.pose(12.5).x_m - 12.0).abs() < 1e-12
    );
    assert!((axis.pose(5.25).x_m - 5.0).abs() < 1e-12);
    let (p_m, _) = axis.project(5.0, 1.0, 0.0);
    assert!((p_m - 5.25).abs() < 1e-9);
}
