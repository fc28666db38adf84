//! Places on a circle and on a chain of arcs, computed by hand.

use super::*;
use proptest::prelude::*;

fn circle(radius_m: f64, heading_rad: f64) -> Corridor {
    Corridor::circle(1.0 / radius_m, heading_rad, 0.0)
}

#[test]
fn a_straight_way_is_the_body_itself() {
    let straight = Corridor::default();
    for (x_m, y_m) in [(0.0, 0.0), (60.0, -3.5), (-3.0, 1.75), (1e-9, 5.0)] {
        assert_eq!(straight.to_way(x_m, y_m).0, (x_m, y_m));
        assert_eq!(straight.to_body(x_m, y_m), (x_m, y_m));
    }
}

#[test]
fn a_quarter_of_a_circle_is_where_it_is_by_hand() {
    let left = circle(100.0, 0.0);
    let quarter_m = 50.0 * std::f64::consts::PI;
    let ((along_m, off_m), _) = left.to_way(100.0, 100.0);
    assert!((along_m - quarter_m).abs() < 1e-9 && off_m.abs() < 1e-9, "{along_m} {off_m}");
    // Five metres nearer to the centre is five to the left.
    let ((along_m, off_m), _) = left.to_way(95.0, 100.0);
    assert!((along_m - quarter_m).abs() < 1e-9 && (off_m - 5.0).abs() < 1e-9);
    let (x_m, y_m) = circle(-100.0, 0.0).to_body(quarter_m, 5.0);
    assert!((x_m - 105.0).abs() < 1e-9 && (y_m + 100.0).abs() < 1e-9, "{x_m} {y_m}");
}

#[test]
fn a_lead_of_a_curve_is_far_beside_the_body_and_on_the_way() {
    let left = circle(250.0, 0.0);
    // The chord of 60 m: 2 R sin(σ / 2 R) in the direction σ / 2 R.
    let (range_m, azimuth_rad) = (500.0 * libm::sin(60.0 / 500.0), 60.0 / 500.0);
    let (y_m, x_m) = libm::sincos(azimuth_rad);
    let ((along_m, off_m), _) = left.to_way(range_m * x_m, range_m * y_m);
    assert!(range_m * y_m > 7.0);
    assert!((along_m - 60.0).abs() < 1e-9 && off_m.abs() < 1e-9, "{along_m} {off_m}");
    assert!((left.heading_rad(60.0) - 0.24).abs() < 1e-12);
}

#[test]
fn a_body_that_points_outwards_sees_its_way_turned() {
    let turned = circle(125.0, 0.016);
    let ((_, off_m), _) = circle(125.0, 0.0).to_way(60.0, 0.0);
    let ((_, turned_off_m), _) = turned.to_way(60.0, 0.0);
    // By 60 m times 0.016 rad, a little less for the bend.
    assert!((off_m - turned_off_m - 0.96).abs() < 0.15, "{off_m} {turned_off_m}");
}

proptest! {
    #[test]
    fn a_place_on_the_way_comes_back(
        radius in 20.0..3000.0_f64, left in proptest::bool::ANY, share in -0.2..1.5_f64,
        off in -12.0..12.0_f64, heading in -0.05..0.05_f64,
    ) {
        let circle = circle(if left { radius } else { -radius }, heading);
        let along_m = (share * radius).clamp(-30.0, 150.0);
        let (x_m, y_m) = circle.to_body(along_m, off);
        let ((back_m, off_m), _) = circle.to_way(x_m, y_m);
        prop_assert!((back_m - along_m).abs() < 1e-8, "{} {}", back_m, along_m);
        prop_assert!((off_m - off).abs() < 1e-8, "{} {}", off_m, off);
    }

    #[test]
    fn a_huge_radius_is_straight(x in -10.0..150.0_f64, y in -12.0..12.0_f64) {
        let ((along_m, off_m), _) = circle(1e9, 0.0).to_way(x, y);
        prop_assert!((along_m - x).abs() < 1e-4 && (off_m - y).abs() < 1e-4);
    }

    #[test]
    fn a_mirrored_world_is_mirrored(
        radius in 50.0..3000.0_f64, x in 0.0..120.0_f64, y in -12.0..12.0_f64,
        heading in -0.05..0.05_f64,
    ) {
        let ((along_m, off_m), _) = circle(radius, heading).to_way(x, y);
        let (mirrored, _) = circle(-radius, -heading).to_way(x, -y);
        prop_assert_eq!(mirrored, (along_m, -off_m));
    }
}

/// A straight of 30 m before an arc of 100 m radius to the left, from an ego that has driven `driven_m` of it.
fn straight_and_arc(driven_m: f64) -> Corridor {
    let cells = std::array::from_fn(|cell| if cell < 3 { 0.0 } else { 0.01 });
    Corridor::of_cells(&cells, driven_m, 0.0, 0.0)
}

#[test]
fn a_chain_of_arcs_goes_on_where_the_last_one_ended() {
    for driven_m in [0.0, 4.0, 10.0, 25.0] {
        let corridor = straight_and_arc(driven_m);
        let straight_m = 30.0 - driven_m;
        assert_eq!(corridor.to_way(5.0 - driven_m, 2.0).0, (5.0 - driven_m, 2.0));
        // A quarter of the circle, and five metres nearer to its centre.
        let quarter_m = straight_m + 50.0 * std::f64::consts::PI;
        for (x_m, off_m) in [(100.0, 0.0), (95.0, 5.0)] {
            let ((along_m, beside_m), _) = corridor.to_way(straight_m + x_m, 100.0);
            assert!((along_m - quarter_m).abs() < 1e-9, "{driven_m}: {along_m}");
            assert!((beside_m - off_m).abs() < 1e-9, "{driven_m}: {beside_m}");
        }
        let (x_m, y_m) = corridor.to_body(quarter_m, -2.0);
        assert!((x_m - straight_m - 102.0).abs() < 1e-9 && (y_m - 100.0).abs() < 1e-9);
        let turned_rad = corridor.heading_rad(straight_m + 20.0);
        assert!((turned_rad - 0.2).abs() < 1e-12, "{turned_rad}");
    }
}

#[test]
fn beyond_its_last_cell_a_corridor_is_an_arc() {
    let cells_perm = [0.004; COURSE_CELLS];
    let chain = Corridor::of_cells(&cells_perm, 147.0, 0.01, 0.0);
    let arc = circle(250.0, 0.01);
    assert_eq!(chain.to_way(60.0, 3.0), arc.to_way(60.0, 3.0));
}

#[test]
fn a_curvature_that_deviates_spreads_with_the_square_of_the_distance() {
    let circle = Corridor::circle(0.0, 0.0, 3e-4);
    assert!((circle.sigma_m(100.0) - 1.5).abs() < 1e-12 && (circle.sigma_m(50.0) - 0.375) < 1e-12);
    assert_eq!(Corridor::default().sigma_m(80.0), 0.0);
}

proptest! {
    #[test]
    fn a_place_beside_a_winding_corridor_comes_back(
        cells in proptest::array::uniform15(-0.01..0.01_f64), driven in 0.0..12.0_f64,
        along in -20.0..140.0_f64, off in -5.0..5.0_f64, heading in -0.05..0.05_f64,
    ) {
        let corridor = Corridor::of_cells(&cells, driven, heading, 0.0);
        let (x_m, y_m) = corridor.to_body(along, off);
        let ((back_m, off_m), _) = corridor.to_way(x_m, y_m);
        prop_assert!((back_m - along).abs() < 1e-8, "{} {}", back_m, along);
        prop_assert!((off_m - off).abs() < 1e-8, "{} {}", off_m, off);
    }
}
