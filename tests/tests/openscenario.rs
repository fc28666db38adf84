//! OpenSCENARIO files: storyboard, variation, refusals.

use serde_json::Value;
use std::path::{Path, PathBuf};
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/openscenario")
}

/// A corner with the example files.
fn corner() -> Corner {
    let corner = Corner::new(PROGRAM);
    copy(&examples(), &corner.path().join("examples"));
    corner
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("our own directory");
    for entry in std::fs::read_dir(from).expect("it is in the repository") {
        let path = entry.expect("it is readable").path();
        let target = to.join(path.file_name().expect("it has a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).expect("our own directory");
        }
    }
}

fn lockstep(corner: &Corner, file: &str, more: &[&str]) -> Value {
    let arguments = [&["run", file, "--mode", "lockstep"], more].concat();
    corner.json(&arguments)
}

#[test]
fn a_cut_in_happens_at_its_gap_and_ends_the_run() {
    let corner = corner();
    let file = "examples/cut_in.xosc";
    let summary = lockstep(&corner, file, &["--out", "a"]);
    assert_eq!(summary["scenario"], "cut_in");
    assert_eq!(summary["outcome"], "completed");
    let duration_s = summary["duration_s"].as_f64().expect("a time");
    assert!((10.0..60.0).contains(&duration_s), "the stop trigger ends the run: {duration_s}");
    // The cut-in is in the path from about half of the lane change. Most of the 30 m gap is left then.
    let gap_m = summary["control"]["min_gap_m"].as_f64().expect("a gap");
    assert!((5.0..30.0).contains(&gap_m), "{gap_m}");
    // The effective scenario is kept, and runs by itself.
    let kept = std::fs::read_to_string(corner.path().join("a/scenario.toml")).expect("it is kept");
    assert!(kept.contains("Ego_Speed_kph = \"90\""), "{kept}");
    std::fs::remove_dir_all(corner.path().join("examples")).expect("our own directory");
    let again = lockstep(&corner, "a/scenario.toml", &["--out", "b"]);
    assert_eq!(again["messages"], summary["messages"]);
    assert!(corner.roots().is_empty());
}

/// The same on a road of curves and grades: the ego drives the curve, and so does the storyboard's car.
#[test]
fn a_cut_in_happens_in_a_curve() {
    let corner = corner();
    let road = corner.path().join("examples/straight.xodr");
    let straight = std::fs::read_to_string(&road).expect("it is there");
    let heights = "<elevationProfile><elevation s=\"0\" a=\"10\" b=\"0.01\" c=\"0\" d=\"0\"/></elevationProfile>";
    let curved = straight
        .replace("<line/>", "<arc curvature=\"0.001\"/>")
        .replace("<lanes>", &format!("{heights}<lanes>"));
    std::fs::write(&road, curved).expect("our own directory");
    let summary = lockstep(&corner, "examples/cut_in.xosc", &["--out", "a"]);
    assert_eq!(summary["outcome"], "completed");
    let gap_m = summary["control"]["min_gap_m"].as_f64().expect("a gap");
    assert!((5.0..30.0).contains(&gap_m), "{gap_m}");
    let kept = std::fs::read_to_string(corner.path().join("a/scenario.toml")).expect("it is kept");
    assert!(kept.contains("[road.plan") && kept.contains("of_storyboard = true"), "{kept}");
    let again = lockstep(&corner, "a/scenario.toml", &["--out", "b"]);
    assert_eq!(again["messages"], summary["messages"]);
    // The same file as a plan, for a scenario of one's own.
    let own = "schema_version = 1\nname = \"own\"\nduration_s = 10\nset_speed_mps = 20\n\
               [plant]\ninitial_speed_mps = 20\n\
               [road.plan]\nopendrive = { file = \"straight.xodr\", road = \"1\", lane = -2, s_m = 50 }\n";
    std::fs::write(corner.path().join("examples/own.toml"), own).expect("our own directory");
    let summary = lockstep(&corner, "examples/own.toml", &["--out", "c"]);
    assert_eq!(summary["outcome"], "completed");
    let kept = std::fs::read_to_string(corner.path().join("c/scenario.toml")).expect("it is kept");
    // Lane -2 of three: one to the left, one to the right.
    assert!(kept.contains("left = 1") && kept.contains("right = 1"), "{kept}");
    assert!(kept.contains("points = ["), "its heights: {kept}");
    let wrong = own.replace("lane = -2", "lane = 4");
    std::fs::write(corner.path().join("examples/wrong.toml"), wrong).expect("our own directory");
    let output = corner.run(&["run", "examples/wrong.toml"]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output);
    assert!(said.contains("straight.xodr:5:3: road `1` has no lane `4` at s = 50 m"), "{said}");
}

/// The same in TOML: an actor beside the ego cuts in when the ego is 30 m behind.
#[test]
fn an_actor_of_a_toml_scenario_cuts_in_at_30_m() {
    const SCENE: &str = r#"
schema_version = 1
name = "cut-in-at-30"
duration_s = 20
set_speed_mps = 25
[plant]
initial_speed_mps = 25
[[actors]]
name = "car"
gap_m = 80
initial_speed_mps = 20
lateral_offset_m = -3.5
[[actors.events]]
name = "cut-in"
when = { gap_below_m = 30 }
lateral = { to_m = 0, duration_s = 1, shape = "linear" }
[[actors.events]]
when = { completed = "cut-in" }
delay_s = 3
speed = { to_mps = 15, rate_mps2 = 2 }
"#;
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("mine.toml"), SCENE).expect("our own directory");
    let summary = lockstep(&corner, "mine.toml", &["--out", "a"]);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let table = std::fs::read_to_string(corner.path().join("a/trajectory.csv")).expect("written");
    let rows = system_tests::csv(&table, &["time_s", "gap_m", "lead_speed_mps"]);
    let first = rows.iter().find(|row| !row[1].is_nan()).expect("it is in the lane at last");
    // Half of the 1 s cut-in has passed, at a closing speed of 5 m/s.
    assert!((24.0..30.0).contains(&first[1]), "in the lane at {} m, {} s", first[1], first[0]);
    assert!((9.5..12.0).contains(&first[0]), "80 - 5 t = 30 at 10 s: {}", first[0]);
    let last = rows.last().expect("rows");
    assert!((last[2] - 15.0).abs() < 0.1, "the second event: {} m/s", last[2]);
}

