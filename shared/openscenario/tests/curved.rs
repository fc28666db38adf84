//! Positions, ways and distances on a curved road.

mod common;

use common::*;
use openscenario::road::Road;
use openscenario::{Motion, World};

/// A left curve of 100 m radius and 300 m. Lanes -1 and 1 have 4 m; lane -1 widens to 6 m from 100 m to 150 m.
const CURVE: &str = r#"<OpenDRIVE><road id="0" length="300"><planView><geometry s="0" x="50" y="-20" hdg="0" length="300"><arc curvature="0.01"/></geometry></planView>
<lanes><laneSection s="0">
<left><lane id="1"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane></left><center><lane id="0"/></center>
<right><lane id="-1"><width sOffset="0" a="4" b="0" c="0" d="0"/><width sOffset="100" a="4" b="0.04" c="0" d="0"/><width sOffset="150" a="6" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

fn on_curve(parts: Parts) -> Parts {
    Parts { files: vec![("dir/road.xodr".to_owned(), CURVE.to_owned())], ..parts }
}

fn lead(position: &str) -> Parts {
    on_curve(Parts {
        init: private("Lead", &[&teleport(position), &speed("step", "time", 0.0, 20.0)]),
        ..Parts::default()
    })
}

/// The pose in the coordinates of the file.
fn in_plane(road: &Road, motion: &Motion) -> (f64, f64, f64) {
    let at = road::Axis::laid(&road.pieces, road::MIN_RADIUS_M)
        .expect("an axis")
        .point(motion.s_m, motion.t_m)
        .placed(&road.start());
    (at.x_m, at.y_m, at.heading_rad + motion.heading_rad)
}

#[track_caller]
fn near(value: f64, expected: f64, margin: f64) {
    assert!((value - expected).abs() <= margin, "{value} is not {expected}");
}

#[test]
fn world_positions_are_found_on_the_road() {
    // A quarter round the centre (50, 80), 2 m outside of the reference line.
    let quarter = 50.0 * std::f64::consts::PI;
    let h = std::f64::consts::FRAC_PI_2 + 0.1;
    let run = lead(&format!("<WorldPosition x=\"152\" y=\"80\" h=\"{h}\"/>")).run();
    let lead = run.lead();
    near(lead.s_m, quarter, 1e-6);
    near(lead.t_m, -2.0, 1e-6);
    near(lead.heading_rad, 0.1, 1e-6);
    let run = self::lead("<WorldPosition x=\"152\" y=\"80\"/>").run();
    assert_eq!(run.lead().heading_rad, 0.0, "along the road");
}

#[test]
fn relative_positions_and_headings_are_those_of_the_plane() {
    let of = |position: &str| {
        let run = lead(position).run();
        in_plane(&run.world.script().roads[0], &run.lead())
    };
    let run = lead("<WorldPosition x=\"152\" y=\"80\"/>").run();
    let ego = in_plane(&run.world.script().roads[0], &run.ego);
    let (x, y, _) = of("<RelativeWorldPosition entityRef=\"Ego\" dx=\"20\" dy=\"3\"/>");
    near(x - ego.0, 20.0, 1e-6);
    near(y - ego.1, 3.0, 1e-6);
    let (x, y, h) = of("<RelativeObjectPosition entityRef=\"Ego\" dx=\"20\" dy=\"0\"/>");
    near((x - ego.0).hypot(y - ego.1), 20.0, 1e-6);
    near((y - ego.1).atan2(x - ego.0), ego.2, 1e-6);
    near(h, ego.2, 1e-6);
    let absolute = "<LanePosition roadId=\"0\" laneId=\"-1\" s=\"60\"><Orientation type=\"absolute\" h=\"0.25\"/></LanePosition>";
    near(of(absolute).2, 0.25, 1e-6);
}

#[test]
fn the_outer_lane_is_longer() {
    let mut run = lead("<LanePosition roadId=\"0\" laneId=\"-1\" s=\"60\"/>").run();
    // 2 m outside of the reference line: 102 m radius.
    near(run.to(1.0).lead().s_m, 60.0 + 20.0 * 100.0 / 102.0, 0.01);
    let mut run = lead("<LanePosition roadId=\"0\" laneId=\"1\" s=\"60\"/>").run();
    near(run.to(1.0).lead().s_m, 60.0 + 20.0 * 100.0 / 98.0, 0.01);
}

#[test]
fn a_vehicle_stays_in_the_middle_of_a_lane_that_widens() {
    let mut run = lead("<LanePosition roadId=\"0\" laneId=\"-1\" s=\"60\"/>").run();
    assert_eq!(run.lead().t_m, -2.0);
    near(run.to(6.0).lead().t_m, -3.0, 1e-6);
    assert!(run.lead().s_m > 170.0);
}

#[test]
fn euclidean_distances_are_chords() {
    let on = "coordinateSystem=\"road\" relativeDistanceType=\"euclidianDistance\"";
    let far = |metres: f64| {
        let test = format!(
            "<RelativeDistanceCondition entityRef=\"Ego\" value=\"{metres}\" freespace=\"false\" rule=\"greaterThan\" {on}/>"
        );
        let stop = trigger(&[&by_entity("none", 0.0, "Lead", &test)]);
        let place = "<LanePosition roadId=\"0\" laneId=\"-1\" s=\"210\"/>";
        let parts = Parts { stop, ..lead(place) };
        let mut run = Run::of(World::new(parts.read().expect("right").script).expect("right"));
        run.to(0.0).world.is_stopped()
    };
    // From s = 10 to s = 210: 2 rad. The ego is at 102 m from the centre, the lead at 103 m.
    let chord_m = (102.0_f64.powi(2) + 103.0 * 103.0 - 2.0 * 102.0 * 103.0 * 2.0_f64.cos()).sqrt();
    assert!(far(chord_m - 0.1) && !far(chord_m + 0.1), "{chord_m}");
}

#[test]
fn a_straight_trajectory_is_a_chord() {
    let vertex = |x: f64, y: f64| {
        format!(
            "<Vertex time=\"0\"><Position><WorldPosition x=\"{x}\" y=\"{y}\"/></Position></Vertex>"
        )
    };
    let line = format!(
        "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><ParameterDeclarations/>\
         <Shape><Polyline>{}{}</Polyline></Shape></Trajectory></TrajectoryRef><TimeReference><None/></TimeReference>\
         <TrajectoryFollowingMode followingMode=\"follow\"/></FollowTrajectoryAction></RoutingAction>",
        vertex(110.0, -2.0),
        vertex(150.0, 58.0),
    );
    let stories = story(&[event("E", "override", &[&line], &trigger(&[&at(0.0)]))]);
    let parts = Parts { stories, ..lead("<WorldPosition x=\"110\" y=\"-2\"/>") };
    let mut run = parts.run();
    let (x, y, h) = in_plane(&run.to(2.0).world.script().roads[0].clone(), &run.lead());
    // 40 m along the line, which is 72 m long.
    let share = 40.0 / 40.0_f64.hypot(60.0);
    near(x, 110.0 + share * 40.0, 0.3);
    near(y, -2.0 + share * 60.0, 0.3);
    near(h, 60.0_f64.atan2(40.0), 0.02);
}
