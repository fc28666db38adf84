//! Each condition holds when it should.

mod common;

use common::*;

/// Time when a condition first holds, to the step. The lead is 50 m ahead at 20 m/s, and the ego at
/// `ego`.
fn holds(condition: &str, ego_mps: f64, until_s: f64) -> Option<f64> {
    let parts = Parts { stop: trigger(&[condition]), ..Parts::default() };
    let mut run = parts.run();
    run.ego.speed_mps = ego_mps;
    (0..=(until_s / STEP_S) as u64)
        .map(|k| k as f64 * STEP_S)
        .find(|t| run.to(*t).world.is_stopped())
}

#[track_caller]
fn first(condition: &str, ego_mps: f64, expected_s: f64) {
    let found = holds(condition, ego_mps, 20.0).expect("it holds at some time");
    assert!((found - expected_s).abs() <= 1.5 * STEP_S, "{found} is not {expected_s}");
}

fn never(condition: &str, ego_mps: f64) {
    assert_eq!(holds(condition, ego_mps, 10.0), None);
}

#[test]
fn distances_are_between_boxes_or_origins() {
    let distance = |kind: &str, freespace: bool, value: f64, system: &str| {
        by_entity(
            "none",
            0.0,
            "Ego",
            &format!(
                "<RelativeDistanceCondition entityRef=\"Lead\" relativeDistanceType=\"{kind}\" value=\"{value}\" freespace=\"{freespace}\" rule=\"lessThan\" coordinateSystem=\"{system}\"/>"
            ),
        )
    };
    // Origins 50 m apart, boxes 46 m, closing at 10 m/s.
    first(&distance("longitudinal", false, 30.0, "entity"), 30.0, 2.0);
    first(&distance("longitudinal", true, 30.0, "road"), 30.0, 1.6);
    first(&distance("euclidianDistance", true, 30.0, "entity"), 30.0, 1.6);
    first(&distance("cartesianDistance", false, 30.0, "entity"), 30.0, 2.0);
    first(&distance("lateral", false, 0.1, "lane"), 20.0, 0.0);
    // Overlapping boxes are 0 apart, which is not less than 0.
    never(&distance("longitudinal", true, 0.0, "entity"), 30.0);
    let to_place = by_entity(
        "none",
        0.0,
        "Ego",
        "<DistanceCondition value=\"10\" freespace=\"true\" rule=\"lessThan\"><Position><LanePosition roadId=\"0\" laneId=\"-1\" s=\"60\"/></Position></DistanceCondition>",
    );
    // The front is 3 m ahead of the origin at 10 m.
    first(&to_place, 20.0, (60.0 - 13.0 - 10.0) / 20.0);
}

#[test]
fn times_divide_by_speed_or_closing_speed() {
    let headway = |rule: &str, value: f64| {
        by_entity(
            "none",
            0.0,
            "Ego",
            &format!(
                "<TimeHeadwayCondition entityRef=\"Lead\" value=\"{value}\" freespace=\"true\" rule=\"{rule}\" coordinateSystem=\"road\" relativeDistanceType=\"longitudinal\"/>"
            ),
        )
    };
    first(&headway("lessThan", 1.0), 30.0, 1.6);
    never(&headway("lessThan", 1e9), 0.0);
    first(&headway("greaterThan", 100.0), 0.0, 0.0);
    let ttc = |rule: &str, value: f64| {
        by_entity(
            "none",
            0.0,
            "Ego",
            &format!(
                "<TimeToCollisionCondition value=\"{value}\" freespace=\"true\" rule=\"{rule}\"><TimeToCollisionConditionTarget><EntityRef entityRef=\"Lead\"/></TimeToCollisionConditionTarget></TimeToCollisionCondition>"
            ),
        )
    };
    first(&ttc("lessThan", 2.0), 30.0, 2.6);
    never(&ttc("lessThan", 1e9), 20.0);
}

