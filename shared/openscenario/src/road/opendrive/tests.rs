//! Roads that are read and roads that are refused.

use super::*;
use crate::xml;
use ::road::Strip;

const STRAIGHT: &str = r#"<OpenDRIVE><road id="7" length="100">
<planView><geometry s="0" x="1" y="2" hdg="0.5" length="100"><line/></geometry></planView>
<lanes><laneOffset s="0" a="0.5" b="0" c="0" d="0"/><laneSection s="0">
<left><lane id="1"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
<center><lane id="0"/></center>
<right><lane id="-1"><width sOffset="0" a="2" b="0" c="0" d="0"/></lane>
<lane id="-2"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

const GEOMETRY: &str =
    "<geometry s=\"0\" x=\"1\" y=\"2\" hdg=\"0.5\" length=\"100\"><line/></geometry>";

fn found(text: &str, id: Option<&str>) -> Result<Found, ReadError> {
    read(&xml::parse("a.xodr", text).expect("it is well-formed"), id)
}

fn road(text: &str) -> Result<Road, ReadError> {
    found(text, None).map(|found| found.road)
}

fn refusal(text: &str) -> String {
    road(text).expect_err(text).to_string()
}

fn with_shape(shape: &str) -> String {
    STRAIGHT.replace("<line/>", shape)
}

fn centers(road: &Road, s_m: f64) -> Vec<(i32, f64)> {
    let mut strips: Vec<Strip> = road.lanes.strips(s_m).collect();
    strips.sort_by_key(|strip| strip.index);
    strips.iter().map(|strip| (strip.id, strip.center_m)).collect()
}

#[test]
fn the_nearest_road_outside_of_junctions_is_the_one_of_a_point() {
    let (from, to) =
        (STRAIGHT.find("<road ").expect("a road"), STRAIGHT.len() - "</OpenDRIVE>".len());
    let one = &STRAIGHT[from..to];
    let second = one.replace("id=\"7\"", "id=\"8\"").replace("y=\"2\"", "y=\"52\"");
    let way = one.replace("id=\"7\"", "id=\"9\" junction=\"3\"").replace("y=\"2\"", "y=\"102\"");
    let text = STRAIGHT.replace("</OpenDRIVE>", &format!("{second}{way}</OpenDRIVE>"));
    let document = xml::parse("a.xodr", &text).expect("it is well-formed");
    for (x_m, y_m, id) in [(1.0, 2.0, "7"), (-9.0, 45.0, "8"), (1.0, 110.0, "8")] {
        assert_eq!(nearest(&document, x_m, y_m).map(|it| it.0), Some(id), "({x_m}, {y_m})");
    }
}

#[test]
fn lanes_lie_beside_each_other() {
    let road = road(STRAIGHT).expect("it is straight");
    assert_eq!(centers(&road, 50.0), [(-2, -3.5), (-1, -0.5), (1, 2.0)]);
    assert!(
        road::Axis::laid(&road.pieces, road::MIN_RADIUS_M).expect("an axis").is_straight()
            && road.lanes.is_uniform()
    );
    assert_eq!((road.start().x_m, road.start().y_m, road.start().heading_rad), (1.0, 2.0, 0.5));
    assert_eq!(road.length_m, Some(100.0));
    let beside = |t, n| road.lane_beside(9.0, t, n).map(|lane| lane.id);
    assert_eq!([beside(-3.0, 1), beside(-3.0, 2), beside(-3.0, 3)], [Some(-1), Some(1), None]);
    assert!(road.holds(9.0, 3.4) && !road.holds(9.0, 3.6));
    let direction = |id| road.lane(9.0, id).map(|lane| road.direction(&lane));
    assert_eq!([direction(1), direction(-1)], [Some(-1.0), Some(1.0)]);
}

#[test]
fn traffic_keeps_to_the_left_where_the_road_says_so() {
    let text = STRAIGHT.replace("<road ", "<road rule=\"LHT\" ");
    let road = road(&text).expect("a road");
    let direction = |id| road.lane(9.0, id).map(|lane| road.direction(&lane));
    assert_eq!([direction(1), direction(-1)], [Some(1.0), Some(-1.0)]);
}

