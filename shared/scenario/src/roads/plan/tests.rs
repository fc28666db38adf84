//! Tests of plans.

use crate::Scenario;

const HEAD: &str = "schema_version = 1\nname = \"x\"\n";

fn opened(rest: &str) -> Scenario {
    Scenario::parse("x.toml", &format!("{HEAD}{rest}")).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(rest: &str) -> String {
    let text = format!("{HEAD}{rest}");
    Scenario::parse("x.toml", &text).expect_err("it is wrong").to_string()
}

const S_BEND: &str = "[road.plan]\npieces = [{ line_m = 100 }, { spiral_m = 50 }, \
    { arc_m = 80, radius_m = 200, turn = \"left\" }, { spiral_m = 60 }, \
    { arc_m = 90, radius_m = 300, turn = \"right\" }]\n";

#[test]
fn a_spiral_has_the_curvatures_of_its_neighbours() {
    let scenario = opened(S_BEND);
    let plan = scenario.road.plan().expect("it is there");
    let pieces = plan.geometry().expect("a road");
    let spiral = |index: usize| match pieces[index] {
        road::Piece::Spiral { start_perm, end_perm, .. } => (start_perm, end_perm),
        ref other => panic!("{other:?}"),
    };
    assert_eq!(spiral(1), (0.0, 1.0 / 200.0));
    assert_eq!(spiral(3), (1.0 / 200.0, -1.0 / 300.0));
    let axis = plan.axis();
    assert!((axis.length_m() - 380.0).abs() < 1e-6);
    assert!((axis.curvature_perm(190.0) - 0.005).abs() < 1e-9);
    assert!((axis.curvature_perm(330.0) + 1.0 / 300.0).abs() < 1e-9);
}

#[test]
fn a_plan_survives_the_way_through_text() {
    let rest = S_BEND.to_owned()
        + "start = { x_m = 5, y_m = -3, heading_deg = 30 }\nlanes = { left = 0, right = 2 }\n\
           [plant.lateral]\nmodel = \"on-axis\"\n[perception.course]\nsources = []\n\
           [controller.curve_speed]\nenabled = false\ncomfort_mps2 = { slow = 3 }\n";
    let scenario = opened(&rest);
    let again = Scenario::parse("again.toml", &scenario.to_toml()).expect("what took effect");
    assert_eq!(again, scenario);
    assert_eq!(again.controller.curve_speed.comfort_mps2.fast.value(), 2.0);
    assert!(
        (again.road.plan().expect("kept").start.pose().heading_rad - std::f64::consts::FRAC_PI_6)
            .abs()
            < 1e-6
    );
}

#[test]
fn a_generated_road_is_its_seeds() {
    let keys = |seed: u64| {
        opened(&format!("[road.plan]\ngenerated = {{ seed = {seed}, length_km = 3 }}\n"))
    };
    let (first, same, other) = (keys(1), keys(1), keys(2));
    let end = |scenario: &Scenario| {
        let axis = scenario.road.plan().expect("it is there").axis();
        axis.pose(axis.length_m()).x_m
    };
    assert_eq!(end(&first).to_bits(), end(&same).to_bits());
    assert_ne!(end(&first), end(&other));
}

#[test]
fn an_invalid_road_is_refused_at_its_place() {
    let cases = [
        ("[road.plan]\n", "this plan has no road"),
        (
            "[road.plan]\npieces = [{ arc_m = 50, radius_m = 19, turn = \"left\" }]",
            "4:36: 19 is out",
        ),
        ("[road.plan]\npieces = [{ line_m = 0 }]", "4:22: 0 is out of range"),
        ("[road.plan]\npieces = [{ line_m = nan }]", "4:22: NaN is out of range"),
        ("[road.plan]\npieces = [{ line_m = 9 }, { spiral_m = 9 }]", "4:27: this spiral lacks"),
        ("[road.plan]\npieces = [{ spiral_m = 9 }, { line_m = 9 }]", "4:11: this spiral lacks"),
        (
            "[road.plan]\npieces = [{ line_m = 9, spiral_m = 9 }]",
            "4:11: these keys are not a piece",
        ),
        (
            "[road.plan]\npieces = [{ arc_m = 50, radius_m = 50 }]",
            "4:11: these keys are not a piece",
        ),
        (
            "[road.plan]\npieces = [{ arc_m = 150, radius_m = 21, turn = \"left\" }]",
            "4:11: the road crosses itself",
        ),
        (
            "[road.plan]\nlanes.left = 6\n\
             pieces = [{ arc_m = 50, radius_m = 20, turn = \"left\" }]",
            "5:11: the lanes reach 22.75 m into a curve of 20 m",
        ),
        (
            "[road.plan]\npieces = [{ line_m = 900 }]\ngenerated = { seed = 1, length_km = 1 }",
            "5:13: the plan is given twice",
        ),
        (
            "[road.plan]\ngenerated = { seed = 1, length_km = 1, max_radius_m = 100 }",
            "the largest radius is below the smallest",
        ),
        (
            "[road.plan]\ngenerated = { seed = 1, length_km = 1, spiral_m = [90, 30] }",
            "the longest spiral is shorter",
        ),
        (
            "[road.plan]\nopendrive = { file = \"a.xodr\", road = \"1\", lane = -1 }",
            "the file has not been read, for this scenario is not a file itself",
        ),
        (
            "[road]\npoints = [[0, 0], [50, 1]]\n[road.plan]\npieces = [{ line_m = 90 }]",
            "the heights end at 50 m, the plan at 90 m",
        ),
        ("[plant.lateral]\nmodel = \"on-axis\"", "no effect without a plan of the road"),
        ("[perception.course]\nsources = []", "no effect without a plan of the road"),
        ("[controller.curve_speed]\nenabled = false", "no effect without a plan of the road"),
        (
            "[road.plan]\npieces = [{ line_m = 999 }]\n[perception.course]\n\
             sources = [\"map\", \"map\"]",
            "this source stands here twice",
        ),
    ];
    for (rest, expected) in cases {
        let shown = refusal(rest);
        assert!(shown.contains(expected), "{rest}\n{shown}");
    }
}

#[test]
fn a_road_that_ends_before_the_drive_is_refused_if_its_end_is_known() {
    let short = "[road.plan]\npieces = [{ line_m = 300 }]\n";
    let cases = [
        (
            "[[v2x.signals]]\nstop_line_m = 310\nintersection_id = 1\n\
          program = [{ phase = \"red\", duration_s = 9 }]",
            "this stop line is behind the end",
        ),
        ("[[actors]]\nname = \"a\"\ngap_m = 299\ninitial_speed_mps = 0", "begins behind the end"),
        ("[[actors]]\nname = \"a\"\ngap_m = 60\ninitial_speed_mps = 30", "gets to 360 m"),
        (
            "[plant]\ninitial_speed_mps = 31\n[controller.curve_speed]\nenabled = false",
            "the ego gets to 310 m",
        ),
    ];
    for (rest, expected) in cases {
        let shown = refusal(&format!("{short}{rest}"));
        assert!(shown.contains(expected), "{rest}\n{shown}");
    }
    opened(&format!("{short}[[actors]]\nname = \"a\"\ngap_m = 60\ninitial_speed_mps = 20"));
}

#[test]
fn frames_need_a_straight_road_up_to_the_last_signal() {
    let frames = "[v2x]\nradio = \"frames\"\n[[v2x.signals]]\nintersection_id = 1\n\
        program = [{ phase = \"red\", duration_s = 9 }]\n";
    let shown = refusal(&format!("{S_BEND}{frames}stop_line_m = 200"));
    assert!(shown.contains("cannot come as frames"), "{shown}");
    opened(&format!("{S_BEND}{frames}stop_line_m = 90"));
}

#[test]
fn a_fault_on_a_topic_of_the_plane_needs_a_plan() {
    let fault = "[[faults]]\nkind = \"drop\"\ntopic = \"vehicle/lateral\"\nprobability = 0.5\n";
    let shown = refusal(fault);
    assert!(shown.contains("nothing is sent on `vehicle/lateral`"), "{shown}");
    opened(&format!("{fault}[road.plan]\npieces = [{{ line_m = 900 }}]\n"));
}

#[test]
fn a_truck_has_a_longer_wheelbase_on_a_road_with_a_plan() {
    let truck = "[plant]\nvehicle = \"jh6-49t\"\n";
    assert_eq!(opened(truck).plant.lateral, crate::lateral::Lateral::default());
    let planned = opened(&format!("{truck}[road.plan]\npieces = [{{ line_m = 900 }}]\n"));
    assert_eq!(planned.plant.lateral.wheelbase_m.value(), 5.8);
}
