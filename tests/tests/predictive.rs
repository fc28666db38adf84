//! The predictive truck through the real processes: planning beside the loop, wrong maps, missing roads.

use serde_json::Value;
use std::fmt::Write;
use system_tests::{Corner, csv, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

const LOCKSTEP: [&str; 3] = ["truck-hills", "--mode", "lockstep"];

/// Drives the hills in lockstep with these options.
fn hills(corner: &Corner, options: &[&str]) -> Value {
    let arguments: Vec<_> = ["run"].iter().chain(&LOCKSTEP).chain(options).copied().collect();
    corner.json(&arguments)
}

fn changes(summary: &Value) -> Vec<(f64, String, String)> {
    let word = |value: &Value| value.as_str().expect("a word").to_owned();
    let changes = summary["control"]["mode_changes"].as_array().expect("a list");
    let change =
        |c: &Value| (c["t_s"].as_f64().expect("a time"), word(&c["to"]), word(&c["reason"]));
    changes.iter().map(change).collect()
}

#[test]
fn plans_made_beside_the_loop_repeat_byte_for_byte() {
    let corner = Corner::new(PROGRAM);
    let options = ["--duration", "100", "--set", "v2x.preview.noise_percent=0.25"];
    let digests = |summary: &Value| {
        let messages = summary["messages"].as_object().expect("topics").clone();
        assert!(
            messages.contains_key("v2x/preview") && messages.contains_key("vehicle/powertrain")
        );
        messages.into_iter().map(|(topic, m)| (topic, m["digests"].clone())).collect::<Vec<_>>()
    };
    let first = hills(&corner, &options);
    let planning = &first["timing"]["planning"];
    assert!(planning["asked"].as_u64() > Some(5), "{planning}");
    assert_eq!(planning["late"].as_u64(), Some(0), "a lockstep run waits: {planning}");
    for _ in 0..3 {
        assert_eq!(digests(&first), digests(&hills(&corner, &options)));
    }
}

#[test]
fn the_truck_cruises_where_the_map_ends() {
    let corner = Corner::new(PROGRAM);
    let summary = hills(
        &corner,
        &["--duration", "240", "--set", "v2x.preview.ends_at_m=3000", "--out", "out"],
    );
    assert_eq!(summary["outcome"], "completed");
    assert!(summary["control"]["fuel_l_per_100km"].as_f64() > Some(10.0), "{summary}");
    let changes = changes(&summary);
    let (_, mode, reason) = changes.last().expect("it planned, then did not");
    assert_eq!((mode.as_str(), reason.as_str()), ("cruise", "no_plan"), "{changes:?}");
    // Beyond the end of the map: the set speed, on any grade.
    let table = std::fs::read_to_string(corner.path().join("out/trajectory.csv")).expect("written");
    let rows = csv(&table, &["position_m", "speed_mps"]);
    let late: Vec<_> = rows.iter().filter(|row| row[0] > 4000.0).collect();
    assert!(late.len() > 1000, "{} steps", late.len());
    for row in late {
        assert!((row[1] - 75.0 / 3.6).abs() < 1.0, "{} m/s at {} m", row[1], row[0]);
    }
}

#[test]
fn a_map_of_another_road_is_given_up() {
    let corner = Corner::new(PROGRAM);
    let summary = hills(&corner, &["--duration", "240", "--set", "v2x.preview.shift_m=1000"]);
    assert_eq!(summary["outcome"], "completed");
    let changes = changes(&summary);
    assert!(
        changes.iter().any(|(_, mode, reason)| mode == "cruise" && reason == "map_contradicts"),
        "{changes:?}"
    );
}

/// Neither planning nor messages allocate in the loop, except for a first block of the pool.
#[test]
fn planning_costs_the_loop_no_allocation() {
    let corner = Corner::new(PROGRAM);
    for mode in ["realtime", "lockstep"] {
        let summary = corner.json(&["run", "truck-hills", "--mode", mode, "--duration", "4"]);
        assert_eq!(summary["outcome"], "completed");
        let planning = &summary["timing"]["planning"];
        assert!(planning["asked"].as_u64() > Some(0), "{planning}");
        let services = summary["services"].as_array().expect("a list");
        let controller = services.iter().find(|service| service["name"] == "controller");
        let allocations = &controller.expect("it ran")["allocations_in_loop"];
        assert!(allocations.as_u64() <= Some(1), "{mode}: {allocations}");
    }
}

#[test]
fn invalid_roads_are_refused_at_their_place() {
    let corner = Corner::new(PROGRAM);
    let write = |name: &str, text: &str| {
        std::fs::write(corner.path().join(name), text).expect("our own directory");
    };
    write(
        "mine.toml",
        "schema_version = 1\nname = \"mine\"\nduration_s = 1\nplant.vehicle = \"jh6-25t\"\n\
         road.csv = \"road.csv\"\n",
    );
    let mut endless = String::from("distance_m,height_m\n");
    for point in 0..30_000 {
        writeln!(endless, "{point},0").expect("a string takes all");
    }
    let cases = [
        ("distance_m,height_m\n0,0\n50,1\n40,2\n", "road.csv:4:1: distances must increase"),
        ("distance_m,height_m\n0,0\n50,1\n1000,2\n", "road.csv:4:1: a gap of 950 m"),
        ("distance_m,height_m\n0,0\n50,nan\n", "road.csv:3:4: NaN is out of range"),
        ("distance_m,grade_percent\n0,0\n50,40\n", "road.csv:3:4: 40 is out of range"),
        ("\u{0}\u{1}", "road.csv"),
        ("", "road.csv"),
        (endless.as_str(), "road.csv"),
    ];
    for (road, expected) in cases {
        write("road.csv", road);
        let output = corner.run(&["run", "mine.toml", "--mode", "lockstep"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(said.contains(expected), "should say `{expected}`:\n{said}");
        assert_eq!(said.lines().filter(|line| line.starts_with("error")).count(), 1, "{said}");
    }
    corner.expect_nothing_left(&[]);
}
