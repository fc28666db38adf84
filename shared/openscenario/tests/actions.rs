//! Each action follows its shape and dimension.

#![allow(clippy::approx_constant, reason = "a number as files have it")]

mod common;

use common::*;

fn after(action: &str) -> Parts {
    let stories = story(&[event("E", "override", &[action], &trigger(&[&at(1.0)]))]);
    Parts { stories, ..Parts::default() }
}

#[track_caller]
fn near(value: f64, expected: f64, margin: f64) {
    assert!((value - expected).abs() <= margin, "{value} is not {expected}");
}

#[test]
fn speeds_follow_their_shapes_over_time_rate_and_distance() {
    // From 20 to 10 m/s. The largest rate of each shape: 1, 1.5, pi/2 times the mean one.
    for (shape, peak, half_way) in
        [("linear", 1.0, 0.5), ("cubic", 1.5, 0.5), ("sinusoidal", 1.5708, 0.5)]
    {
        let mut run = after(&speed(shape, "time", 4.0, 10.0)).run();
        near(run.to(3.0).lead().speed_mps, 20.0 - 10.0 * half_way, 1e-9);
        near(run.lead().acceleration_mps2, -peak * 10.0 / 4.0, 1e-4);
        near(run.to(5.0).lead().speed_mps, 10.0, 1e-9);
        // 1 s at 20, 4 s at 15 in the mean, whatever the shape.
        near(run.lead().s_m, 60.0 + 20.0 + 60.0, 1e-6);

        let mut run = after(&speed(shape, "rate", 2.5, 10.0)).run();
        let duration_s = peak * 10.0 / 2.5;
        near(run.to(1.0 + 0.5 * duration_s).lead().acceleration_mps2, -2.5, 0.01);
        near(run.to(1.1 + duration_s).lead().speed_mps, 10.0, 1e-9);

        let mut run = after(&speed(shape, "distance", 60.0, 10.0)).run();
        assert!(run.to(4.98).lead().speed_mps > 10.0);
        near(run.to(5.0).lead().speed_mps, 10.0, 1e-9);
        near(run.lead().s_m, 60.0 + 20.0 + 60.0, 1e-6);
    }
    let mut run = after(&speed("step", "time", 0.0, 10.0)).run();
    assert_eq!(run.to(0.99).lead().speed_mps, 20.0);
    assert_eq!(run.to(1.0).lead().speed_mps, 10.0);
}

#[test]
fn the_way_of_a_shape_is_that_of_fine_steps() {
    for shape in ["linear", "cubic", "sinusoidal"] {
        let mut run = after(&speed(shape, "time", 3.0, 5.0)).run();
        let (mut way_m, mut before) = (0.0, run.to(1.0).lead().speed_mps);
        for step in 101..=400 {
            let speed = run.to(f64::from(step) * STEP_S).lead().speed_mps;
            way_m += 0.5 * (before + speed) * STEP_S;
            before = speed;
        }
        near(run.lead().s_m - 80.0, way_m, 1e-3);
    }
}

#[test]
fn a_rate_of_zero_changes_nothing_and_never_ends() {
    let mut parts = after(&speed("linear", "rate", 0.0, 10.0));
    let done = state("none", 0.0, "action", "EAction0", "completeState");
    parts.stop = trigger(&[&done]);
    let mut run = parts.run();
    assert_eq!(run.to(20.0).lead().speed_mps, 20.0);
    assert!(!run.world.is_stopped());
}

#[test]
fn relative_speeds_are_of_the_start_or_of_every_moment() {
    let relative = |value: f64, kind: &str, continuous: bool| {
        format!(
            "<RelativeTargetSpeed entityRef=\"Ego\" value=\"{value}\" speedTargetValueType=\"{kind}\" continuous=\"{continuous}\"/>"
        )
    };
    let once = speed_to("linear", "rate", 1.0, &relative(-5.0, "delta", false));
    let mut run = after(&once).run();
    run.to(2.0);
    run.ego.speed_mps = 30.0;
    near(run.to(10.0).lead().speed_mps, 15.0, 1e-9);

    let always = speed_to("linear", "rate", 4.0, &relative(0.5, "factor", true));
    let mut run = after(&always).run();
    near(run.to(10.0).lead().speed_mps, 10.0, 1e-9);
    run.ego.speed_mps = 30.0;
    near(run.to(20.0).lead().speed_mps, 15.0, 1e-9);
}