#[test]
fn parameters_change_what_happens() {
    let corner = corner();
    let file = "examples/cut_in.xosc";
    let wide = lockstep(&corner, file, &["--param", "Gap_m=60"]);
    let narrow = lockstep(&corner, file, &["--param", "Gap_m=15", "--param", "Model=lorry"]);
    let gap = |summary: &Value| summary["control"]["min_gap_m"].as_f64().expect("a gap");
    assert!(gap(&wide) > gap(&narrow) + 10.0, "{} {}", gap(&wide), gap(&narrow));
    let shown = corner.run(&["list", "--show", file, "--param", "Model=lorry"]);
    assert!(shown.status.success() && text(&shown).contains("length_m = 12.0"), "{}", text(&shown));
}

/// The car arrives 35 m ahead of the ego with its speed, of which a car's length is no gap, and moves into its lane.
#[test]
fn a_car_arrives_ahead_of_the_ego_and_joins_it() {
    let corner = corner();
    let summary = lockstep(&corner, "examples/joining_car.xosc", &["--out", "a"]);
    assert_eq!(summary["outcome"], "completed");
    let gap_m = summary["control"]["min_gap_m"].as_f64().expect("a gap");
    assert!((29.0..31.5).contains(&gap_m), "{gap_m}");
}

/// A car from the side turns into the ego's road ahead of it, and another one crosses it.
#[test]
fn a_car_turns_off_at_a_crossing_into_the_egos_road() {
    let corner = corner();
    let summary = lockstep(&corner, "examples/crossing.xosc", &["--out", "a"]);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let gap_m = summary["control"]["min_gap_m"].as_f64().expect("a gap");
    assert!((5.0..40.0).contains(&gap_m), "{gap_m}");
    let table = std::fs::read_to_string(corner.path().join("a/trajectory.csv")).expect("written");
    let rows = system_tests::csv(&table, &["time_s", "lead_speed_mps"]);
    let last = rows.last().expect("rows");
    assert!((last[1] - 14.0).abs() < 0.1, "it has sped up on the ego's road: {} m/s", last[1]);
    let kept = std::fs::read_to_string(corner.path().join("a/scenario.toml")).expect("it is kept");
    let again = lockstep(&corner, "a/scenario.toml", &["--out", "b"]);
    assert_eq!(again["messages"], summary["messages"]);
    assert!(kept.contains("the way leads over the roads `3`, `32`, `2`"), "{kept}");
}