#[test]
fn every_shape_makes_its_curve() {
    let end = |shape: &str| {
        let road = road(&with_shape(shape)).unwrap_or_else(|error| panic!("{shape}: {error}"));
        let axis = road::Axis::laid(&road.pieces, road::MIN_RADIUS_M).expect("an axis");
        (axis.length_m(), axis.pose(axis.length_m()))
    };
    let (length_m, pose) = end("<arc curvature=\"0.01\"/>");
    assert!((length_m, (pose.heading_rad - 1.0).abs() < 1e-12) == (100.0, true));
    assert!((end("<spiral curvStart=\"0\" curvEnd=\"0.01\"/>").1.heading_rad - 0.5).abs() < 1e-12);
    let arc = end("<spiral curvStart=\"0.01\" curvEnd=\"0.01\"/>");
    assert_eq!(arc.1, pose);
    assert_eq!(end("<spiral curvStart=\"0\" curvEnd=\"0\"/>").1.y_m, 0.0);
    // A cubic that begins across its axes has its direction there.
    let (_, across) = end("<poly3 a=\"2\" b=\"1\" c=\"0\" d=\"0\"/>");
    assert!((across.x_m - 100.0).abs() < 1e-9 && across.y_m.abs() < 1e-9);
    let cubic = |range: &str, scale: f64| {
        format!(
            "<paramPoly3 aU=\"0\" bU=\"{scale}\" cU=\"0\" dU=\"0\" aV=\"0\" bV=\"0\" cV=\"0\" dV=\"0\"{range}/>"
        )
    };
    for text in [
        cubic("", 100.0),
        cubic(" pRange=\"normalized\"", 100.0),
        cubic(" pRange=\"arcLength\"", 1.0),
    ] {
        assert!((end(&text).1.x_m - 100.0).abs() < 1e-9, "{text}");
    }
    assert!(
        refusal(&with_shape(&cubic(" pRange=\"arclength\"", 1.0)))
            .contains("`pRange` is `arclength`")
    );
}

#[test]
fn a_cubic_of_another_length_is_noticed() {
    let cubic =
        "<paramPoly3 aU=\"0\" bU=\"98\" cU=\"0\" dU=\"0\" aV=\"0\" bV=\"0\" cV=\"0\" dV=\"0\"/>";
    let found = found(&with_shape(cubic), None).expect("a road");
    assert_eq!(found.notices.len(), 1);
    let begins = "a.xodr:2:11: the geometry is declared 100 m long and is 98.000 m";
    assert!(found.notices[0].starts_with(begins), "{}", found.notices[0]);
    assert!(refusal(&with_shape(&cubic.replace("98", "80"))).contains("a cubic of 80.000 m"));
}

#[test]
fn a_road_with_grades_is_read_with_its_steepest_slope() {
    let with = |pieces: &str| {
        let profile = format!("<elevationProfile>{pieces}</elevationProfile>\n<planView");
        road(&STRAIGHT.replacen("<planView", &profile, 1)).expect("grades are read")
    };
    assert_eq!(with("").steepest_slope(), 0.0);
    let first = "<elevation s=\"0\" a=\"3\" b=\"0.01\" c=\"0\" d=\"0\"/>";
    assert_eq!(with(first).steepest_slope(), 0.01);
    assert_eq!(with(first).heights.at(50.0), 3.5);
    // At its end, 50 m on, the second one falls with 2 * 0.0004 * 50.
    let second = "<elevation s=\"50\" a=\"3.5\" b=\"0\" c=\"-0.0004\" d=\"0\"/>";
    assert!((with(&format!("{first}{second}")).steepest_slope() - 0.04).abs() < 1e-12);
    // 3 d x² + 2 c x is largest at x = -c / (3 d) = 25 m: c²/(3 d) = 0.03.
    let hill = "<elevation s=\"0\" a=\"0\" b=\"0\" c=\"0.0012\" d=\"-0.000016\"/>";
    let far = "<elevation s=\"60\" a=\"0\" b=\"0\" c=\"0\" d=\"0\"/>";
    assert!((with(&format!("{hill}{far}")).steepest_slope() - 0.03).abs() < 1e-12);
}

