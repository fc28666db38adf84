//! Events, priorities, counts, edges, delays, states.

mod common;

use common::*;

fn slow_to(target: f64) -> String {
    speed("step", "time", 0.0, target)
}

fn time(edge: &str, delay: f64, value: f64) -> String {
    condition(
        edge,
        delay,
        &format!(
            "<ByValueCondition><SimulationTimeCondition value=\"{value}\" rule=\"greaterOrEqual\"/></ByValueCondition>"
        ),
    )
}

/// The instants at which the lead's speed changes, with the new speeds.
fn changes(parts: &Parts, until_s: f64) -> Vec<(f64, f64)> {
    let mut run = parts.run();
    let mut changes = Vec::new();
    let mut before = run.to(0.0).lead().speed_mps;
    for step in 1..=(until_s / STEP_S).round() as u64 {
        let time_s = step as f64 * STEP_S;
        let speed = run.to(time_s).lead().speed_mps;
        if speed != before {
            changes.push(((time_s * 100.0).round() / 100.0, speed));
        }
        before = speed;
    }
    changes
}

fn once(start: &str) -> Parts {
    let stories = story(&[event("E", "override", &[&slow_to(5.0)], &trigger(&[start]))]);
    Parts { stories, ..Parts::default() }
}

#[test]
fn edges_need_a_change_and_delays_come_after_them() {
    assert_eq!(changes(&once(&time("none", 0.0, 1.0)), 3.0), [(1.0, 5.0)]);
    assert_eq!(changes(&once(&time("rising", 0.0, 1.0)), 3.0), [(1.0, 5.0)]);
    assert_eq!(changes(&once(&time("rising", 0.5, 1.0)), 3.0), [(1.5, 5.0)]);
    assert_eq!(changes(&once(&time("none", 0.5, 1.0)), 3.0), [(1.5, 5.0)]);
    assert_eq!(changes(&once(&time("falling", 0.0, 1.0)), 3.0), []);
    assert_eq!(changes(&once(&time("risingOrFalling", 0.0, 1.0)), 3.0), [(1.0, 5.0)]);
    // A condition that holds from the first evaluation on has not risen.
    assert_eq!(changes(&once(&time("rising", 0.0, 0.0)), 3.0), []);
}

#[test]
fn groups_are_alternatives_and_their_conditions_go_together() {
    let both = trigger(&[&time("none", 0.0, 1.0), &time("none", 0.0, 2.0)]);
    let stories = story(&[event("E", "override", &[&slow_to(5.0)], &both)]);
    assert_eq!(changes(&Parts { stories, ..Parts::default() }, 4.0), [(2.0, 5.0)]);
    let either = trigger(&[&time("none", 0.0, 3.0)]) + &trigger(&[&time("none", 0.0, 1.5)]);
    let stories = story(&[event("E", "override", &[&slow_to(5.0)], &either)]);
    assert_eq!(changes(&Parts { stories, ..Parts::default() }, 4.0), [(1.5, 5.0)]);
    let stories = story(&[event("E", "override", &[&slow_to(5.0)], "")]);
    assert_eq!(changes(&Parts { stories, ..Parts::default() }, 4.0), []);
}

#[test]
fn priorities_override_skip_or_run_beside() {
    let long = speed("linear", "time", 4.0, 12.0);
    let second = |priority: &str| {
        let stories = story(&[
            event("First", "override", &[&long], &trigger(&[&at(1.0)])),
            event(
                "Second",
                priority,
                &[&lane_change("linear", "time", 1.0, "<AbsoluteTargetLane value=\"1\"/>")],
                &trigger(&[&at(2.0)]),
            ),
        ]);
        let mut run = Parts { stories, ..Parts::default() }.run();
        let lead = run.to(6.0).lead();
        (lead.speed_mps, lead.t_m)
    };
    assert_eq!(second("override"), (18.0, 2.0));
    assert_eq!(second("overwrite"), (18.0, 2.0));
    assert_eq!(second("skip"), (12.0, -2.0));
    assert_eq!(second("parallel"), (12.0, 2.0));
}

