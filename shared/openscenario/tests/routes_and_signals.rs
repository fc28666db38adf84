//! Routes along the road, and traffic signals that conditions see.

mod common;

use common::*;

#[track_caller]
fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-9, "{value} is not {expected}");
}

fn waypoint(position: &str) -> String {
    format!("<Waypoint routeStrategy=\"shortest\"><Position>{position}</Position></Waypoint>")
}

fn on_lane(road: &str, s_m: f64) -> String {
    format!("<LanePosition roadId=\"{road}\" laneId=\"-1\" s=\"{s_m}\"/>")
}

fn route(closed: bool, waypoints: &str) -> String {
    format!(
        "<RoutingAction><AssignRouteAction><Route name=\"r\" closed=\"{closed}\">{waypoints}</Route></AssignRouteAction></RoutingAction>"
    )
}

fn acquire(position: &str) -> String {
    format!(
        "<RoutingAction><AcquirePositionAction><Position>{position}</Position></AcquirePositionAction></RoutingAction>"
    )
}

/// In Init for the ego, and in the storyboard for the lead.
fn with(action: &str) -> Parts {
    let init = private("Ego", &[&place(-1, 10.0), action])
        + &private("Lead", &[&place(-1, 60.0), &speed("step", "time", 0.0, 20.0)]);
    let next = trigger(&[&state("none", 0.0, "event", "E", "completeState")]);
    let stories = story(&[
        event("E", "override", &[action], &trigger(&[&at(1.0)])),
        event("Next", "parallel", &[&speed("step", "time", 0.0, 5.0)], &next),
    ]);
    Parts { init, stories, ..Parts::default() }
}

#[test]
fn a_route_along_the_road_is_complete_at_once_and_moves_nothing() {
    let along = waypoint(&on_lane("0", 11.0)) + &waypoint(&on_lane("0", 900.0));
    for action in [route(false, &along), acquire(&on_lane("0", 900.0))] {
        let mut run = with(&action).run();
        near(run.to(0.99).lead().speed_mps, 20.0);
        near(run.to(1.0).lead().s_m, 80.0);
        // The next event follows in the same step.
        near(run.lead().speed_mps, 5.0);
    }
}

/// A position on the route between two waypoints of lane -1.
fn on_route(from_m: f64, to_m: f64, place: &str) -> String {
    let along = waypoint(&on_lane("0", from_m)) + &waypoint(&on_lane("0", to_m));
    format!(
        "<RoutePosition><RouteRef><Route name=\"r\" closed=\"false\">{along}</Route></RouteRef>\
         <InRoutePosition>{place}</InRoutePosition></RoutePosition>"
    )
}

/// Places the lead.
fn placed(position: &str) -> Parts {
    Parts { init: private("Lead", &[&teleport(position)]), ..Parts::default() }
}

#[test]
fn a_place_on_a_route_counts_from_its_first_waypoint() {
    let in_road = "<FromRoadCoordinates pathS=\"30\" t=\"-2.5\"/>";
    let in_lane = "<FromLaneCoordinates pathS=\"30\" laneId=\"-2\" laneOffset=\"0.5\"/>";
    // Lane -2 lies from -4 to -8 m.
    for (from_m, to_m, place, s_m, t_m, heading_rad) in [
        (100.0, 400.0, in_road, 130.0, -2.5, 0.0),
        (100.0, 400.0, in_lane, 130.0, -5.5, 0.0),
        (400.0, 100.0, in_road, 370.0, -2.5, std::f64::consts::PI),
        (400.0, 100.0, in_lane, 370.0, -5.5, std::f64::consts::PI),
    ] {
        let lead = placed(&on_route(from_m, to_m, place)).run().lead();
        near(lead.s_m, s_m);
        near(lead.t_m, t_m);
        near(lead.heading_rad, heading_rad);
    }
    for (place, said) in [
        (in_road.replace("30", "301"), "301 m are beyond the route's end, expected at most 300 m"),
        (
            in_lane.replace("-2", "-7"),
            "the route has no such lane there, expected `-2`, `-1` or `1`",
        ),
        (
            "<FromCurrentEntity entityRef=\"Ego\"/>".to_owned(),
            "is not supported: the place of an entity is a `RelativeRoadPosition`",
        ),
    ] {
        let shown = placed(&on_route(100.0, 400.0, &place)).refusal();
        assert!(shown.contains(said), "{shown}");
    }
}

