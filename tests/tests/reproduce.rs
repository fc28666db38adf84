//! The papers' figures through the real processes, as the commands print them.

use serde_json::Value;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Rows of one paper. Status 1 is allowed: a row may be outside, and then it says so.
fn rows(corner: &Corner, paper: &str) -> (bool, Vec<Value>) {
    let output = corner.run(&["reproduce", paper, "--out", "out", "--json"]);
    let status = output.status.code();
    assert!(matches!(status, Some(0 | 1)), "{}", text(&output));
    let result: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let ok = result["ok"].as_bool().expect("a verdict");
    assert_eq!(status == Some(0), ok, "the exit status is the verdict");
    let papers = result["papers"].as_array().expect("a list");
    assert_eq!((papers.len(), papers[0]["paper"].as_str()), (1, Some(paper)));
    (ok, papers[0]["rows"].as_array().expect("a list").clone())
}

/// The row's `ok` is what its numbers say.
fn consistent(row: &Value) {
    let kind = row["kind"].as_str().expect("every row says its source");
    assert!(["paper", "reconstruction", "requirement"].contains(&kind), "{row}");
    let expected = row["expected"].as_f64();
    assert_eq!(row["paper"].as_f64(), expected.filter(|_| kind == "paper"), "{row}");
    let (Some(expected), Some(tolerance)) = (expected, row["tolerance"].as_f64()) else {
        assert_eq!(row["check"], "shown", "{row}");
        return;
    };
    assert!(row["tolerance_reason"].is_string(), "{row}");
    let bound = row["check"] == "at_most";
    let within = row["ours"].as_f64().is_some_and(|ours| {
        let off = if bound { ours - expected } else { (ours - expected).abs() };
        off <= tolerance + 1e-9
    });
    assert_eq!(row["ok"].as_bool(), Some(within), "{row}");
}

#[test]
fn six_mode() {
    let corner = Corner::new(PROGRAM);
    let (ok, rows) = rows(&corner, "six-mode");
    rows.iter().for_each(consistent);
    assert!(ok, "{rows:#?}");
    assert_eq!(rows.iter().filter(|row| row["unit"] == "s").count(), 6, "six switches");
    let picture = std::fs::read_to_string(corner.path().join("out/report.html")).expect("drawn");
    assert!(picture.contains("switch.6-1_s"), "every row is on the page");
    assert!(picture.contains("<svg") && picture.contains("vehicle ahead"));
}

#[test]
fn quadratic_bounded() {
    let corner = Corner::new(PROGRAM);
    let (ok, rows) = rows(&corner, "quadratic-bounded");
    rows.iter().for_each(consistent);
    assert!(ok, "{rows:#?}");
    assert!(rows.iter().any(|row| row["id"] == "cut-in.hardest_braking_mps2"));
}

#[test]
fn cacc() {
    let corner = Corner::new(PROGRAM);
    let (_, rows) = rows(&corner, "cacc");
    rows.iter().for_each(consistent);
    let find = |weights: &str, id: &str| {
        let row = rows.iter().find(|row| row["weights"] == weights && row["id"] == id);
        row.unwrap_or_else(|| panic!("no row {id} with {weights} weights"))
    };
    // What the task demands outright: crossing times and distances.
    for weights in ["joint", "single"] {
        for id in ["A.cacc.cross_s", "A.acc.cross_s", "T3.acc.cross_s", "T3.cacc.cross_s"] {
            assert_eq!(find(weights, id)["ok"], true, "{}", find(weights, id));
        }
        for id in ["C.cacc.to_line_m", "C.acc.to_line_m"] {
            assert_eq!(find(weights, id)["ok"], true, "{}", find(weights, id));
        }
    }
    let crossing = find("joint", "A.cacc.cross_s");
    assert_eq!(
        (crossing["paper"].as_f64(), crossing["tolerance"].as_f64()),
        (Some(4.0), Some(0.25))
    );
}

#[test]
fn compare_puts_all_controllers_on_the_same_scenarios() {
    let corner = Corner::new(PROGRAM);
    let result = corner.json(&["compare", "following", "cut-in"]);
    let rows = result["rows"].as_array().expect("a list");
    let names: Vec<_> = rows
        .iter()
        .map(|row| {
            format!("{} {}", row["scenario"].as_str().unwrap(), row["controller"].as_str().unwrap())
        })
        .collect();
    let mut expected = Vec::new();
    for scenario in ["following", "cut-in"] {
        for controller in ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded", "predictive"] {
            expected.push(format!("{scenario} {controller}"));
        }
    }
    assert_eq!(names, expected);
    for row in rows {
        assert_eq!(row["outcome"], "completed", "{row}");
        assert!(row["control"]["min_gap_m"].as_f64() > Some(0.0), "{row}");
        assert!(row["timing"]["solve_us"]["count"].as_u64() > Some(0), "{row}");
    }
}

#[test]
fn a_solver_is_chosen_by_a_key_and_both_drive_alike() {
    let corner = Corner::new(PROGRAM);
    let drive = |solver: &str| {
        let key = format!("controller.solver={solver}");
        corner.json(&["run", "cacc-a", "--mode", "lockstep", "--set", &key])
    };
    let [ours, oracle] = ["riccati", "clarabel"].map(drive);
    let crossing = |summary: &Value| summary["control"]["stop_line_crossing_s"].as_f64();
    let (Some(a), Some(b)) = (crossing(&ours), crossing(&oracle)) else { panic!("both cross") };
    assert!((a - b).abs() < 1e-3, "{a} and {b}");
}