#[test]
fn lane_changes_end_in_the_middle_of_their_lane() {
    let beside = "<RelativeTargetLane entityRef=\"Ego\" value=\"1\"/>";
    for shape in ["linear", "cubic", "sinusoidal"] {
        let mut run = after(&lane_change(shape, "time", 4.0, beside)).run();
        near(run.to(3.0).lead().t_m, 0.0, 1e-9);
        near(run.to(5.0).lead().t_m, 2.0, 1e-9);
        let mut run = after(&lane_change(shape, "distance", 40.0, beside)).run();
        near(run.to(2.0).lead().t_m, 0.0, 1e-6);
        near(run.to(3.01).lead().t_m, 2.0, 1e-9);
    }
    let mut run =
        after(&lane_change("sinusoidal", "rate", 2.0, "<AbsoluteTargetLane value=\"-2\"/>")).run();
    // The largest lateral speed is the rate: pi/2 times 4 m over pi s.
    near(run.to(1.0 + 0.5 * std::f64::consts::PI).lead().lateral_mps, -2.0, 1e-3);
    near(run.to(4.2).lead().t_m, -6.0, 1e-9);
}

#[test]
fn a_lane_offset_keeps_its_lateral_acceleration() {
    let offset = |shape: &str, target: &str, continuous: bool| {
        format!(
            "<LateralAction><LaneOffsetAction continuous=\"{continuous}\"><LaneOffsetActionDynamics maxLateralAcc=\"0.5\" dynamicsShape=\"{shape}\"/>\
             <LaneOffsetTarget>{target}</LaneOffsetTarget></LaneOffsetAction></LateralAction>"
        )
    };
    for shape in ["cubic", "sinusoidal"] {
        let mut run =
            after(&offset(shape, "<AbsoluteTargetLaneOffset value=\"1.5\"/>", false)).run();
        let mut steepest: f64 = 0.0;
        let mut before = run.to(1.01).lead().lateral_mps;
        for step in 102..800 {
            let lateral = run.to(f64::from(step) * STEP_S).lead().lateral_mps;
            // The last step of the motion ends inside its period.
            if run.lead().t_m < -0.51 {
                steepest = steepest.max((lateral - before).abs() / STEP_S);
            }
            before = lateral;
        }
        near(steepest, 0.5, 0.01);
        near(run.lead().t_m, -0.5, 1e-9);
    }
    let follow = "<RelativeTargetLaneOffset entityRef=\"Ego\" value=\"-0.5\"/>";
    let mut run = after(&offset("cubic", follow, true)).run();
    near(run.to(8.0).lead().t_m, -2.5, 1e-9);
    run.ego.t_m = -1.0;
    near(run.to(9.0).lead().t_m, -1.5, 1e-9);
}

#[test]
fn distances_are_there_at_once_or_driven_to() {
    let action = |measure: &str, continuous: bool, limits: &str| {
        format!(
            "<LongitudinalAction><LongitudinalDistanceAction entityRef=\"Ego\" freespace=\"true\" continuous=\"{continuous}\" {measure} displacement=\"leadingReferencedEntity\">{limits}</LongitudinalDistanceAction></LongitudinalAction>"
        )
    };
    let gap = |run: &Run| {
        let ego = run.world.extent(0);
        run.world.extent(1).from_s_m - ego.to_s_m
    };
    let mut run = after(&action("timeGap=\"1.5\"", false, "")).run();
    near(gap(run.to(1.0)), 30.0, 1e-9);
    let mut run = after(&action("distance=\"12\"", true, "")).run();
    run.to(2.0);
    run.ego.speed_mps = 10.0;
    near(gap(run.to(6.0)), 12.0, 1e-9);
    let limits =
        "<DynamicConstraints maxAcceleration=\"2\" maxDeceleration=\"3\" maxSpeed=\"40\"/>";
    let mut run = after(&action("distance=\"100\"", false, limits)).run();
    let (mut hardest, mut strongest): (f64, f64) = (0.0, 0.0);
    for step in 0..4000 {
        let acceleration = run.to(f64::from(step) * STEP_S).lead().acceleration_mps2;
        (hardest, strongest) = (hardest.min(acceleration), strongest.max(acceleration));
    }
    near(gap(&run), 100.0, 0.2);
    near(run.lead().speed_mps, 20.0, 0.1);
    assert!(hardest >= -3.0 - 1e-6 && strongest <= 2.0 + 1e-6, "{hardest} {strongest}");
}