/// A road that is followed by one whose reference line runs against it.
#[test]
fn a_route_over_a_road_that_runs_the_other_way_keeps_that_roads_sides() {
    let link = |inside: &str| format!("<link>{inside}</link><planView>");
    let first = ROAD.replace(
        "<planView>",
        &link("<successor elementType=\"road\" elementId=\"1\" contactPoint=\"end\"/>"),
    );
    let turned = "x=\"2000\" y=\"0\" hdg=\"3.141592653589793\"";
    let second = ROAD.replace("<OpenDRIVE>", "").replace("<road id=\"0\"", "<road id=\"1\"");
    let second = second.replace("x=\"0\" y=\"0\" hdg=\"0\"", turned);
    let second = second.replace(
        "<planView>",
        &link("<successor elementType=\"road\" elementId=\"0\" contactPoint=\"end\"/>"),
    );
    let along =
        waypoint(&on_lane("0", 900.0)) + &waypoint(&on_lane("1", 100.0).replace("\"-1\"", "\"1\""));
    let position = format!(
        "<RoutePosition><RouteRef><Route name=\"r\" closed=\"false\">{along}</Route></RouteRef>\
         <InRoutePosition><FromRoadCoordinates pathS=\"300\" t=\"2.5\"/></InRoutePosition></RoutePosition>"
    );
    let mut parts = placed(&position);
    let road = first.replace("</OpenDRIVE>", &second);
    parts.files = vec![("dir/road.xodr".to_owned(), road)];
    let lead = parts.run().lead();
    // 300 m behind s = 900 m; the second road's left is the row's right.
    near(lead.s_m, 1200.0);
    near(lead.t_m, -2.5);
}

fn on_line(s_m: f64, t_m: f64, vertices: &[(f64, f64)]) -> String {
    let vertex = |(x, y): &(f64, f64)| {
        format!(
            "<Vertex time=\"0\"><Position><WorldPosition x=\"{x}\" y=\"{y}\"/></Position></Vertex>"
        )
    };
    let vertices: String = vertices.iter().map(vertex).collect();
    format!(
        "<TrajectoryPosition s=\"{s_m}\" t=\"{t_m}\"><TrajectoryRef><Trajectory name=\"l\" closed=\"false\">\
         <Shape><Polyline>{vertices}</Polyline></Shape></Trajectory></TrajectoryRef></TrajectoryPosition>"
    )
}

#[test]
fn a_place_on_a_trajectory_counts_along_its_corners() {
    // 30 m ahead, then 3 m ahead and 4 m to the left for each 5 m.
    let corners = [(100.0, -2.0), (130.0, -2.0), (160.0, 38.0)];
    for (s_m, aside_m, [x_m, y_m], heading_rad) in [
        (12.0, 0.5, [112.0, -1.5], 0.0),
        (35.0, 0.0, [133.0, 2.0], libm::atan2(4.0, 3.0)),
        (35.0, 1.0, [133.0 - 0.8, 2.0 + 0.6], libm::atan2(4.0, 3.0)),
        (80.0, 0.0, [160.0, 38.0], libm::atan2(4.0, 3.0)),
    ] {
        let lead = placed(&on_line(s_m, aside_m, &corners)).run().lead();
        near(lead.s_m, x_m);
        near(lead.t_m, y_m);
        near(lead.heading_rad, heading_rad);
    }
    let shown = placed(&on_line(81.0, 0.0, &corners)).refusal();
    assert!(shown.contains("81 m are beyond the line's end, expected at most 80"), "{shown}");
}

/// The chord of an arc of 200 m radius lies inside of it.
#[test]
fn a_place_on_a_trajectory_is_found_on_a_curved_road() {
    let arc = ROAD.replace("<line/>", "<arc curvature=\"0.005\"/>");
    // From the start to the point of the reference line a quarter of a radian on.
    let end = (200.0 * libm::sin(0.25), 200.0 * (1.0 - libm::cos(0.25)));
    let chord_m = libm::hypot(end.0, end.1);
    let mut parts = placed(&on_line(0.5 * chord_m, 0.0, &[(0.0, 0.0), end]));
    parts.files = vec![("dir/road.xodr".to_owned(), arc)];
    let lead = parts.run().lead();
    near(lead.s_m, 25.0);
    near(lead.t_m, 200.0 * (1.0 - libm::cos(0.125)));
    near(lead.heading_rad, 0.0);
}

