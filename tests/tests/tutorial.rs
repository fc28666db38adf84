//! The end of the tutorial: the reader's own controller in the group, with a fault.

use serde_json::Value;
use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const MY_CONTROLLER: &str = env!("CARGO_BIN_EXE_my-controller");

fn service() -> String {
    format!("controller={MY_CONTROLLER}")
}

#[test]
fn a_controller_of_ones_own_follows_in_lockstep() {
    let corner = Corner::new(PROGRAM);
    let arguments = ["run", "following", "--mode", "lockstep", "--duration", "30", "--no-record"];
    let summary = corner.json(&[&arguments[..], &["--service", &service()]].concat());
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let gap_m = summary["control"]["min_gap_m"].as_f64().expect("there is a lead");
    assert!(gap_m > 5.0, "{gap_m}");
    // Every law is measured against one stated gap.
    assert!(summary["control"]["final_gap_error_m"].is_f64(), "{}", summary["control"]);
    assert!(corner.roots().is_empty());
}

#[test]
fn it_is_replaced_when_it_is_killed() {
    let corner = Corner::new(PROGRAM);
    let shown = corner.run(&["list", "--show", "following"]);
    let text = String::from_utf8(shown.stdout).expect("a scenario is text");
    let fault = "\n[[faults]]\nkind = \"kill\"\nservice = \"controller\"\nat_s = 1.0\n";
    std::fs::write(corner.path().join("mine.toml"), text + fault).expect("our own directory");
    let arguments = ["run", "mine.toml", "--duration", "4", "--service"];
    let summary = corner.json(&[&arguments[..], &[&service()]].concat());
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let controller = (summary["services"].as_array().expect("a list").iter())
        .find(|service| service["name"] == "controller")
        .expect("it took part");
    assert_eq!(controller["restarts"], 1, "{controller}");
    let recovered = &summary["faults"][0]["recovered_after_us"];
    assert!(matches!(recovered, Value::Number(_)), "{}", summary["faults"]);
}

#[test]
fn the_example_has_at_most_forty_lines() {
    assert!(include_str!("../../examples/my_controller.rs").lines().count() <= 40);
}