#[test]
fn a_border_is_the_distance_of_a_lanes_outer_line() {
    let lane = |id: i32, inside: &str| format!("<lane id=\"{id}\">{inside}</lane>");
    let cubic = |name: &str, at: f64, f: [f64; 4]| {
        let [a, b, c, d] = f;
        format!("<{name} sOffset=\"{at}\" a=\"{a}\" b=\"{b}\" c=\"{c}\" d=\"{d}\"/>")
    };
    // Lane -2 widens from 20 m on, and its border stays until 60 m; lane 1 has a width inside of a border.
    let inner = cubic("border", 0.0, [-3.0, 0.0, 0.0, 0.0])
        + &cubic("border", 20.0, [-3.0, -0.01, -0.002, 0.00003]);
    let outer = cubic("border", 0.0, [-7.5, 0.0, 0.0, 0.0])
        + &cubic("border", 60.0, [-7.5, -0.1, 0.0, 0.0]);
    let left = lane(1, &cubic("width", 0.0, [2.0, 0.05, 0.0, 0.0]))
        + &lane(2, &cubic("border", 0.0, [8.0, 0.0, 0.0, 0.0]));
    let begin = STRAIGHT.find("<laneOffset").expect("it is there");
    let text = |offset: &str, right: &str| {
        format!(
            "{}{offset}\n<laneSection s=\"0\"><left>{left}</left><right>{right}</right></laneSection></lanes></road></OpenDRIVE>",
            &STRAIGHT[..begin]
        )
    };
    let right = lane(-2, &outer) + &lane(-1, &inner);
    let found = road(&text("", &right)).expect("borders are read");
    for s_m in [0.0, 10.0, 20.0, 35.5, 60.0, 80.0, 99.0] {
        let x = (s_m - 20.0_f64).max(0.0);
        let inner_m = 3.0 + 0.01 * x + 0.002 * x * x - 0.00003 * x * x * x;
        let outer_m = 7.5 + 0.1 * (s_m - 60.0).max(0.0);
        let first_m = 2.0 + 0.05 * s_m;
        let expected = [
            (-2, -0.5 * (inner_m + outer_m)),
            (-1, -0.5 * inner_m),
            (1, 0.5 * first_m),
            (2, 0.5 * (first_m + 8.0)),
        ];
        for ((id, center_m), (expected_id, expected_m)) in
            centers(&found, s_m).into_iter().zip(expected)
        {
            assert_eq!(id, expected_id);
            assert!(
                (center_m - expected_m).abs() < 1e-12,
                "{s_m}: {id} at {center_m}, {expected_m}"
            );
        }
    }
    let shown = refusal(&text("<laneOffset s=\"0\" a=\"0.5\" b=\"0\" c=\"0\" d=\"0\"/>", &right));
    assert!(
        shown.contains("a.xodr:4:")
            && shown.contains("a `border` of a road with a `laneOffset`, expected widths"),
        "{shown}"
    );
    let inside =
        cubic("border", 0.0, [-7.5, 0.0, 0.0, 0.0]) + &cubic("border", 60.0, [-2.0, 0.0, 0.0, 0.0]);
    let shown = refusal(&text("", &(lane(-1, &inner) + &lane(-2, &inside))));
    assert!(
        shown.contains("lane -2 has a width of -")
            && shown.contains("at s = 60 m, expected a border outside"),
        "{shown}"
    );
    let none = refusal(&text("", &lane(-1, "")));
    assert!(
        none.contains("element `lane` in `right` has no width, expected a `width` or a `border`"),
        "{none}"
    );
    // A width hides a border.
    let both = lane(-1, &(cubic("width", 0.0, [4.0, 0.0, 0.0, 0.0]) + &inner));
    let found = road(&text("", &both)).expect("the width counts");
    assert_eq!(found.lane(50.0, -1).map(|lane| lane.width_m), Some(4.0));
}

#[test]
fn a_lane_without_a_link_ends_where_others_go_on() {
    let lane = |id: i32, link: &str| {
        format!(
            "<lane id=\"{id}\"><link>{link}</link><width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane>"
        )
    };
    let first = format!(
        "<laneSection s=\"0\"><right>{}{}</right></laneSection>",
        lane(-1, ""),
        lane(-2, "")
    );
    let next = lane(-1, "<predecessor id=\"-2\"/>");
    let second = format!("<laneSection s=\"40\"><right>{next}</right></laneSection>");
    let begin = STRAIGHT.find("<laneOffset").expect("it is there");
    let text = format!("{}{first}{second}</lanes></road></OpenDRIVE>", &STRAIGHT[..begin]);
    let road = road(&text).expect("only right lanes, no offset");
    assert_eq!(centers(&road, 39.0), [(-2, -4.5), (-1, -1.5)]);
    // Lane -1 goes on in the place of lane -2, which was outside.
    assert_eq!(road.drift(10.0, -4.5, 60.0), 3.0 - 3.0);
    assert_eq!(road.lanes.sections[0].lanes[0].after, Some(0));
    assert_eq!(road.lanes.sections[0].lanes[1].after, None);
    assert_eq!(road.drift(10.0, -1.5, 60.0), 0.0);
}

