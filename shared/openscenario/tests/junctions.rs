//! Several roads in one scene, and the ways through their junctions.

mod common;

use common::*;
use openscenario::World;

/// The ego on road 0, 180 m before the crossing; the lead 90 m before it on road 3. Both drive 20 m/s.
fn crossing(lead: &[&str], parts: Parts) -> Parts {
    let init = private("Lead", &[&[&on("3", -1, 100.0)[..], &cruise()], lead].concat());
    Parts { init, files: vec![("dir/road.xodr".to_owned(), crossing::net())], ..parts }
}

fn cruise() -> String {
    speed("step", "time", 0.0, 20.0)
}

fn at_place(road: &str, lane: i32, s_m: f64) -> String {
    format!("<LanePosition roadId=\"{road}\" laneId=\"{lane}\" s=\"{s_m}\"/>")
}

fn on(road: &str, lane: i32, s_m: f64) -> String {
    teleport(&at_place(road, lane, s_m))
}

fn route(places: &[&str]) -> String {
    let waypoint = |at: &&str| {
        format!("<Waypoint routeStrategy=\"shortest\"><Position>{at}</Position></Waypoint>")
    };
    let waypoints: String = places.iter().map(waypoint).collect();
    format!(
        "<RoutingAction><AssignRouteAction><Route name=\"r\" closed=\"false\">{waypoints}</Route></AssignRouteAction></RoutingAction>"
    )
}

fn acquire(position: &str) -> String {
    format!(
        "<RoutingAction><AcquirePositionAction><Position>{position}</Position></AcquirePositionAction></RoutingAction>"
    )
}

/// The road of the file under an entity, with the place there.
fn own_place(run: &Run, name: &str) -> (String, f64, f64) {
    let motion = run.of_entity(name);
    let part = run.world.script().roads[motion.row].part_at(motion.s_m);
    let (s_m, t_m) = part.own(motion.s_m, motion.t_m);
    (part.id.clone(), s_m, t_m)
}

#[track_caller]
fn is_at(run: &Run, name: &str, road: &str, s_m: f64, t_m: f64) {
    let (own, own_s_m, own_t_m) = own_place(run, name);
    let off_m = (own_s_m - s_m).abs().max((own_t_m - t_m).abs());
    assert!(own == road && off_m < 0.01, "{name}: road {own}, {own_s_m} m, {own_t_m} m");
}

#[test]
fn a_way_leads_straight_on_through_a_junction() {
    let mut run = crossing(&[], Parts::default()).run();
    run.to(3.0);
    is_at(&run, "Lead", "3", 160.0, -2.0);
    is_at(run.to(5.0), "Lead", "11", 10.0, -2.0);
    is_at(run.to(8.0), "Lead", "4", 50.0, -2.0);
    let noted = ": the way leads over the roads `3`, `11`, `4`";
    let notices = crossing(&[], Parts::default()).read().expect("right").notices;
    assert!(notices.iter().any(|notice| notice.ends_with(noted)), "{notices:?}");
}

#[test]
fn a_route_turns_off_and_a_line_may_begin_beside_the_one_before() {
    let turn = route(&[&at_place("3", -1, 120.0), &at_place("2", -1, 50.0)]);
    for action in [turn.clone(), acquire(&at_place("2", -1, 50.0))] {
        let mut run = crossing(&[&action], Parts::default()).run();
        // 90 m to the end of the road, then an arc of 4 pi m, whose line is the middle of the lane.
        is_at(run.to(5.0), "Lead", "13", 10.0, 0.0);
        is_at(run.to(8.0), "Lead", "2", 70.0 - 4.0 * std::f64::consts::PI, -2.0);
    }
    // The same in the storyboard, before the junction.
    for action in [turn, acquire(&at_place("2", -1, 50.0))] {
        let stories = story(&[event("E", "override", &[&action], &trigger(&[&at(1.0)]))]);
        let mut run = crossing(&[], Parts { stories, ..Parts::default() }).run();
        is_at(run.to(5.0), "Lead", "13", 10.0, 0.0);
    }
    let shown = crossing(&[&acquire(&at_place("0", -1, 50.0))], Parts::default()).refusal();
    assert!(shown.contains("no way leads from road `3` to road `0`"), "{shown}");
}