/// 64 cars beside the ego: the most that a scenario has.
#[test]
fn a_file_has_as_many_entities_as_a_scenario_has_actors() {
    let corner = corner();
    let path = corner.path().join("examples/cut_in.xosc");
    let good = std::fs::read_to_string(&path).expect("it is there");
    let with = |count: usize| {
        let (mut objects, mut starts) = (String::new(), String::new());
        for i in 0..count {
            let s_m = 150 + 15 * i;
            objects += &format!(
                "<ScenarioObject name=\"More{i}\"><CatalogReference catalogName=\"road_users\" entryName=\"car\"/></ScenarioObject>"
            );
            starts += &format!(
                "<Private entityRef=\"More{i}\"><PrivateAction><TeleportAction><Position><LanePosition roadId=\"1\" laneId=\"-1\" s=\"{s_m}\"/></Position></TeleportAction></PrivateAction></Private>"
            );
        }
        good.replace("</Entities>", &format!("{objects}</Entities>"))
            .replace("</Actions>", &format!("{starts}</Actions>"))
    };
    std::fs::write(&path, with(63)).expect("our own directory");
    let summary = lockstep(&corner, "examples/cut_in.xosc", &["--duration", "6"]);
    assert_eq!(summary["outcome"], "completed");
    std::fs::write(&path, with(64)).expect("our own directory");
    let output = corner.run(&["run", "examples/cut_in.xosc"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output).contains("too many entities, expected at most 65"), "{}", text(&output));
}

#[test]
fn the_user_names_the_ego() {
    let corner = corner();
    let path = corner.path().join("examples/cut_in.xosc");
    let good = std::fs::read_to_string(&path).expect("it is there");
    std::fs::write(&path, good.replace("\"Ego\"", "\"Car 1\"")).expect("our own directory");
    let refused = corner.run(&["run", "examples/cut_in.xosc"]);
    assert_eq!(refused.status.code(), Some(2));
    let said = text(&refused);
    assert!(said.contains("expected `--ego NAME` with `Car 1` or `Cutter`"), "{said}");
    let shown = corner.run(&["list", "--show", "examples/cut_in.xosc", "--ego", "Car 1"]);
    assert!(
        shown.status.success() && text(&shown).contains("name = \"Cutter\""),
        "{}",
        text(&shown)
    );
    let summary = lockstep(&corner, "examples/cut_in.xosc", &["--ego", "Car 1", "--duration", "6"]);
    assert_eq!(summary["outcome"], "completed");
    let own = corner.run(&["run", "following", "--ego", "Car 1"]);
    assert_eq!(own.status.code(), Some(2));
    assert!(
        text(&own).contains("--ego Car 1: following is not an OpenSCENARIO file"),
        "{}",
        text(&own)
    );
}

/// A story that cannot happen is not a completed drive.
#[test]
fn a_story_that_cannot_happen_has_status_1() {
    let corner = corner();
    let file = "examples/cut_in.xosc";
    let path = corner.path().join(file);
    let good = std::fs::read_to_string(&path).expect("it is there");
    let refused = |arguments: &[&str], status: i32, expected: &str| {
        let output = corner.run(&[&["run", file, "--mode", "lockstep"], arguments].concat());
        let said = text(&output);
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.contains(expected), "{said}");
    };
    // The acts start at 500 s.
    let late = "<SimulationTimeCondition value=\"500\"";
    std::fs::write(&path, good.replace("<SimulationTimeCondition value=\"0\"", late))
        .expect("ours");
    refused(&["--duration", "2"], 1, "started within");
    refused(&["--duration", "2", "--json"], 1, "\"no_story\"");
    let waits = ["--set", "set_speed_mps=0", "--set", "plant.initial_speed_mps=0"];
    refused(&waits, 1, "error: the ego stands, and its set speed is 0 m/s: the story of");
    std::fs::write(&path, good.replace("straight.xodr", "bent.xodr")).expect("ours");
    refused(&[], 1, "bent.xodr is not there: the story of");
    refused(&["--strict"], 2, "bent.xodr is not there: a straight road with lanes of 3.5 m");
    assert!(corner.roots().is_empty());
}