#[test]
fn motion_itself_is_watched() {
    let ego = |inside: &str| by_entity("none", 0.0, "Ego", inside);
    first(&ego("<SpeedCondition value=\"19\" rule=\"greaterThan\"/>"), 20.0, 0.0);
    never(&ego("<SpeedCondition value=\"21\" rule=\"greaterThan\"/>"), 20.0);
    first(
        &ego("<RelativeSpeedCondition entityRef=\"Lead\" value=\"-5\" rule=\"lessThan\"/>"),
        10.0,
        0.0,
    );
    never(&ego("<AccelerationCondition value=\"0.5\" rule=\"greaterThan\"/>"), 20.0);
    first(&ego("<TraveledDistanceCondition value=\"50\"/>"), 20.0, 2.5);
    first(&ego("<StandStillCondition duration=\"3\"/>"), 0.0, 3.0);
    never(&ego("<StandStillCondition duration=\"3\"/>"), 0.1);
    first(
        &ego(
            "<ReachPositionCondition tolerance=\"1\"><Position><WorldPosition x=\"60\" y=\"-2\"/></Position></ReachPositionCondition>",
        ),
        20.0,
        2.45,
    );
    first(
        &ego("<CollisionCondition><EntityRef entityRef=\"Lead\"/></CollisionCondition>"),
        30.0,
        4.61,
    );
    first(&ego("<CollisionCondition><ByType type=\"vehicle\"/></CollisionCondition>"), 30.0, 4.61);
    never(&ego("<CollisionCondition><ByType type=\"pedestrian\"/></CollisionCondition>"), 30.0);
    never(&ego("<OffroadCondition duration=\"0\"/>"), 20.0);
    // 990 m to the end at 100 m/s.
    first(&ego("<EndOfRoadCondition duration=\"1\"/>"), 100.0, 10.9);
}

#[test]
fn parameters_and_variables_are_compared() {
    let parameters = "<ParameterDeclarations><ParameterDeclaration name=\"p\" parameterType=\"string\" value=\"off\"/></ParameterDeclarations>";
    let head = "<VariableDeclarations><VariableDeclaration name=\"n\" variableType=\"double\" value=\"2\"/></VariableDeclarations>";
    let set = "<Event name=\"E\" priority=\"parallel\"><Action name=\"a\"><GlobalAction><ParameterAction parameterRef=\"p\"><SetAction value=\"on\"/></ParameterAction></GlobalAction></Action>\
        <Action name=\"b\"><GlobalAction><VariableAction variableRef=\"n\"><ModifyAction><Rule><MultiplyByValue value=\"1.5\"/></Rule></ModifyAction></VariableAction></GlobalAction></Action>";
    let events = [format!("{set}<StartTrigger>{}</StartTrigger></Event>", trigger(&[&at(1.0)]))];
    let both = [
        condition(
            "none",
            0.0,
            "<ByValueCondition><ParameterCondition parameterRef=\"p\" value=\"on\" rule=\"equalTo\"/></ByValueCondition>",
        ),
        condition(
            "none",
            0.0,
            "<ByValueCondition><VariableCondition variableRef=\"n\" value=\"3\" rule=\"greaterOrEqual\"/></ByValueCondition>",
        ),
    ];
    let mut run = Parts {
        parameters: parameters.to_owned(),
        head: head.to_owned(),
        stories: story(&events),
        stop: trigger(&[&both[0], &both[1]]),
        ..Parts::default()
    }
    .run();
    assert!(!run.to(0.99).world.is_stopped());
    assert!(run.to(1.02).world.is_stopped());
}

#[test]
fn any_and_all_of_several_entities() {
    let of = |rule: &str| {
        condition(
            "none",
            0.0,
            &format!(
                "<ByEntityCondition><TriggeringEntities triggeringEntitiesRule=\"{rule}\"><EntityRef entityRef=\"Ego\"/><EntityRef entityRef=\"Lead\"/></TriggeringEntities>\
             <EntityCondition><SpeedCondition value=\"25\" rule=\"greaterThan\"/></EntityCondition></ByEntityCondition>"
            ),
        )
    };
    first(&of("any"), 30.0, 0.0);
    never(&of("all"), 30.0);
}

#[test]
fn conditions_on_no_parameter_are_left_out_with_a_notice() {
    let compare = |name: &str, parameter: &str| {
        format!(
            "<Condition name=\"{name}\" delay=\"0\" conditionEdge=\"none\"><ByValueCondition>\
             <ParameterCondition parameterRef=\"{parameter}\" value=\"\" rule=\"lessThan\"/></ByValueCondition></Condition>"
        )
    };
    let with = |name: &str, parameter: &str| Parts {
        stop: trigger(&[&compare(name, parameter), &at(1.0)]),
        ..Parts::default()
    };
    for (name, parameter) in [("c", ""), ("criteria_DrivenDistanceTest", "distance_success")] {
        let parts = with(name, parameter);
        let notices = parts.read().expect("it is readable").notices;
        assert!(notices.iter().any(|notice| notice.contains("left out")), "{notices:?}");
        let mut run = parts.run();
        assert!(!run.to(0.98).world.is_stopped() && run.to(1.02).world.is_stopped());
    }
    let shown = with("c", "distance_success").refusal();
    assert!(shown.contains("`distance_success` is not declared"), "{shown}");
}