#[test]
fn a_change_of_lane_before_a_junction_leads_to_the_way_of_the_new_lane() {
    let files = vec![("dir/road.xodr".to_owned(), crossing::exit())];
    let driven = |from: i32, to: i32| {
        let init = private("Lead", &[&on("0", from, 60.0), &cruise()]);
        let target = format!("<AbsoluteTargetLane value=\"{to}\"/>");
        let change = lane_change("sinusoidal", "time", 2.0, &target);
        let stories = story(&[event("E", "override", &[&change], &trigger(&[&at(1.0)]))]);
        Parts { init, stories, files: files.clone(), ..Parts::default() }.run()
    };
    let mut leaves = driven(-1, -2);
    is_at(leaves.to(2.0), "Lead", "0", 100.0, -4.0);
    is_at(leaves.to(3.0), "Lead", "0", 120.0, -6.0);
    // At 7 s it leaves the road. Its lane is 0.96 as long as the line of the arc.
    is_at(leaves.to(10.0), "Lead", "3", 40.8, -2.0);
    is_at(driven(-2, -1).to(10.0), "Lead", "2", 40.0, -2.0);
    is_at(driven(-2, -2).to(10.0), "Lead", "3", 40.8, -2.0);
}

#[test]
fn the_drive_ends_where_the_egos_lane_ends() {
    let lane = |id: i32| {
        format!("<lane id=\"{id}\"><width sOffset=\"0\" a=\"4\" b=\"0\" c=\"0\" d=\"0\"/></lane>")
    };
    let net = format!(
        "<OpenDRIVE><road id=\"0\" length=\"400\"><planView><geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"400\"><line/></geometry></planView>\
         <lanes><laneSection s=\"0\"><left>{0}</left><right>{1}</right></laneSection><laneSection s=\"300\"><left>{0}</left></laneSection>\
         </lanes></road></OpenDRIVE>",
        lane(1),
        lane(-1)
    );
    let files = vec![("dir/road.xodr".to_owned(), net)];
    let mut run = Parts { files, ..Parts::default() }.run();
    // Its front begins at 13 m.
    assert!(!run.to(14.3).world.is_stopped());
    assert!(run.to(14.4).world.has_road_ended());
}

#[test]
fn distances_along_roads_that_do_not_connect_are_none() {
    let test = |kind: &str, axes: &str, metres: f64| {
        let test = format!(
            "<RelativeDistanceCondition entityRef=\"Lead\" relativeDistanceType=\"{kind}\" value=\"{metres}\" \
             freespace=\"false\" rule=\"lessThan\" coordinateSystem=\"{axes}\"/>"
        );
        let stop = trigger(&[&by_entity("none", 0.0, "Ego", &test)]);
        let mut run = crossing(&[], Parts { stop, ..Parts::default() }).run();
        run.ego.speed_mps = 0.0;
        run.to(0.0).world.is_stopped()
    };
    assert!(!test("longitudinal", "road", 1e6) && !test("lateral", "lane", 1e6));
    // (-190, -2) and (2, -100).
    let apart_m = 192.0_f64.hypot(98.0);
    assert!(test("euclidianDistance", "road", apart_m + 0.1));
    assert!(!test("euclidianDistance", "road", apart_m - 0.1));
    assert!(test("longitudinal", "entity", 192.1) && !test("longitudinal", "entity", 191.9));
    assert!(test("lateral", "entity", 98.1) && !test("lateral", "entity", 97.9));
}

#[test]
fn a_lead_behind_the_junction_is_on_the_egos_road() {
    let init = private("Lead", &[&on("2", -1, 60.0), &cruise()]);
    let test = "<RelativeDistanceCondition entityRef=\"Lead\" relativeDistanceType=\"longitudinal\" value=\"240\" \
                freespace=\"false\" rule=\"lessThan\" coordinateSystem=\"road\"/>";
    let stop = trigger(&[&by_entity("none", 0.0, "Ego", test)]);
    let files = vec![("dir/road.xodr".to_owned(), crossing::net())];
    let mut run = Parts { init, stop, files, ..Parts::default() }.run();
    run.ego.speed_mps = 30.0;
    // 180 + 20 + 60 m apart at the start, closing at 10 m/s.
    assert!(!run.to(1.98).world.is_stopped() && run.to(2.02).world.is_stopped());
}