#[test]
fn a_pedestrian_is_a_target() {
    let corner = corner();
    let summary = lockstep(&corner, "examples/crossing_pedestrian.xosc", &[]);
    let figures = &summary["control"];
    assert!(figures["min_gap_m"].as_f64().is_some(), "{figures}");
    assert!(figures["min_accel_mps2"].as_f64() < Some(-1.0), "the ego brakes: {figures}");
}

#[test]
fn a_variation_runs_every_combination_that_keeps_the_constraints() {
    let corner = corner();
    let arguments = ["campaign", "examples/cut_in_variation.xosc", "--out", "c"];
    let output = corner.run(&arguments);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    assert!(text(&output).contains("2 combinations break a constraint"), "{}", text(&output));
    let verdict = std::fs::read(corner.path().join("c/campaign.json")).expect("a verdict");
    let verdict: Value = serde_json::from_slice(&verdict).expect("JSON");
    assert_eq!((&verdict["runs"], &verdict["left_out"]), (&6.into(), &2.into()));
    assert_eq!(verdict["aborted"], 0);
}

#[test]
fn a_mistake_is_one_error_with_its_place() {
    let corner = corner();
    let path = corner.path().join("examples/cut_in.xosc");
    let good = std::fs::read_to_string(&path).expect("it is there");
    for (from, to, arguments, expected) in [
        ("revMinor=\"2\"", "revMinor=\"4\"", &[][..], "cut_in.xosc:5:3: version 1.4"),
        (
            "<LateralAction>",
            "<PlatoonAction/><LateralAction>",
            &[],
            "element `PlatoonAction` in `PrivateAction` is not supported, expected `LongitudinalAction`",
        ),
        ("./catalogs", "./nowhere", &[], "nowhere cannot be read"),
        (
            "\"road_users\"",
            "\"aircraft\"",
            &[],
            "catalog `aircraft` is in none of the catalog locations",
        ),
        ("$Gap_m + 30", "$Gap + 30", &[], "parameter `Gap` is not declared"),
        ("value=\"30\"/>", "value=\"${$Gap_m}\"/>", &[], "parameter `Gap_m` depends on itself"),
        ("laneId=\"-2\"", "laneId=\"-9\"", &[], "has no lane `-9`"),
        ("</Storyboard>", "", &[], "not XML"),
        ("revMinor=\"2\"", "revMinor=\"2\"", &["--param", "Speed=3"], "parameter Speed=3"),
        (
            "revMinor=\"2\"",
            "revMinor=\"2\"",
            &["--param", "Gap_m"],
            "no value, expected NAME=VALUE",
        ),
        (
            "revMinor=\"2\"",
            "revMinor=\"2\"",
            &["--param", "Ego_Speed_kph=200"],
            "parameter `Ego_Speed_kph` has the value 200, expected greaterThan 0",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        std::fs::write(&path, good.replacen(from, to, 1)).expect("our own directory");
        let output = corner.run(&[&["run", "examples/cut_in.xosc"], arguments].concat());
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{to}: {said}");
        assert!(said.contains(expected), "{to}: {said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
    }
    std::fs::write(&path, good).expect("our own directory");
    let road = corner.path().join("examples/straight.xodr");
    let bent =
        std::fs::read_to_string(&road).expect("it is there").replacen("b=\"0\"", "b=\"nan\"", 1);
    std::fs::write(&road, bent).expect("our own directory");
    let output = corner.run(&["run", "examples/cut_in.xosc"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output)
            .contains("straight.xodr:13:67: attribute `b` of `width`: `nan` is not a number"),
        "{}",
        text(&output)
    );
    assert!(corner.roots().is_empty());
    assert!(!corner.path().join("runs").exists());
}