#[test]
fn a_newer_action_of_the_same_kind_takes_over() {
    let stories = story(&[
        event("First", "parallel", &[&speed("linear", "time", 4.0, 12.0)], &trigger(&[&at(1.0)])),
        event("Second", "parallel", &[&slow_to(3.0)], &trigger(&[&at(2.0)])),
        event(
            "Third",
            "parallel",
            &[&slow_to(1.0)],
            &trigger(&[&state("none", 0.0, "action", "FirstAction0", "stopTransition")]),
        ),
    ]);
    assert_eq!(changes(&Parts { stories, ..Parts::default() }, 6.0).last(), Some(&(2.0, 1.0)));
}

#[test]
fn states_and_transitions_of_elements_trigger_others() {
    let follow = |what: &str, kind: &str, name: &str, delay: f64| {
        let stories = story(&[
            event(
                "First",
                "parallel",
                &[&speed("linear", "time", 2.0, 10.0)],
                &trigger(&[&at(1.0)]),
            ),
            event(
                "Next",
                "parallel",
                &[&lane_change("step", "time", 0.0, "<AbsoluteTargetLane value=\"1\"/>")],
                &trigger(&[&state("rising", delay, kind, name, what)]),
            ),
        ]);
        let mut run = Parts { stories, ..Parts::default() }.run();
        (0..800).map(|step| f64::from(step) * STEP_S).find(|t| run.to(*t).lead().t_m > 0.0)
    };
    let near = |found: Option<f64>, expected: f64| {
        let found = found.expect("it happens");
        assert!((found - expected).abs() < 0.025, "{found} is not {expected}");
    };
    near(follow("runningState", "action", "FirstAction0", 0.0), 1.0);
    near(follow("startTransition", "event", "First", 0.0), 1.0);
    near(follow("endTransition", "action", "FirstAction0", 0.0), 3.0);
    near(follow("endTransition", "action", "FirstAction0", 2.0), 5.0);
    near(follow("completeState", "event", "First", 0.0), 3.0);
    near(follow("endTransition", "event", "Story::Act::Group::Maneuver::First", 0.0), 3.0);
}

#[test]
fn an_event_and_a_group_run_as_often_as_they_may() {
    let add = |name: &str, count: u32| {
        let action = "<Action name=\"add\"><GlobalAction><VariableAction variableRef=\"n\"><ModifyAction><Rule><AddValue value=\"1\"/></Rule></ModifyAction></VariableAction></GlobalAction></Action>";
        format!(
            "<Event name=\"{name}\" priority=\"parallel\" maximumExecutionCount=\"{count}\">{action}<StartTrigger>{}</StartTrigger></Event>",
            trigger(&[&at(0.5)])
        )
    };
    let head = "<VariableDeclarations><VariableDeclaration name=\"n\" variableType=\"double\" value=\"0\"/></VariableDeclarations>".to_owned();
    let counted = |event_count: u32, group_count: u32, expected: u32| {
        let reaches = condition(
            "none",
            0.0,
            &format!(
                "<ByValueCondition><VariableCondition variableRef=\"n\" value=\"{expected}\" rule=\"equalTo\"/></ByValueCondition>"
            ),
        );
        let stories = story_of("Lead", "Story", group_count, &[add("E", event_count)]);
        let mut parts =
            Parts { head: head.clone(), stories, stop: trigger(&[&reaches]), ..Parts::default() };
        let stops = parts.run().to(3.0).world.is_stopped();
        // One more is never reached.
        let beyond = reaches
            .replace(&format!("value=\"{expected}\""), &format!("value=\"{}\"", expected + 1));
        parts.stop = trigger(&[&beyond]);
        stops && !parts.run().to(3.0).world.is_stopped()
    };
    assert!(counted(1, 1, 1));
    assert!(counted(3, 1, 3));
    assert!(counted(2, 3, 6));
}

#[test]
fn an_act_that_is_stopped_ends_its_actions() {
    let stories = story(&[event(
        "E",
        "override",
        &[&speed("linear", "time", 10.0, 10.0)],
        &trigger(&[&at(1.0)]),
    )]);
    let stories = stories
        .replace("</Act>", &format!("<StopTrigger>{}</StopTrigger></Act>", trigger(&[&at(3.0)])));
    let mut run = Parts { stories, ..Parts::default() }.run();
    let speed = run.to(9.0).lead().speed_mps;
    assert!((speed - 18.0).abs() < 0.02, "{speed}");
}

