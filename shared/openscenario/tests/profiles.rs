//! Profiles of speeds and arrivals at the same time.

mod common;

use common::*;

#[track_caller]
fn near(value: f64, expected: f64, margin: f64) {
    assert!((value - expected).abs() <= margin, "{value} is not {expected}");
}

/// An action of the lead at 1 s; the lead begins at 60 m. The ego drives 20 m/s and is at 30 m then.
fn at_1_s(action: &str, lead_mps: f64) -> Parts {
    let then = state("none", 0.0, "event", "E", "completeState");
    let stories = story(&[
        event("E", "parallel", &[action], &trigger(&[&at(1.0)])),
        event("Next", "parallel", &[&lane_change("step", "time", 0.0, RIGHT)], &trigger(&[&then])),
    ]);
    let init = private("Lead", &[&place(-1, 60.0), &speed("step", "time", 0.0, lead_mps)]);
    Parts { stories, init, ..Parts::default() }
}

const RIGHT: &str = "<AbsoluteTargetLane value=\"-2\"/>";

/// The first time in hundredths at which the event after the action has begun.
fn end_of(run: &mut Run) -> f64 {
    let mut ticks = 100_i32;
    while run.to(f64::from(ticks) * STEP_S).lead().t_m > -3.0 {
        ticks += 1;
        assert!(ticks < 10_000, "it never ends");
    }
    f64::from(ticks) * STEP_S
}

fn profile(attributes: &str, constraints: &str, entries: &[(f64, Option<f64>)]) -> String {
    let entries: String = entries
        .iter()
        .map(|(speed, time)| {
            let time = time.map_or(String::new(), |time| format!(" time=\"{time}\""));
            format!("<SpeedProfileEntry speed=\"{speed}\"{time}/>")
        })
        .collect();
    format!(
        "<LongitudinalAction><SpeedProfileAction {attributes}>{constraints}{entries}</SpeedProfileAction></LongitudinalAction>"
    )
}

#[test]
fn a_profile_in_mode_position_goes_straight_through_its_entries() {
    let entries = [(10.0, Some(4.0)), (10.0, Some(1.0)), (16.0, Some(2.0))];
    let action = profile("followingMode=\"position\"", "", &entries);
    near(end_of(&mut at_1_s(&action, 20.0).run()), 8.01, 0.011);
    let mut run = at_1_s(&action, 20.0).run();
    near(run.to(3.0).lead().speed_mps, 15.0, 1e-9);
    near(run.lead().acceleration_mps2, -2.5, 1e-9);
    near(run.to(5.5).lead().speed_mps, 10.0, 1e-9);
    near(run.to(7.0).lead().speed_mps, 13.0, 1e-9);
    near(run.to(8.0).lead().speed_mps, 16.0, 1e-9);
    near(run.lead().s_m, 60.0 + 20.0 + 60.0 + 10.0 + 26.0, 1e-6);
    near(run.to(9.0).lead().speed_mps, 16.0, 1e-9);
}

#[test]
fn a_profile_in_mode_follow_keeps_its_bounds_and_comes_late() {
    let constraints = "<DynamicConstraints maxAcceleration=\"2\" maxDeceleration=\"4\" maxAccelerationRate=\"2\" maxDecelerationRate=\"8\" maxSpeed=\"15\"/>";
    // 20 to 10 m/s: 10/4 + 4/8 = 3 s instead of 1 s. 10 to 15 m/s (not 30): 5/2 + 2/2 = 3.5 s instead of 2 s.
    let entries = [(10.0, Some(1.0)), (30.0, Some(2.0))];
    let action = profile("followingMode=\"follow\"", constraints, &entries);
    near(end_of(&mut at_1_s(&action, 20.0).run()), 7.51, 0.011);
    let mut run = at_1_s(&action, 20.0).run();
    near(run.to(1.25).lead().acceleration_mps2, -2.0, 1e-6);
    near(run.lead().speed_mps, 20.0 - 0.25, 1e-6);
    near(run.to(2.5).lead().acceleration_mps2, -4.0, 1e-9);
    near(run.to(4.0).lead().speed_mps, 10.0, 1e-6);
    near(run.to(5.75).lead().speed_mps, 12.5, 1e-6);
    near(run.lead().acceleration_mps2, 2.0, 1e-9);
    near(run.to(7.5).lead().speed_mps, 15.0, 1e-6);
    near(run.lead().s_m, 60.0 + 20.0 + 15.0 * 3.0 + 12.5 * 3.5, 1e-6);
}

