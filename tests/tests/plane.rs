//! A road in the plane: what it leaves as it is, and what does not depend on where it lies.

use std::collections::BTreeMap;
use std::time::Duration;

use group::in_process;
use report::summary::Summary;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use serde_json::{Value, json};

/// Topics that exist on a road with a plan alone.
const OF_THE_PLANE: [&str; 5] =
    ["vehicle/lateral", "truth/pose", "truth/poses", "radar/course", "v2x/curves"];

/// A straight road on which nothing acts that a scenario without the plane lacks.
const STRAIGHT: &str = "\n[road.plan]\npieces = [{ line_m = 5000 }]\n[plant.lateral]\nmodel = \
    \"on-axis\"\n[perception.course]\nsources = []\n[controller.curve_speed]\n\
    enabled = false\n";

/// Digests of 12 s in one process, by topic.
fn digests(name: &str, toml: &str) -> BTreeMap<String, Value> {
    let mut overrides = Overrides::new();
    overrides.option("--duration", "duration_s", "12");
    let scenario = Scenario::parse_with(name, toml, &overrides, &controller::laws::check)
        .unwrap_or_else(|error| panic!("{error}"));
    let group = in_process::run(&scenario).expect("it runs");
    let summary = Summary::new(&scenario, Mode::Lockstep, &group, Duration::ZERO);
    let topics = summary.messages.into_iter();
    topics.map(|(topic, counts)| (topic, json!(counts.digests))).collect()
}

fn without(mut digests: BTreeMap<String, Value>, topics: &[&str]) -> BTreeMap<String, Value> {
    digests.retain(|topic, _| !topics.contains(&topic.as_str()));
    digests
}

fn builtin(name: &str) -> String {
    scenario::builtin::find(name).expect("it is built in").text.to_owned()
}

#[test]
fn a_straight_plan_changes_no_byte_of_an_old_topic() {
    for name in ["cut-in", "following", "corridor"] {
        let text = builtin(name);
        let plain = digests(name, &text);
        assert!(OF_THE_PLANE.iter().all(|topic| !plain.contains_key(*topic)), "{name}");
        let planned = digests(&format!("{name}-plan"), &(text + STRAIGHT));
        for topic in ["vehicle/lateral", "truth/pose", "truth/poses"] {
            assert!(planned.contains_key(topic), "{name}: {topic}");
        }
        assert_eq!(without(planned, &OF_THE_PLANE), plain, "{name}");
    }
}

/// A scene with a lead and a neighbour on a road of curves.
fn curves(start: &str) -> String {
    let actor = |name: &str, lateral_m: f64| {
        format!(
            "[[actors]]\nname = \"{name}\"\ngap_m = 50\ninitial_speed_mps = 20\nlateral_offset_m = \
             {lateral_m:?}\n"
        )
    };
    format!(
        "schema_version = 1\nname = \"curves\"\nset_speed_mps = 22\nplant.initial_speed_mps = 20\n\
         {}{}\
         [road.plan]\nstart = {{ {start} }}\npieces = [{{ line_m = 60 }}, {{ spiral_m = 60 }}, \
         {{ arc_m = 200, radius_m = 300, turn = \"left\" }}, {{ spiral_m = 80 }}, \
         {{ arc_m = 200, radius_m = 250, turn = \"right\" }}]\n",
        actor("lead", 0.0),
        actor("neighbour", 3.5),
    )
}

#[test]
fn a_drive_does_not_depend_on_where_the_road_lies() {
    let here = digests("here", &curves("x_m = 0"));
    let there = digests("there", &curves("x_m = 4321.5, y_m = -77, heading_deg = 137"));
    const POSES: [&str; 2] = ["truth/pose", "truth/poses"];
    for topic in POSES {
        assert_ne!(here[topic], there[topic], "{topic}");
    }
    assert_eq!(without(here, &POSES), without(there, &POSES));
}