#[test]
fn the_stop_trigger_ends_the_storyboard() {
    let mut parts = once(&time("none", 0.0, 5.0));
    parts.stop = trigger(&[&time("rising", 1.0, 2.0)]);
    let mut run = parts.run();
    assert!(!run.to(2.99).world.is_stopped());
    assert!(run.to(3.0).world.is_stopped());
    assert_eq!(run.to(6.0).lead().speed_mps, 20.0);
}

#[test]
fn the_ego_is_never_moved_and_its_actions_take_their_time() {
    let slow = story_of(
        "Ego",
        "Story",
        1,
        &[event("E", "override", &[&speed("linear", "time", 2.0, 5.0)], &trigger(&[&at(1.0)]))],
    );
    let parts = Parts {
        stories: slow,
        stop: trigger(&[&state("none", 0.0, "event", "E", "completeState")]),
        ..Parts::default()
    };
    let read = parts.read().expect("it is right");
    assert!(
        read.notices.iter().any(|notice| notice.contains("actions of the ego")),
        "{:?}",
        read.notices
    );
    let mut run = parts.run();
    assert!(!run.to(2.9).world.is_stopped());
    assert!(run.to(3.02).world.is_stopped());
    assert_eq!(run.of_entity("Ego").speed_mps, 20.0);
}

#[test]
fn a_restored_world_goes_on_the_same_way() {
    let mut parts = once(&time("rising", 0.5, 1.0));
    parts.stories = story(&[event(
        "E",
        "parallel",
        &[
            &speed("sinusoidal", "time", 3.0, 5.0),
            &lane_change("cubic", "time", 2.0, "<AbsoluteTargetLane value=\"1\"/>"),
        ],
        &trigger(&[&time("rising", 0.5, 1.0)]),
    )]);
    let mut whole = parts.run();
    whole.to(2.2);
    let mut bytes = [0; 4096];
    let used = postcard::to_slice(whole.world.state(), &mut bytes).expect("it can be written");
    let mut fresh = parts.run();
    fresh.world.restore(postcard::from_bytes(used).expect("it can be read"));
    let ego = whole.ego;
    for step in 221..400u64 {
        for run in [&mut whole, &mut fresh] {
            run.world.observe(0, ego);
            run.world.step(step * 10_000_000);
        }
        assert_eq!(whole.lead(), fresh.lead());
    }
}

#[test]
fn a_script_survives_being_written_down() {
    let mut parts = once(&time("rising", 0.5, 1.0));
    parts.stop = trigger(&[&state("rising", 1.0, "event", "E", "completeState")]);
    let script = parts.read().expect("it is right").script;
    let text = toml::to_string(&script).expect("it can be written");
    assert_eq!(
        toml::from_str::<openscenario::Script>(&text).expect("it can be read"),
        script,
        "{text}"
    );
}

/// A catalog's maneuver that several groups use means its own events, and each group follows its own.
#[test]
fn of_several_parts_of_a_name_the_nearest_counts() {
    let first = |value: f64, after_s: f64| {
        event("E", "parallel", &[&speed("step", "time", 0.0, value)], &trigger(&[&at(after_s)]))
    };
    let next = |value: f64| {
        let start = trigger(&[&state("none", 0.0, "event", "E", "completeState")]);
        event("F", "parallel", &[&speed("step", "time", 0.0, value)], &start)
    };
    let stories = story_of("Lead", "One", 1, &[first(5.0, 1.0), next(6.0)])
        + &story_of("Lead", "Two", 1, &[first(7.0, 2.0), next(8.0)]);
    let mut run = Parts { stories, ..Parts::default() }.run();
    assert_eq!(run.to(1.5).lead().speed_mps, 6.0);
    assert_eq!(run.to(2.5).lead().speed_mps, 8.0);
}

/// A story whose act starts and whose events never do has not happened.
#[test]
fn an_act_without_a_started_event_is_named() {
    let far = event("E", "parallel", &[&speed("step", "time", 0.0, 1.0)], &trigger(&[&at(2.0)]));
    let mut run = Parts { stories: story(&[far]), ..Parts::default() }.run();
    assert_eq!(run.to(1.9).world.unstarted_acts().collect::<Vec<_>>(), ["Act"]);
    assert_eq!(run.to(2.1).world.unstarted_acts().count(), 0);
}