#[test]
fn a_row_ends_before_a_road_that_is_too_tight() {
    let tight = with_shape("<arc curvature=\"0.1\"/>").replace("id=\"7\"", "id=\"8\"");
    let tight = tight.replace("<OpenDRIVE>", "");
    for link in ["successor", "predecessor"] {
        let link =
            format!("<link><{link} elementType=\"road\" elementId=\"8\"/></link>\n<planView>");
        let own = STRAIGHT.replacen("<planView>", &link, 1).replace("</OpenDRIVE>", "");
        let found = found(&(own + &tight), Some("7")).expect("the asked road can be driven");
        assert_eq!((found.road.parts.len(), found.road.length_m), (1, Some(100.0)));
        assert_eq!(found.notices.len(), 1, "{:?}", found.notices);
        let expected = ": a radius of 10.0 m, expected at least 20 m";
        assert!(found.notices[0].contains(expected), "{}", found.notices[0]);
    }
}

#[test]
fn a_road_that_cannot_be_driven_is_refused_with_its_line() {
    let arc = |curvature: &str| format!("<arc curvature=\"{curvature}\"/>");
    let twice = |x: f64, hdg: f64, s: f64| {
        let half = GEOMETRY.replace("\"100\"", "\"50\"").replace("\"0.5\"", "\"0\"");
        let second = format!(
            "<geometry s=\"{s}\" x=\"{x}\" y=\"2\" hdg=\"{hdg}\" length=\"50\"><line/></geometry>"
        );
        STRAIGHT.replace(GEOMETRY, &format!("{half}\n{second}"))
    };
    assert!(road(&twice(51.0, 0.0, 50.0)).is_ok());
    for (text, expected) in [
        (with_shape(&arc("nan")), "a.xodr:2:67: attribute `curvature` of `arc`: `nan` is not a number, expected a number"),
        (with_shape(&arc("0.1")), "a.xodr:2:11: a radius of 10.0 m, expected at least 20 m"),
        (with_shape(&arc("-0.06")), "a.xodr:2:11: a radius of 16.7 m"),
        (with_shape("<clothoid/>"), "a.xodr:2:62: element `clothoid` in `geometry` is not supported"),
        (with_shape(""), "a.xodr:2:11: element `geometry` in `planView` has no shape"),
        (twice(51.5, 0.0, 50.0), "a.xodr:3:1: a gap of 0.500 m to the end of the piece before"),
        (twice(51.0, 0.2, 50.0), "a.xodr:3:1: a kink of 0.2000 rad"),
        (twice(51.0, 0.0, 60.0), "a.xodr:3:1: the geometry begins at s = 60 m, the one before ends at 50.000 m"),
        (
            STRAIGHT.replace("hdg=\"0.5\" length=\"100\"", "hdg=\"0.5\" length=\"0\""),
            "a.xodr:2:11: a geometry of 0 m, expected a length above 0",
        ),
        (
            STRAIGHT.replace("id=\"7\" length=\"100\"", "id=\"7\" length=\"120\""),
            "a.xodr:1:12: the road is 120 m long, its geometries are 100.000 m",
        ),
        (STRAIGHT.replace("length=\"100\">\n<plan", "length=\"0\">\n<plan"), "a.xodr:1:12: the road has no length"),
        (STRAIGHT.replace("a=\"4\" b=\"0\"", "a=\"4\" b=\"NaN\""), "attribute `b` of `width`: `NaN` is not a number"),
        (STRAIGHT.replace("a=\"4\" b=\"0\"", "a=\"4\""), "attribute `b` of `width`: it is missing"),
        (
            STRAIGHT.replace("<laneOffset", "<laneSection s=\"0\"><left><lane id=\"1\"><width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane></left></laneSection><laneOffset"),
            "the lane section begins at s = 0 m, expected more than 0",
        ),
        (STRAIGHT.replace("laneSection s=\"0\"", "laneSection s=\"3\""), "the first lane section begins at s = 3 m, expected 0"),
        (STRAIGHT.replace("lane id=\"-2\"", "lane id=\"-1\""), "element `lane` in `right` is there twice"),
        (STRAIGHT.replace("lane id=\"-2\"", "lane id=\"2\""), "element `lane` in `right` has an id of the other side"),
        (STRAIGHT.replace("<road ", "<road junction=\"5\" "), "a.xodr:1:1: each of the 1 roads in this file belongs to a junction"),
        ("<OpenDRIVE><junction id=\"1\"/></OpenDRIVE>".to_owned(), "a.xodr:1:1: this file has no road, expected a road"),
        (
            STRAIGHT.replace("<road id", "<road id=\"1\"/><road id"),
            "a.xodr:1:1: this file has 2 roads and no position names the ego's, expected a lane or road position of \
             the ego with the `roadId` `1` or `7`",
        ),
        (STRAIGHT.replace("OpenDRIVE", "Map"), "element `Map`"),
    ] {
        let shown = refusal(&text);
        assert!(shown.contains(expected), "{shown}\n  expected {expected}");
    }
}