#[test]
fn the_speeds_of_a_profile_are_added_to_an_entitys_own() {
    let of_ego = "followingMode=\"position\" entityRef=\"Ego\"";
    let mut run = at_1_s(&profile(of_ego, "", &[(-10.0, Some(4.0))]), 20.0).run();
    near(run.to(3.0).lead().speed_mps, 15.0, 1e-9);
    run.ego.speed_mps = 24.0;
    near(run.to(4.0).lead().speed_mps, 24.0 - 7.5, 1e-9);
    near(run.to(5.0).lead().speed_mps, 14.0, 1e-9);
}

#[test]
fn an_entry_without_a_time_is_reached_as_soon_as_the_bounds_allow() {
    let braking = "<DynamicConstraints maxDeceleration=\"5\"/>";
    for mode in ["follow", "position"] {
        let action = profile(&format!("followingMode=\"{mode}\""), braking, &[(10.0, None)]);
        let mut run = at_1_s(&action, 20.0).run();
        near(run.to(2.0).lead().speed_mps, 15.0, 1e-9);
        near(end_of(&mut run), 3.01, 0.011);
    }
    let mut run = at_1_s(&profile("followingMode=\"follow\"", "", &[(10.0, None)]), 20.0).run();
    near(run.to(1.01).lead().speed_mps, 10.0, 1e-9);
}

/// The lead at `goal_s_m` when the ego is at `ego_s_m`.
fn meet(ego_s_m: f64, goal_s_m: f64, tolerances: &str, final_speed: &str) -> String {
    let place = |s_m: f64| format!("<LanePosition roadId=\"0\" laneId=\"-1\" s=\"{s_m}\"/>");
    let end = match final_speed {
        "" => String::new(),
        speed => format!("<FinalSpeed>{speed}</FinalSpeed>"),
    };
    format!(
        "<SynchronizeAction masterEntityRef=\"Ego\"{tolerances}><TargetPositionMaster>{}</TargetPositionMaster>\
         <TargetPosition>{}</TargetPosition>{end}</SynchronizeAction>",
        place(ego_s_m),
        place(goal_s_m)
    )
}

const AS_THE_EGO: &str = "<RelativeSpeedToMaster value=\"0\" speedTargetValueType=\"delta\"/>";

#[test]
fn an_entity_arrives_with_its_master_and_with_its_speed() {
    // 100 m in 10 s from 0 to 20 m/s: a = 600/100 - 40/10 = 2, b = 0.
    let mut run = at_1_s(&meet(230.0, 160.0, "", AS_THE_EGO), 0.0).run();
    near(run.to(6.0).lead().speed_mps, 10.0, 1e-6);
    near(run.lead().s_m, 85.0, 1e-6);
    near(run.lead().acceleration_mps2, 2.0, 1e-6);
    near(run.to(11.0).lead().speed_mps, 20.0, 1e-6);
    near(run.lead().s_m, 160.0, 1e-6);
    near(run.ego.s_m, 230.2, 1e-6);
    // 150 m: a = 9 - 4 = 5, b = (20 - 50)/100 = -0.3.
    let mut run = at_1_s(&meet(230.0, 210.0, "", AS_THE_EGO), 0.0).run();
    near(run.to(6.0).lead().speed_mps, 25.0 - 7.5, 1e-6);
    near(run.lead().s_m, 60.0 + 62.5 - 12.5, 1e-6);
    near(run.to(11.0).lead().s_m, 210.0, 1e-6);
    near(end_of(&mut run), 11.01, 0.011);
    near(run.lead().speed_mps, 20.0, 1e-9);
}

