//! A road in the plane: what it leaves as it is, and what does not depend on where it lies.

use std::collections::BTreeMap;
use std::time::Duration;

use report::summary::Summary;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use serde_json::{Value, json};
use supervise::in_process;

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
    overrides.option("--duration", "duration_s", 12);
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

/// A scene without noise on a road whose first curve turns to one side, with a neighbour on that side.
fn curves_to(side: f64) -> Scenario {
    let [first, second] = if side > 0.0 { ["left", "right"] } else { ["right", "left"] };
    let text = format!(
        "schema_version = 1\nname = \"mirror\"\nduration_s = 20\nset_speed_mps = 22\n\
         [plant]\ninitial_speed_mps = 20\n\
         [plant.lateral]\ndriver = {{ wander_m = 0 }}\n\
         yaw_rate = {{ offset_sigma_dps = 0, noise_dps = 0 }}\n\
         [perception.course]\nsources = [\"yaw-rate\"]\n\
         [perception.radar]\nmodel = \"object-list\"\nrange_sigma_m = 0\nrange_rate_sigma_mps = 0\n\
         azimuth_sigma_deg = 0\ndropout_probability = 0\n\
         [road.plan]\npieces = [{{ line_m = 60 }}, {{ spiral_m = 60 }}, \
         {{ arc_m = 200, radius_m = 300, turn = \"{first}\" }}, {{ spiral_m = 80 }}, \
         {{ arc_m = 200, radius_m = 250, turn = \"{second}\" }}]\n\
         [[actors]]\nname = \"lead\"\ngap_m = 35\ninitial_speed_mps = 20\n\
         profile = {{ sine = {{ amplitude_mps2 = 0.8, period_s = 8 }} }}\n\
         [[actors]]\nname = \"neighbour\"\ngap_m = 30\ninitial_speed_mps = 20\n\
         lateral_offset_m = {:?}\n",
        3.5 * side
    );
    let checked =
        Scenario::parse_with("mirror", &text, &Overrides::new(), &controller::laws::check);
    checked.unwrap_or_else(|error| panic!("{error}"))
}

/// Left and right are the same to every model: across the road all signs change, along it no bit. The belief about the
/// road draws at random, so that the course is by the yaw rate alone here.
#[test]
fn a_mirrored_world_gives_the_mirrored_drive() {
    let [left, right] =
        [1.0, -1.0].map(|side| in_process::run(&curves_to(side)).expect("it runs").drive);
    assert!(left.steps.iter().any(|step| step.acceleration_mps2 < -0.2), "the law acts");
    assert_eq!(left.steps, right.steps);
    assert!(left.plane.len() > 300 && left.plane.len() == right.plane.len());
    let turned = |a: f64, b: f64| (a + b).abs() < 1e-9;
    let mut most_mps2 = 0.0f64;
    for (one, other) in left.plane.iter().zip(&right.plane) {
        let (a, b) = (&one.ego, &other.ego);
        assert_eq!((one.time_s, a.x_m), (other.time_s, b.x_m));
        for (a, b) in [
            (a.y_m, b.y_m),
            (a.heading_rad, b.heading_rad),
            (a.lateral_m, b.lateral_m),
            (a.curvature_perm, b.curvature_perm),
            (a.lateral_acceleration_mps2, b.lateral_acceleration_mps2),
        ] {
            assert!(turned(a, b), "{a} and {b} at {} s", one.time_s);
        }
        most_mps2 = most_mps2.max(a.lateral_acceleration_mps2.abs());
        for (a, b) in one.bodies.iter().zip(&other.bodies) {
            assert!(a.x_m == b.x_m && turned(a.y_m, b.y_m), "bodies at {} s", one.time_s);
        }
        let [a, b] = [one, other].map(|scene| scene.seen.and_then(|seen| seen.target));
        assert_eq!(a.map(|a| (a.x_m, a.gap_m)), b.map(|b| (b.x_m, b.gap_m)), "{} s", one.time_s);
        assert!(a.zip(b).is_none_or(|(a, b)| turned(a.y_m, b.y_m)), "{a:?} and {b:?}");
    }
    assert!(most_mps2 > 1.0, "it drives through the curves: {most_mps2} m/s²");
}

/// The examples of curves drive to their end, and their lanes are where their files put them.
#[test]
fn the_examples_of_curves_drive() {
    for (name, least_mps2) in [("exit", 1.0), ("two_roads", 0.8)] {
        let mut overrides = Overrides::new();
        overrides.option("--radar", "perception.radar.model", "ideal");
        let file = format!("{}/../examples/curves/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let opened = Scenario::open(&file, &overrides, &controller::laws::check);
        let scenario = opened.unwrap_or_else(|error| panic!("{error}"));
        let drive = in_process::run(&scenario).expect("it runs").drive;
        let last = drive.steps.last().expect("it drives");
        assert!(
            (last.time_s - scenario.duration_s.value()).abs() < 0.011,
            "{name}: {}",
            last.time_s
        );
        let lateral = drive.plane.iter().map(|scene| scene.ego.lateral_acceleration_mps2.abs());
        let most_mps2 = lateral.reduce(f64::max).expect("a plane");
        assert!(most_mps2 > least_mps2, "{name}: it drives through its curves: {most_mps2}");
    }
}
