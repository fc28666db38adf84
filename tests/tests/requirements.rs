//! Requirements of the user's, as the command line takes and judges them.

use serde_json::Value;
use std::process::Output;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Drives 20 s behind a lead.
fn run(corner: &Corner, more: &[&str]) -> Output {
    let common = ["run", "following", "--mode", "lockstep", "--in-process", "--duration", "20"];
    corner.run(&[&common, more].concat())
}

#[test]
fn a_broken_requirement_is_the_outcome_with_its_margin_and_instant() {
    let corner = Corner::new(PROGRAM);
    let output =
        run(&corner, &["--json", "--require", "min-gap:1", "--require", "always gap_m > 1000"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(summary["outcome"], "requirement_broken");
    let [met, broken] = &summary["requirements"].as_array().expect("a list")[..] else {
        panic!("{summary}")
    };
    // The margin is the least gap less the limit: the referee measures the same gap.
    let least_m = summary["control"]["min_gap_m"].as_f64().expect("a lead");
    let margin_m = met["margin"].as_f64().expect("decided");
    assert!((margin_m - (least_m - 1.0)).abs() < 0.05, "{margin_m} {least_m}");
    assert_eq!((&met["met"], &met["unit"]), (&true.into(), &"m".into()));
    assert_eq!(met["formula"], "always gap_m >= 1");
    assert_eq!(broken["met"], false);
    assert!(broken["margin"].as_f64().is_some_and(|margin| margin < -900.0), "{broken}");
}

#[test]
fn requirements_that_hold_are_shown_and_leave_the_run_completed() {
    let corner = Corner::new(PROGRAM);
    let output = run(&corner, &["--require", "always (gap_m > 2 and acceleration_mps2 > -9)"]);
    let printed = text(&output);
    assert!(output.status.success(), "{printed}");
    assert!(printed.contains("Requirements") && printed.contains(" met"), "{printed}");
}

/// A standing car 20 m ahead of 20 m/s: 33.3 m of braking and 7 m of reaction are more.
#[test]
fn a_collision_has_an_impact_speed_and_the_reference_has_one_too() {
    let corner = Corner::new(PROGRAM);
    let wall = corner.path().join("wall.toml");
    let scene = "schema_version = 1\nname = \"wall\"\nduration_s = 10\nset_speed_mps = 20\n\
        [plant]\ninitial_speed_mps = 20\n[[actors]]\nname = \"wall\"\ngap_m = 20\ninitial_speed_mps = 0\n";
    std::fs::write(&wall, scene).expect("writable");
    let name = wall.to_string_lossy();
    let requirements = [
        "--require",
        "no-collision",
        "--require",
        "no-avoidable-collision",
        "--require",
        "no-red-light",
    ];
    let common = ["run", &name, "--mode", "lockstep", "--in-process", "--json"];
    let output = corner.run(&[&common[..], &requirements].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(summary["outcome"], "collision");
    let impact_mps = summary["control"]["impact_speed_mps"].as_f64().expect("a contact");
    assert!((1.0..20.0).contains(&impact_mps), "{impact_mps}");
    let [hit, avoidable, red] = &summary["requirements"].as_array().expect("a list")[..] else {
        panic!("{summary}")
    };
    assert_eq!((hit["margin"].as_f64(), &hit["unit"]), (Some(-impact_mps), &"m/s".into()));
    assert_eq!((&hit["met"], &avoidable["met"]), (&false.into(), &true.into()), "{avoidable}");
    assert_eq!((&red["margin"], &red["met"]), (&Value::Null, &true.into()));
}

#[test]
fn studies_judge_by_requirements() {
    let corner = Corner::new(PROGRAM);
    let far = ["--require", "min-gap:1000", "--json"];
    let judged = |command: &[&str], pointer: &str, expected: Value| {
        let output = corner.run(&[command, &far].concat());
        assert_eq!(output.status.code(), Some(1), "{command:?}: {}", text(&output));
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(found.pointer(pointer), Some(&expected), "{command:?}: {found}");
    };
    let following = ["compare", "following", "--controllers", "acc-mpc", "--set", "duration_s=5"];
    judged(&following, "/rows/0/requirements/0/met", false.into());
    let sweep = ["sweep", "following", "--vary", "set_speed_mps=25", "--duration", "5"];
    judged(&sweep, "/runs/0/requirements/0/met", false.into());
    let cases =
        ["test", "r157", "--matrix", "following", "--sample", "1", "--controllers", "six-mode"];
    judged(&cases, "/matrices/0/laws/0/requirements_broken", 1.into());
    let string = ["string", "following", "--vehicles", "2", "--duration", "5"];
    judged(&string, "/vehicles/1/requirements/0/met", false.into());
    let file = corner.path().join("campaign.toml");
    let campaign =
        "schema_version = 1\nname = \"x\"\nscenarios = [\"following\"]\nset = [\"duration_s=5\"]\n";
    std::fs::write(&file, campaign).expect("writable");
    judged(&["campaign", &file.to_string_lossy()], "/requirements/0/ok", false.into());
}

#[test]
fn a_string_is_judged_by_its_stability() {
    let corner = Corner::new(PROGRAM);
    let common = ["string", "following", "--vehicles", "2", "--duration", "5", "--json"];
    let output = corner.run(&[&common[..], &["--require", "string-stable"]].concat());
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["stability"]["met"], found["string_stable"], "{found}");
    assert_eq!(output.status.success(), found["string_stable"] == true);
    let alone = run(&corner, &["--require", "string-stable"]);
    assert_eq!(alone.status.code(), Some(2));
    assert!(text(&alone).contains("expected it in `timegap string`"), "{}", text(&alone));
}

#[test]
fn a_wrong_requirement_is_refused_at_its_place_before_the_run() {
    let corner = Corner::new(PROGRAM);
    for (formula, expected) in [
        ("always gap > 2", "column 8: unknown signal \"gap\""),
        ("gap_m > speed_mps", "m and m/s cannot be added or compared"),
        ("always[0,900] gap_m > 2", "the window ends after the run"),
        ("min-gap:two", "expected min-gap:METRES"),
        ("min-gop:2", "unknown requirement `min-gop`"),
    ] {
        let output = run(&corner, &["--require", formula]);
        let printed = text(&output);
        assert_eq!(output.status.code(), Some(2), "{printed}");
        assert!(printed.contains(expected), "{printed}");
    }
}