#[test]
fn a_free_final_speed_takes_the_least_acceleration() {
    // 100 m in 10 s from 20 m/s: a = 3 (100 - 200)/100 = -3, b = 0.15.
    let mut run = at_1_s(&meet(230.0, 180.0, "", ""), 20.0).run();
    near(run.to(6.0).lead().speed_mps, 20.0 - 15.0 + 3.75, 1e-6);
    near(run.lead().s_m, 80.0 + 100.0 - 37.5 + 6.25, 1e-6);
    near(run.to(11.0).lead().speed_mps, 5.0, 1e-6);
    near(run.lead().s_m, 180.0, 1e-6);
}

#[test]
fn an_entity_with_too_much_time_brakes_waits_and_leaves() {
    // 60 m in 30 s from 10 to 10 m/s: it brakes over 3 60 √10/(2 10 √10) = 9 s and 30 m, and leaves 9 s before.
    let action = meet(630.0, 130.0, "", "<AbsoluteSpeed value=\"10\"/>");
    let mut run = at_1_s(&action, 10.0).run();
    near(run.to(5.5).lead().speed_mps, 2.5, 1e-6);
    near(run.lead().s_m, 70.0 + 26.25, 1e-6);
    near(run.to(16.0).lead().s_m, 100.0, 1e-6);
    assert_eq!(run.lead().speed_mps, 0.0);
    near(run.to(26.5).lead().speed_mps, 2.5, 0.01);
    near(run.lead().s_m, 130.0 - 26.25, 0.01);
    near(run.to(31.0).lead().s_m, 130.0, 1e-6);
    near(run.lead().speed_mps, 10.0, 1e-6);
}

#[test]
fn an_entity_stands_at_its_goal_while_its_master_stands() {
    // It brakes to rest over 100 m: 3 100/20 = 15 s.
    let mut run = at_1_s(&meet(230.0, 180.0, "", ""), 20.0).run();
    run.to(0.99);
    run.ego.speed_mps = 0.0;
    near(run.to(8.5).lead().speed_mps, 5.0, 1e-6);
    near(run.lead().s_m, 167.5, 1e-6);
    near(run.to(20.0).lead().s_m, 180.0, 1e-3);
    near(run.lead().speed_mps, 0.0, 1e-3);
    run.ego.speed_mps = 20.0;
    near(end_of(&mut run), 30.02, 0.011);
}

#[test]
fn the_last_part_of_the_way_has_the_final_speed() {
    // The first 60 m in 6 s from 0 to 10 m/s: a = 10 - 20/6, then 40 m with 10 m/s.
    for steady in
        ["<TargetDistanceSteadyState distance=\"40\"/>", "<TargetTimeSteadyState time=\"4\"/>"]
    {
        let end = format!("<AbsoluteSpeed value=\"10\">{steady}</AbsoluteSpeed>");
        let mut run = at_1_s(&meet(230.0, 160.0, "", &end), 0.0).run();
        near(run.to(4.0).lead().speed_mps, 12.5, 1e-6);
        near(run.to(7.5).lead().speed_mps, 10.0, 1e-6);
        near(run.to(9.0).lead().s_m, 140.0, 1e-6);
        near(run.lead().acceleration_mps2, 0.0, 1e-6);
        near(run.to(11.0).lead().s_m, 160.0, 1e-6);
    }
}

#[test]
fn a_meeting_ends_within_its_tolerances_and_at_once_without_a_way() {
    let near_both = " targetToleranceMaster=\"1\" targetTolerance=\"1.5\"";
    let mut run = at_1_s(&meet(230.0, 160.0, near_both, AS_THE_EGO), 0.0).run();
    near(end_of(&mut run), 10.96, 0.011);
    near(run.lead().speed_mps, 20.0, 1e-9);
    let mut run = at_1_s(&meet(20.0, 160.0, "", ""), 20.0).run();
    near(end_of(&mut run), 1.01, 0.011);
    let mut run = at_1_s(&meet(230.0, 40.0, "", ""), 20.0).run();
    near(end_of(&mut run), 1.01, 0.011);
}