#[test]
fn a_timed_line_is_walked_on_time() {
    let vertex = |time: f64, offset: f64| {
        format!(
            "<Vertex time=\"{time}\"><Position><LanePosition roadId=\"0\" laneId=\"-1\" s=\"100\" offset=\"{offset}\"/></Position></Vertex>"
        )
    };
    let action = format!(
        "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><Shape><Polyline>{}{}</Polyline></Shape></Trajectory></TrajectoryRef>\
         <TimeReference><Timing domainAbsoluteRelative=\"relative\" scale=\"1\" offset=\"0\"/></TimeReference><TrajectoryFollowingMode followingMode=\"position\"/></FollowTrajectoryAction></RoutingAction>",
        vertex(0.0, -5.0),
        vertex(5.0, 5.0)
    );
    let stories = story_of(
        "Walker",
        "Story",
        1,
        &[event("E", "override", &[&action], &trigger(&[&at(1.0)]))],
    );
    let init = private(
        "Walker",
        &[&teleport("<LanePosition roadId=\"0\" laneId=\"-1\" s=\"100\" offset=\"-5\"/>")],
    );
    let mut run = Parts { stories, init, ..Parts::default() }.run();
    near(run.to(0.5).of_entity("Walker").t_m, -7.0, 1e-9);
    let walker = run.to(3.5).of_entity("Walker");
    near(walker.t_m, -2.0, 1e-9);
    near(walker.s_m, 100.0, 1e-9);
    near(walker.speed_mps, 2.0, 1e-9);
    near(walker.heading_rad, std::f64::consts::FRAC_PI_2, 1e-9);
    // Sideways, a person is as long as wide.
    let extent = run.world.extent(2);
    near(extent.to_s_m - extent.from_s_m, 0.6, 1e-9);
}

#[test]
fn an_untimed_line_keeps_the_speed() {
    let vertex = |lane: i32, s: f64| {
        format!(
            "<Vertex><Position><LanePosition roadId=\"0\" laneId=\"{lane}\" s=\"{s}\"/></Position></Vertex>"
        )
    };
    let action = format!(
        "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><Shape><Polyline>{}{}{}</Polyline></Shape></Trajectory></TrajectoryRef>\
         <TimeReference><None/></TimeReference><TrajectoryFollowingMode followingMode=\"follow\"/></FollowTrajectoryAction></RoutingAction>",
        vertex(-1, 80.0),
        vertex(-2, 83.0),
        vertex(-2, 200.0)
    );
    let mut run = after(&action).run();
    near(run.to(1.26).lead().t_m, -6.0, 0.2);
    near(run.to(2.0).lead().speed_mps, 20.0, 1e-9);
    near(run.lead().s_m, 83.0 + 15.0, 1e-6);
}

#[test]
fn entities_come_and_go() {
    let global = |inside: &str| {
        format!(
            "<Action name=\"a\"><GlobalAction><EntityAction entityRef=\"Lead\">{inside}</EntityAction></GlobalAction></Action>"
        )
    };
    let event = |name: &str, action: &str, time: f64| {
        format!(
            "<Event name=\"{name}\" priority=\"parallel\">{action}<StartTrigger>{}</StartTrigger></Event>",
            trigger(&[&at(time)])
        )
    };
    let position = "<AddEntityAction><Position><RelativeObjectPosition entityRef=\"Ego\" dx=\"30\" dy=\"4\"/></Position></AddEntityAction>";
    let stories = story(&[
        event("gone", &global("<DeleteEntityAction/>"), 1.0),
        event("back", &global(position), 2.0),
    ]);
    let mut run = Parts { stories, ..Parts::default() }.run();
    assert!(run.to(0.5).lead().present);
    assert!(!run.to(1.5).lead().present);
    let lead = run.to(2.0).lead();
    near(lead.s_m, 10.0 + 40.0 + 30.0, 1e-6);
    near(lead.t_m, 2.0, 1e-9);
}

