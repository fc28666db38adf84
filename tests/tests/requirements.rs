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
    assert!(printed.contains("requirements") && printed.contains("met, margin"), "{printed}");
}

#[test]
fn a_wrong_requirement_is_refused_at_its_place_before_the_run() {
    let corner = Corner::new(PROGRAM);
    for (formula, expected) in [
        ("always gap > 2", "column 8: unknown signal \"gap\""),
        ("gap_m > speed_mps", "m and m/s cannot be added or compared"),
        ("always[0,900] gap_m > 2", "the window ends after the run"),
        ("min-gap:two", "expected min-gap:METRES"),
    ] {
        let output = run(&corner, &["--require", formula]);
        let printed = text(&output);
        assert_eq!(output.status.code(), Some(2), "{printed}");
        assert!(printed.contains(expected), "{printed}");
    }
}