#[test]
fn bodies_on_crossing_roads_collide_in_the_plane() {
    let test = "<CollisionCondition><EntityRef entityRef=\"Lead\"/></CollisionCondition>";
    let stop = trigger(&[&by_entity("none", 0.0, "Ego", test)]);
    let mut run = crossing(&[], Parts { stop, ..Parts::default() }).run();
    run.ego.speed_mps = 40.0;
    // The fronts, 3 m ahead of the origins, come to the other's lane, which begins at 1 m of the middle.
    assert!(!run.to(4.6).world.is_stopped() && run.to(5.0).world.is_stopped());
}

#[test]
fn a_place_in_a_junction_is_one() {
    let lead = private("Lead", &[&on("12", -1, 3.0), &cruise()]);
    let files = vec![("dir/road.xodr".to_owned(), crossing::net())];
    let mut run = Parts { init: lead, files, ..Parts::default() }.run();
    is_at(&run, "Lead", "12", 3.0, 0.0);
    is_at(run.to(2.0), "Lead", "4", 43.0 - 6.0 * std::f64::consts::PI, -2.0);
}

#[test]
fn a_place_on_a_route_counts_through_the_junction() {
    let waypoint = |at: String| {
        format!("<Waypoint routeStrategy=\"shortest\"><Position>{at}</Position></Waypoint>")
    };
    let along = waypoint(at_place("3", -1, 120.0)) + &waypoint(at_place("2", -1, 50.0));
    let position = format!(
        "<RoutePosition><RouteRef><Route name=\"r\" closed=\"false\">{along}</Route></RouteRef>\
         <InRoutePosition><FromLaneCoordinates pathS=\"100\" laneId=\"-1\"/></InRoutePosition></RoutePosition>"
    );
    let init = private("Lead", &[&teleport(&position)]);
    let files = vec![("dir/road.xodr".to_owned(), crossing::net())];
    let run = Parts { init, files, ..Parts::default() }.run();
    is_at(&run, "Lead", "2", 30.0 - 4.0 * std::f64::consts::PI, -2.0);
}

#[test]
fn a_trajectory_turns_off_in_the_plane() {
    let vertex = |x: f64, y: f64| {
        format!("<Vertex><Position><WorldPosition x=\"{x}\" y=\"{y}\"/></Position></Vertex>")
    };
    let line = format!(
        "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><Shape><Polyline>{}{}{}</Polyline></Shape>\
         </Trajectory></TrajectoryRef><TimeReference><None/></TimeReference><TrajectoryFollowingMode followingMode=\"follow\"/>\
         </FollowTrajectoryAction></RoutingAction>",
        vertex(2.0, -100.0),
        vertex(2.0, -10.0),
        vertex(-58.0, 2.0)
    );
    let stories = story(&[event("E", "override", &[&line], &trigger(&[&at(0.0)]))]);
    let mut run = crossing(&[], Parts { stories, ..Parts::default() }).run();
    let lead = run.to(6.0).lead();
    // 30 m along the second piece, on a row that leads straight north from y = -200 m.
    let share = 30.0 / 60.0_f64.hypot(12.0);
    let off_m = (lead.s_m - 190.0 - 12.0 * share).hypot(lead.t_m + 2.0 - 60.0 * share);
    assert!(off_m < 0.01, "{lead:?}");
}

#[test]
fn a_script_with_rows_is_written_down_and_read_back() {
    let script = crossing(&[], Parts::default()).read().expect("right").script;
    assert!(script.roads.len() > 1);
    let text = toml::to_string(&script).expect("a form in TOML");
    assert_eq!(toml::from_str::<openscenario::Script>(&text).expect("the same form"), script);
    let mut empty = script;
    empty.roads[1].cuts[1].piece = 99;
    assert!(World::new(empty).is_err());
}