#[test]
fn a_continuous_relative_speed_in_init_holds_from_the_first_step() {
    for (value, kind, expected) in [(0.9, "factor", 18.0), (-3.0, "delta", 17.0)] {
        let target = format!(
            "<RelativeTargetSpeed entityRef=\"Ego\" value=\"{value}\" speedTargetValueType=\"{kind}\" continuous=\"true\"/>"
        );
        let init = private("Ego", &[&place(-1, 10.0), &speed("step", "time", 0.0, 20.0)])
            + &private("Lead", &[&place(-1, 60.0), &speed_to("step", "time", 0.0, &target)]);
        let mut run = Parts { init, ..Parts::default() }.run();
        near(run.to(0.0).lead().speed_mps, expected, 1e-9);
        near(run.to(1.0).lead().speed_mps, expected, 1e-9);
    }
}

#[test]
fn a_change_shorter_than_the_clock_is_done_at_once() {
    let mut run = after(&speed("linear", "time", 1e-320, 10.0)).run();
    near(run.to(1.0).lead().speed_mps, 10.0, 1e-9);
    near(run.to(2.0).lead().s_m, 60.0 + 20.0 + 10.0, 1e-6);
}

fn beside(given: &str, bounds: &str) -> String {
    format!(
        "<LateralAction><LateralDistanceAction entityRef=\"Ego\" {given}>{bounds}</LateralDistanceAction></LateralAction>"
    )
}

#[test]
fn a_lateral_distance_is_reached_within_its_bounds_and_kept() {
    let given = |more: &str, continuous: bool| {
        format!("distance=\"1.5\" freespace=\"true\" continuous=\"{continuous}\" {more}")
    };
    let bounds =
        "<DynamicConstraints maxAcceleration=\"1\" maxDeceleration=\"1\" maxSpeed=\"0.5\"/>";
    // Both are 2 m wide, and the ego is at -2 m.
    let mut at_once =
        after(&beside(&given("displacement=\"leftToReferencedEntity\"", true), "")).run();
    near(at_once.to(0.99).lead().t_m, -2.0, 0.0);
    near(at_once.to(1.0).lead().t_m, -2.0 + 3.5, 1e-9);
    let right = given("displacement=\"rightToReferencedEntity\"", true);
    let mut bounded = after(&beside(&right, bounds)).run();
    let (mut last, mut fastest): (f64, f64) = (-2.0, 0.0);
    for step in 100..2000 {
        let lead = bounded.to(f64::from(step) * STEP_S).lead();
        fastest = fastest.max((lead.t_m - last).abs() / STEP_S);
        last = lead.t_m;
    }
    near(fastest, 0.5, 1e-4);
    near(last, -2.0 - 3.5, 1e-9);
    // It goes along when the ego moves across, also by the origins.
    bounded.ego.t_m += 1.0;
    near(bounded.to(40.0).lead().t_m, -1.0 - 3.5, 1e-9);
    let stories = story(&[
        event("E", "override", &[&beside(&given("", false), bounds)], &trigger(&[&at(1.0)])),
        event(
            "Next",
            "parallel",
            &[&speed("step", "time", 0.0, 5.0)],
            &trigger(&[&state("none", 0.0, "event", "E", "completeState")]),
        ),
    ]);
    let mut once = Parts { stories, ..Parts::default() }.run();
    near(once.to(4.0).lead().speed_mps, 20.0, 0.0);
    near(once.to(20.0).lead().speed_mps, 5.0, 0.0);
    near(once.lead().t_m, -2.0 + 3.5, 1e-9);
    // Without a distance that of now is kept.
    let kept = beside("freespace=\"false\" continuous=\"true\"", "");
    let init = private("Lead", &[&place(-2, 60.0), &speed("step", "time", 0.0, 20.0)]);
    let mut kept = Parts { init, ..after(&kept) }.run();
    kept.to(2.0).ego.t_m += 1.0;
    near(kept.to(3.0).lead().t_m, -6.0 + 1.0, 1e-9);
}