#[test]
fn a_meeting_that_cannot_be_reached_changes_the_speed_by_20_mps2() {
    let mut run = at_1_s(&meet(50.0, 900.0, "", ""), 0.0).run();
    near(run.to(1.5).lead().speed_mps, 10.0, 1e-6);
    near(run.lead().s_m, 62.5, 1e-6);
    near(end_of(&mut run), 2.01, 0.011);
    near(run.lead().speed_mps, 20.0, 0.3);
}

#[test]
fn entities_meet_on_a_curve() {
    let road = ROAD.replace("<line/>", "<arc curvature=\"0.005\"/>");
    let parts = at_1_s(&meet(230.0, 210.0, "", AS_THE_EGO), 0.0);
    let mut run = Parts { files: vec![("dir/road.xodr".to_owned(), road)], ..parts }.run();
    // The test moves the ego by 20 m/s along the reference line.
    near(run.to(11.0).lead().s_m, 210.0, 0.05);
    near(end_of(&mut run), 11.01, 0.011);
}

#[test]
fn senseless_values_are_refused() {
    let refused = |action: &str, expected: &str| {
        let shown = at_1_s(action, 20.0).refusal();
        assert!(shown.starts_with("dir/a.xosc:6:") && shown.contains(expected), "{shown}");
    };
    let position = "followingMode=\"position\"";
    refused(
        &profile(position, "", &[(1.0, None), (-1.0, None)]),
        "the speed -1 m/s is backwards, expected 0 or more, or an `entityRef`",
    );
    refused(&profile("followingMode=\"exact\"", "", &[(1.0, None)]), "`exact` is not supported");
    refused(&profile("", "", &[(1.0, None)]), "attribute `followingMode` of `SpeedProfileAction`");
    refused(&profile(position, "", &[]), "element `SpeedProfileEntry` in `SpeedProfileAction`");
    refused(&profile(position, "", &[(1.0, Some(-1.0))]), "-1 is out of range, expected 0 or more");
    refused(&profile(position, "", &[(1.0, Some(f64::NAN))]), "`NaN` is not a number");
    let own = format!("{position} entityRef=\"Lead\"");
    refused(&profile(&own, "", &[(1.0, None)]), "`Lead` would follow itself");
    let other = format!("{position} entityRef=\"Absent\"");
    refused(&profile(&other, "", &[(1.0, None)]), "there is no entity `Absent`");
    let zero = "<DynamicConstraints maxAcceleration=\"0\"/>";
    refused(&profile(position, zero, &[(1.0, None)]), "0 is out of range, expected more than 0");

    let own = meet(230.0, 160.0, "", "").replace("=\"Ego\"", "=\"Lead\"");
    refused(&own, "`Lead` would follow itself");
    refused(&meet(2e3, 160.0, "", ""), "2000 m are beyond the road's end");
    refused(&meet(230.0, 160.0, " targetTolerance=\"-1\"", ""), "-1 is out of range");
    refused(&meet(230.0, 160.0, "", "<AbsoluteSpeed value=\"-1\"/>"), "-1 is out of range");
    let steady = "<AbsoluteSpeed value=\"0\"><TargetTimeSteadyState time=\"1\"/></AbsoluteSpeed>";
    refused(&meet(230.0, 160.0, "", steady), "an entity that stands covers no last part");
    let factor = "<RelativeSpeedToMaster value=\"-1\" speedTargetValueType=\"factor\"/>";
    refused(&meet(230.0, 160.0, "", factor), "-1 is negative, expected 0 or more");
    let none = meet(230.0, 160.0, "", "").replace("TargetPosition>", "Target>");
    refused(&none, "element `Target` in `SynchronizeAction` is not supported");
}
