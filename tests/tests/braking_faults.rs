//! A 49 t truck downhill behind a lead that brakes to standstill at 6 m/s², while messages are disturbed. With a
//! detecting radar and the emergency brake there is no contact. In an earlier version each case ended in a contact, or
//! less than 0.1 m from one.

use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn least_gap_m(law: &str, faults: &str) -> f64 {
    let corner = Corner::new(PROGRAM);
    let faults = format!("faults=[{faults}]");
    let options = ["--controller", law, "--mode", "lockstep", "--in-process", "--duration", "30"];
    let keys = ["aebs.enabled=true", "perception.radar.model=\"detections\"", &faults];
    let keys = keys.iter().flat_map(|key| ["--set", *key]);
    let arguments: Vec<_> = ["run", "truck-brake"].into_iter().chain(options).chain(keys).collect();
    let summary = corner.json(&arguments);
    assert_eq!(summary["outcome"], "completed", "{law}, {faults}");
    summary["control"]["min_gap_m"].as_f64().expect("a lead is there")
}

fn keeps_its_distance(laws: &[&str], faults: &str) {
    for law in laws {
        let gap_m = least_gap_m(law, faults);
        assert!(gap_m > 0.0, "{law}, {faults}: {gap_m} m");
    }
}

#[test]
fn a_radar_whose_clock_is_wrong_before_the_lead_brakes() {
    keeps_its_distance(
        &["predictive", "acc-mpc", "quadratic-bounded"],
        "{ kind = \"clock-step\", service = \"perception-sim\", amount = 0.421, at_s = 7.167, for_s = 16.409 }",
    );
}

#[test]
fn a_radar_whose_clock_is_wrong_while_the_lead_brakes() {
    keeps_its_distance(
        &["predictive", "acc-mpc", "quadratic-bounded"],
        "{ kind = \"clock-step\", service = \"perception-sim\", amount = 0.24, at_s = 10.5, for_s = 12.649 }",
    );
}

#[test]
fn a_powertrain_that_is_older_than_the_odometry() {
    keeps_its_distance(
        &["predictive"],
        "{ kind = \"stale\", topic = \"vehicle/powertrain\", amount = -0.989, at_s = 10.6, for_s = 19.099 }",
    );
}

#[test]
fn a_plant_whose_clock_is_wrong_and_no_emergency_brake() {
    keeps_its_distance(
        &["predictive", "acc-mpc"],
        "{ kind = \"clock-step\", service = \"plant\", amount = 0.208, at_s = 10.6, for_s = 10.5 }, \
         { kind = \"stale\", topic = \"safety/brake\", amount = -1.103, at_s = 4, for_s = 14 }",
    );
}

#[test]
fn odometry_that_is_wrong_and_then_mostly_lost() {
    keeps_its_distance(
        &["predictive", "acc-mpc"],
        "{ kind = \"bias\", topic = \"vehicle/odometry\", field = \"speed_mps\", amount = -0.974, at_s = 0.747, \
         for_s = 17.726 }, \
         { kind = \"drop\", topic = \"vehicle/odometry\", probability = 0.42, at_s = 10.5, for_s = 13.962 }",
    );
}