#[test]
fn a_route_from_a_catalog_is_read() {
    let mut parts = with(
        "<RoutingAction><AssignRouteAction><CatalogReference catalogName=\"c\" entryName=\"r\"/></AssignRouteAction></RoutingAction>",
    );
    parts.head = "<CatalogLocations><RouteCatalog><Directory path=\"routes\"/></RouteCatalog></CatalogLocations>".to_owned();
    let catalog = |road: &str| {
        let along = waypoint(&on_lane("0", 11.0)) + &waypoint(&on_lane(road, 900.0));
        format!(
            "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"0\"/>\n<Catalog name=\"c\"><Route name=\"r\" closed=\"false\">{along}</Route></Catalog></OpenSCENARIO>"
        )
    };
    parts.files = vec![("dir/routes/c.xosc".to_owned(), catalog("0"))];
    parts.read().expect("it is on the road");
    parts.files = vec![("dir/routes/c.xosc".to_owned(), catalog("7"))];
    let shown = parts.refusal();
    assert!(shown.starts_with("dir/routes/c.xosc:3:"), "{shown}");
    assert!(shown.contains("there is no road `7`, expected `0`"), "{shown}");
}

#[test]
fn a_route_that_leaves_the_road_is_refused() {
    let refused = |action: &str, expected: &str| {
        let shown = with(action).refusal();
        assert!(shown.starts_with("dir/a.xosc:5:") && shown.contains(expected), "{shown}");
    };
    let start = waypoint(&on_lane("0", 11.0));
    refused(&route(false, &start), "a route of one waypoint, expected two waypoints or more");
    let twice = start.clone() + &start;
    refused(&route(true, &twice), "attribute `closed` of `Route`");
    let odd = twice.replace("shortest", "scenic");
    refused(&route(false, &odd), "`scenic` is not supported, expected `fastest`, `shortest`");
}

fn global(name: &str, start: &str, inside: &str) -> String {
    format!(
        "<Event name=\"{name}\" priority=\"parallel\"><Action name=\"{name}A\"><GlobalAction>{inside}</GlobalAction></Action><StartTrigger>{start}</StartTrigger></Event>"
    )
}

fn set_signal(name: &str, state: &str) -> String {
    format!(
        "<InfrastructureAction><TrafficSignalAction><TrafficSignalStateAction name=\"{name}\" state=\"{state}\"/></TrafficSignalAction></InfrastructureAction>"
    )
}

fn shows(delay_s: f64, name: &str, state: &str) -> String {
    let inside = format!("<TrafficSignalCondition name=\"{name}\" state=\"{state}\"/>");
    condition("none", delay_s, &format!("<ByValueCondition>{inside}</ByValueCondition>"))
}

#[test]
fn a_condition_sees_the_state_of_a_signal() {
    let slow = |mps: f64| speed("step", "time", 0.0, mps);
    let stories = story(&[
        global("yellow", &trigger(&[&at(1.0)]), &set_signal("7", "off;on;off")),
        global("red", &trigger(&[&shows(2.0, "7", "off;on;off")]), &set_signal("7", "on;off;off")),
        event("A", "parallel", &[&slow(15.0)], &trigger(&[&shows(0.0, "7", "off;on;off")])),
        event("B", "parallel", &[&slow(0.0)], &trigger(&[&shows(0.0, "7", "on;off;off")])),
        event("C", "parallel", &[&slow(33.0)], &trigger(&[&shows(0.0, "8", "on")])),
    ]);
    let green = format!("<GlobalAction>{}</GlobalAction>", set_signal("7", "off;off;on"));
    let lead = private("Lead", &[&place(-1, 60.0), &slow(20.0)]);
    let parts = Parts { stories, init: green + &lead, ..Parts::default() };
    let notices = parts.read().expect("it is in the subset").notices;
    assert!(notices.iter().any(|notice| notice.contains("neither the ego nor others see them")));
    let mut run = parts.run();
    near(run.to(0.99).lead().speed_mps, 20.0);
    near(run.to(1.0).lead().speed_mps, 15.0);
    near(run.to(2.99).lead().speed_mps, 15.0);
    near(run.to(3.0).lead().speed_mps, 0.0);
    near(run.to(20.0).lead().speed_mps, 0.0);
}

/// A controller of signal 7: red for 3 s, green for 2 s, from `delay_s` after another one.
fn controller(name: &str, more: &str) -> String {
    let phase = |name: &str, duration: f64, state: &str| {
        format!(
            "<Phase name=\"{name}\" duration=\"{duration}\"><TrafficSignalState trafficSignalId=\"{name}7\" state=\"{state}\"/></Phase>"
        )
    };
    let states = [phase("red", 3.0, "on"), phase("green", 2.0, "off")].concat();
    format!("<TrafficSignalController name=\"{name}\"{more}>{states}</TrafficSignalController>")
}

/// The scenario with controllers in its road network.
fn controlled(controllers: &str, stories: &str) -> Parts {
    let road = "<LogicFile filepath=\"road.xodr\"/>";
    Parts {
        network: format!("{road}<TrafficSignals>{controllers}</TrafficSignals>"),
        stories: stories.to_owned(),
        ..Parts::default()
    }
}