#[test]
fn an_act_that_never_starts_is_named() {
    let events =
        [event("E", "override", &[&speed("step", "time", 0.0, 5.0)], &trigger(&[&at(0.0)]))];
    let stories = story(&events).replace(&trigger(&[&at(0.0)]), &trigger(&[&at(3.0)]));
    let mut run = Parts { stories, ..Parts::default() }.run();
    assert_eq!(run.to(2.9).world.unstarted_acts().collect::<Vec<_>>(), ["Act"]);
    assert_eq!(run.to(3.1).world.unstarted_acts().count(), 0);
}

#[test]
fn an_empty_start_trigger_means_at_once() {
    let events = [event("E", "override", &[&speed("step", "time", 0.0, 5.0)], "")];
    let stories = story(&events).replace(&trigger(&[&at(0.0)]), "");
    let parts = Parts { stories, ..Parts::default() };
    let notices = parts.read().expect("it is readable").notices;
    let noted = notices.iter().filter(|notice| notice.contains("its start trigger is empty"));
    assert_eq!(noted.count(), 2, "{notices:?}");
    assert_eq!(parts.run().to(0.1).lead().speed_mps, 5.0);
}

#[test]
fn a_headway_to_an_entity_behind_does_not_exist() {
    let headway = |who: &str, other: &str, rule: &str| {
        by_entity(
            "none",
            0.0,
            who,
            &format!(
                "<TimeHeadwayCondition entityRef=\"{other}\" value=\"0.4\" freespace=\"false\" \
                 coordinateSystem=\"road\" relativeDistanceType=\"longitudinal\" rule=\"{rule}\"/>"
            ),
        )
    };
    // The lead begins 50 m ahead; the ego's 100 m/s bring it past the lead after 0.625 s.
    first(&headway("Ego", "Lead", "greaterThan"), 100.0, 0.0);
    never(&headway("Lead", "Ego", "greaterThan"), 20.0);
    never(&headway("Lead", "Ego", "lessThan"), 20.0);
    first(&headway("Lead", "Ego", "greaterThan"), 100.0, 0.73);
}

/// Time at which the part of the road around an entity is no longer clear.
fn taken(entity: &str, given: &str, inside: &str, lead_lane: i32) -> Option<f64> {
    let test = format!("<RelativeClearanceCondition {given}>{inside}</RelativeClearanceCondition>");
    let init = private("Lead", &[&place(lead_lane, 60.0), &speed("step", "time", 0.0, 20.0)]);
    let stop = trigger(&[&by_entity("falling", 0.0, entity, &test)]);
    let mut run = Parts { stop, init, ..Parts::default() }.run();
    run.ego.speed_mps = 30.0;
    let times = (0..=800).map(|k| f64::from(k) * STEP_S);
    times.into_iter().find(|t| run.to(*t).world.is_stopped())
}

#[test]
fn a_clearance_is_of_lanes_and_distances() {
    let given = |opposite: bool, freespace: bool, more: &str| {
        format!("oppositeLanes=\"{opposite}\" freeSpace=\"{freespace}\" {more}")
    };
    let near = |found: Option<f64>, expected_s: f64| {
        let found = found.expect("it is taken at some time");
        assert!((found - expected_s).abs() <= 1.5 * STEP_S, "{found} is not {expected_s}");
    };
    let ahead = "distanceForward=\"30\"";
    // 50 m apart, closing at 10 m/s; the lead's rear is 1 m behind its origin, the ego's front 3 m ahead of its own.
    near(taken("Ego", &given(false, false, ahead), "", -1), 2.0);
    near(taken("Ego", &given(false, true, ahead), "", -1), 1.9);
    let behind = given(false, true, "distanceBackward=\"30\"");
    near(taken("Lead", &behind, "", -1), 1.7);
    let own = "<RelativeLaneRange from=\"0\" to=\"0\"/>";
    near(taken("Ego", &given(false, false, ahead), own, -1), 2.0);
    for (lane, range) in [(-1, "from=\"1\""), (-2, "to=\"-2\""), (-2, "from=\"0\" to=\"0\"")] {
        let range = format!("<RelativeLaneRange {range}/>");
        assert_eq!(taken("Ego", &given(false, false, ahead), &range, lane), None);
    }
    near(taken("Ego", &given(false, false, ahead), "<RelativeLaneRange to=\"-1\"/>", -2), 2.0);
    // Lane 1 is on the left and of the other direction.
    assert_eq!(taken("Ego", &given(false, false, ahead), "", 1), None);
    near(taken("Ego", &given(true, false, ahead), "<RelativeLaneRange from=\"1\"/>", 1), 2.0);
    let (lead, walker) =
        ["Lead", "Walker"].map(|name| format!("<EntityRef entityRef=\"{name}\"/>")).into();
    near(taken("Ego", &given(false, false, ahead), &lead, -1), 2.0);
    assert_eq!(taken("Ego", &given(false, false, ahead), &walker, -1), None);
}
