//! Trajectories that are curves, against sums of small steps.

mod common;

use common::*;

/// A run in which the lead follows a shape from 80 m on, at 20 m/s, from 1 s on. It is there already.
fn along(shape: &str) -> Parts {
    let follow = format!(
        "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><Shape>{shape}</Shape></Trajectory></TrajectoryRef>\
         <TimeReference><None/></TimeReference><TrajectoryFollowingMode followingMode=\"follow\"/></FollowTrajectoryAction></RoutingAction>"
    );
    let start = trigger(&[&at(1.0)]);
    Parts { stories: story(&[event("E", "override", &[&follow], &start)]), ..Parts::default() }
}

fn near(value: f64, expected: f64, within: f64) {
    assert!((value - expected).abs() <= within, "{value} for {expected}");
}

fn position(s_m: f64, t_m: f64) -> String {
    format!("<Position><RoadPosition roadId=\"0\" s=\"{s_m}\" t=\"{t_m}\"/></Position>")
}

#[test]
fn a_clothoid_turns_evenly() {
    let place = position(80.0, -2.0);
    for rate in ["curvaturePrime", "curvatureDot"] {
        let shape = format!(
            "<Clothoid curvature=\"-0.01\" {rate}=\"0.0004\" length=\"60\">{place}</Clothoid>"
        );
        let lead = along(&shape).run().to(3.0).lead();
        // 40 m, in steps of 0.1 mm.
        let (mut x, mut y, ds) = (80.0, -2.0, 1e-4);
        for i in 0..400_000 {
            let p = (f64::from(i) + 0.5) * ds;
            let heading = -0.01 * p + 0.5 * 0.0004 * p * p;
            (x, y) = (x + ds * heading.cos(), y + ds * heading.sin());
        }
        near(lead.s_m, x, 0.01);
        near(lead.t_m, y, 0.01);
        near(lead.heading_rad, -0.01 * 40.0 + 0.5 * 0.0004 * 1600.0, 0.01);
    }
}

#[test]
fn a_rational_spline_may_be_a_part_of_a_circle() {
    // A quarter of a circle of 40 m around (80, 38).
    let point = |s_m: f64, t_m: f64, weight: f64| {
        format!("<ControlPoint weight=\"{weight}\">{}</ControlPoint>", position(s_m, t_m))
    };
    let points = point(80.0, -2.0, 1.0)
        + &point(120.0, -2.0, std::f64::consts::FRAC_1_SQRT_2)
        + &point(120.0, 38.0, 1.0);
    let knots: String = [0, 0, 0, 1, 1, 1].map(|knot| format!("<Knot value=\"{knot}\"/>")).concat();
    let lead = along(&format!("<Nurbs order=\"3\">{points}{knots}</Nurbs>")).run().to(2.5).lead();
    let turned = 30.0 / 40.0_f64;
    near(lead.s_m, 80.0 + 40.0 * turned.sin(), 0.01);
    near(lead.t_m, 38.0 - 40.0 * turned.cos(), 0.01);
    let few = format!("<Nurbs order=\"3\">{points}<Knot value=\"0\"/><Knot value=\"1\"/></Nurbs>");
    let said = along(&few).refusal();
    assert!(said.contains("order 3 with 3 points and 2 knots"), "{said}");
    let falling = knots.replacen("\"1\"", "\"-1\"", 1);
    let said = along(&format!("<Nurbs order=\"3\">{points}{falling}</Nurbs>")).refusal();
    assert!(said.contains("which do not decrease"), "{said}");
    let said = along(&format!("<Nurbs order=\"4\">{points}{knots}</Nurbs>")).refusal();
    assert!(said.contains("order 4 with 3 points and 6 knots"), "{said}");
}

#[test]
fn a_spline_of_clothoids_is_refused_in_its_own_words() {
    let said = along("<ClothoidSpline/>").refusal();
    assert!(said.contains("a trajectory is a `Polyline`, a `Clothoid` or a `Nurbs`"), "{said}");
}