fn in_phase(controller: &str, phase: &str) -> String {
    let inside = format!(
        "<TrafficSignalControllerCondition trafficSignalControllerRef=\"{controller}\" phase=\"{phase}\"/>"
    );
    condition("rising", 0.0, &format!("<ByValueCondition>{inside}</ByValueCondition>"))
}

#[test]
fn a_controller_goes_through_its_phases_without_end() {
    let fast = event(
        "A",
        "parallel",
        &[&speed("step", "time", 0.0, 30.0)],
        &trigger(&[&in_phase("b", "green")]),
    );
    let stories =
        story(&[fast.replace(
            "priority=\"parallel\"",
            "priority=\"parallel\" maximumExecutionCount=\"9\"",
        )]);
    let both = controller("a", "") + &controller("b", " reference=\"a\" delay=\"1.5\"");
    let mut run = controlled(&both, &stories).run();
    // Red from 1.5 s, green from 4.5 s.
    near(run.to(4.49).lead().speed_mps, 20.0);
    near(run.to(4.5).lead().speed_mps, 30.0);
}

#[test]
fn an_action_moves_a_controller_to_a_phase() {
    let go = "<InfrastructureAction><TrafficSignalAction><TrafficSignalControllerAction trafficSignalControllerRef=\"a\" phase=\"green\"/></TrafficSignalAction></InfrastructureAction>";
    let slow = |mps: f64| speed("step", "time", 0.0, mps);
    let stories = story(&[
        global("go", &trigger(&[&at(1.0)]), go),
        event("A", "parallel", &[&slow(30.0)], &trigger(&[&in_phase("a", "green")])),
        event(
            "B",
            "parallel",
            &[&slow(10.0)],
            &trigger(&[&at(1.5), &shows(0.0, "red7", "on"), &in_phase("a", "red")]),
        ),
    ]);
    let mut run = controlled(&controller("a", ""), &stories).run();
    near(run.to(0.99).lead().speed_mps, 20.0);
    near(run.to(1.0).lead().speed_mps, 30.0);
    near(run.to(2.99).lead().speed_mps, 30.0);
    near(run.to(3.0).lead().speed_mps, 10.0);
}

#[test]
fn controllers_that_make_no_sense_are_refused() {
    let refused = |controllers: &str, stories: &str, expected: &str| {
        let shown = controlled(controllers, stories).refusal();
        assert!(shown.starts_with("dir/a.xosc:") && shown.contains(expected), "{shown}");
    };
    let when = |condition: &str| {
        story(&[event(
            "A",
            "parallel",
            &[&speed("step", "time", 0.0, 1.0)],
            &trigger(&[condition]),
        )])
    };
    let own = controller("a", " reference=\"a\"");
    refused(
        &own,
        "",
        "`reference` of `TrafficSignalController`: there is no controller `a` before this one",
    );
    let none = "<TrafficSignalController name=\"a\"/>";
    refused(none, "", "a controller without a phase that lasts, expected a `Phase`");
    let good = controller("a", "");
    refused(&good.replace("\"3\"", "\"-3\""), "", "-3 is out of range, expected 0 or more");
    refused(&good, &when(&in_phase("c", "red")), "there is no controller `c`, expected `a`");
    refused(
        &good,
        &when(&in_phase("a", "blue")),
        "there is no phase `blue`, expected `red` or `green`",
    );
    refused(
        "",
        &when(&in_phase("a", "red")),
        "expected one in the `TrafficSignals` of the road network",
    );
}

#[test]
fn lights_and_commands_of_other_players_have_no_effect() {
    let light = "<AppearanceAction><LightStateAction transitionTime=\"0.1\"><LightType><VehicleLight vehicleLightType=\"brakeLights\"/></LightType><LightState mode=\"on\"/></LightStateAction></AppearanceAction>";
    let command = "<Action name=\"c\"><UserDefinedAction><CustomCommandAction type=\"python\">run me</CustomCommandAction></UserDefinedAction></Action>";
    let first = event("A", "parallel", &[light], &trigger(&[&at(1.0)]));
    let stories = story(&[first.replacen("<Action name", &format!("{command}<Action name"), 1)]);
    let parts = Parts { stories, ..Parts::default() };
    let notices = parts.read().expect("they are known").notices;
    assert!(
        notices.iter().any(|notice| notice.contains("a command of another player")),
        "{notices:?}"
    );
    near(parts.run().to(3.0).lead().speed_mps, 20.0);
}
