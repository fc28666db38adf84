//! The CACC paper's scenario A through the real processes agrees with the reference closed loops.

use system_tests::{Corner, csv};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn compare(scenario: &str, controller: &str, reference: &str) {
    let corner = Corner::new(PROGRAM);
    let _ = corner.json(&[
        "run",
        scenario,
        "--mode",
        "lockstep",
        "--controller",
        controller,
        "--out",
        "out",
    ]);
    let ours = std::fs::read_to_string(corner.path().join("out/trajectory.csv")).expect("written");
    let ours = csv(&ours, &["time_s", "position_m", "speed_mps"]);
    let reference = csv(reference, &["t", "x", "v"]);
    assert!(reference.len() > 100);
    for row in &reference {
        let [t, x, v] = row[..] else { unreachable!("three columns") };
        let at = ours.iter().find(|ours| (ours[0] - t).abs() < 1e-6).expect("every step is there");
        assert!((at[1] - x).abs() <= 0.05, "{scenario} {controller} t {t}: {} m, not {x}", at[1]);
        assert!((at[2] - v).abs() <= 0.05, "{scenario} {controller} t {t}: {} m/s, not {v}", at[2]);
    }
}

macro_rules! reference {
    ($name:literal) => {
        include_str!(concat!("../data/", $name, ".csv"))
    };
}

#[test]
fn scenario_a_acc() {
    compare("cacc-a", "acc-mpc", reference!("cacc-a-acc"));
}

#[test]
fn scenario_a_cacc() {
    compare("cacc-a", "cacc-mpc", reference!("cacc-a-cacc"));
}

#[test]
fn scenario_b_acc() {
    compare("cacc-b", "acc-mpc", reference!("cacc-b-acc"));
}

#[test]
fn scenario_b_cacc() {
    compare("cacc-b", "cacc-mpc", reference!("cacc-b-cacc"));
}

#[test]
fn scenario_c_acc() {
    compare("cacc-c", "acc-mpc", reference!("cacc-c-acc"));
}

#[test]
fn scenario_c_cacc() {
    compare("cacc-c", "cacc-mpc", reference!("cacc-c-cacc"));
}
