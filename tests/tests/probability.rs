//! `timegap search --probability`: two estimates beside each other.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// A following drive whose gap at the start is below a limit. The probability is that of the gap, known in closed form.
const GAP: &str = r#"
schema_version = 1
name = "gap"
scenario = "./scene.toml"
reference = "none"
[vary]
gap = "15..80"
other = "0..1"
[set]
"actors.0.gap_m" = "gap + 0*other"
[require]
formulas = ["always[0,0] gap_m >= 31.6"]
[probability]
indices = 20
[probability.distributions]
gap = "normal(40, 5)"
other = "uniform(0, 1)"
[probability.exposure]
per = "hour"
events = 2
source = "a log"
"#;

const SCENE: &str = "schema_version = 1\nname = \"scene\"\nduration_s = 0.5\nset_speed_mps = 20\n[plant]\n\
    initial_speed_mps = 20\n[[actors]]\nname = \"lead\"\ngap_m = 40\ninitial_speed_mps = 20\n";

fn write(corner: &Corner, file: &str) -> String {
    std::fs::write(corner.path().join("scene.toml"), SCENE).expect("writable");
    let path = corner.path().join("gap.toml");
    std::fs::write(&path, file).expect("writable");
    path.to_string_lossy().into_owned()
}

fn search(corner: &Corner, file: &str, more: &[&str]) -> std::process::Output {
    corner.run(&[&["search", &write(corner, file), "--probability"], more].concat())
}

#[test]
fn both_estimates_hold_the_known_probability() {
    let corner = Corner::new(PROGRAM);
    let output = search(&corner, GAP, &["--budget", "600", "--json"]);
    assert!(output.status.success(), "{}", text(&output));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let probability = &found["probability"];
    // P(gap < 31.6) = Φ(−1.68).
    let exact = 0.046_479;
    for method in ["monte_carlo", "cross_entropy"] {
        let ends = &probability[method]["ci95"];
        let (low, high) = (ends[0].as_f64().expect("low"), ends[1].as_f64().expect("high"));
        assert!((low..=high).contains(&exact), "{method}: {probability}");
    }
    assert_eq!((&found["ok"], &probability["disagreement"]), (&true.into(), &false.into()));
    let rate = probability["exposure"]["rate"].as_f64().expect("a rate");
    assert!((rate - 2.0 * probability["estimate"].as_f64().expect("one")).abs() < 1e-12);
    assert_eq!(probability["exposure"]["source"], "a log");
    let [gap, other] = &probability["variables"].as_array().expect("two")[..] else {
        panic!("{probability}")
    };
    let of = |one: &Value, name: &str| one[name].as_f64().expect("a number");
    assert!(of(gap, "importance") > 0.9 && of(other, "importance") < 0.1, "{probability}");
    assert!(of(gap, "total") > 0.8 && of(other, "total").abs() < 0.05, "{probability}");
}

/// A replica of 104 points goes on from its first hundred, and comes to the same estimate and the same table of drives.
#[test]
fn an_interrupted_replica_goes_on_in_its_middle() {
    let corner = Corner::new(PROGRAM);
    let gap = GAP.replace("indices = 20", "monte_carlo = 50");
    let name = write(&corner, &gap);
    let words = ["search", &name, "--probability", "--budget", "520", "--json"];
    let mut begun = corner.start(&[&words[..], &["--resume", "a"]].concat());
    let file = |path: &str| std::fs::read(corner.path().join(path)).unwrap_or_default();
    let is_kept = || file("a/begun.jsonl").ends_with(b"\n");
    let is_over = |begun: &mut std::process::Child| begun.try_wait().expect("ours").is_some();
    assert!(wait_for(|| is_kept() || is_over(&mut begun)), "neither values nor an end");
    let pid = Pid::from_raw(begun.id().try_into().expect("a process id")).expect("not 0");
    kill_process(pid, Signal::INT).expect("our own child");
    assert_eq!(begun.wait().expect("ours").code(), Some(130), "it was interrupted");
    assert!(is_kept(), "an interrupt loses no value");
    let kept = file("a/begun.jsonl").split(|byte| *byte == b'\n').count();
    let journal = String::from_utf8(file("a/runs.jsonl")).expect("text");
    assert!(journal.lines().count() < 6 && kept > 1, "{journal}");
    let found = |more: &[&str]| {
        let output = corner.run(&[&words[..], more].concat());
        assert!(output.status.success(), "{}", text(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("JSON")["probability"].take()
    };
    assert_eq!(found(&["--resume", "a"]), found(&["--resume", "b"]));
    assert_eq!(file("a/runs.csv"), file("b/runs.csv"));
    assert!(!file("b/runs.csv").is_empty() && file("a/begun.jsonl").is_empty());
}

#[test]
fn a_variable_without_a_distribution_is_refused() {
    let corner = Corner::new(PROGRAM);
    let output = search(&corner, &GAP.replace("other = \"uniform(0, 1)\"\n", ""), &[]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("`other` has no distribution"), "{}", text(&output));
}

/// The cut-in with all of 100,000 points of Monte Carlo, and 10,000 of the other estimator.
#[test]
#[ignore = "an hour on two cores"]
fn the_cut_in_agrees_with_monte_carlo() {
    let corner = Corner::new(PROGRAM);
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../studies/search/problems");
    let file = std::fs::read_to_string(format!("{folder}/cut-in-probability.toml"));
    let file = file.expect("a text");
    let table = "[probability.distributions]";
    let file = file.replace(table, &format!("[probability]\nmonte_carlo = 100000\n\n{table}"));
    std::fs::copy(format!("{folder}/cut-in-scene.toml"), corner.path().join("cut-in-scene.toml"))
        .expect("writable");
    let path = corner.path().join("cut-in-probability.toml");
    std::fs::write(&path, file).expect("writable");
    let file = path.to_str().expect("UTF-8");
    let output = corner.run(&["search", file, "--probability", "--budget", "10000", "--json"]);
    assert!(output.status.success(), "{}", text(&output));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let probability = &found["probability"];
    println!("{}\n{}", probability["monte_carlo"], probability["cross_entropy"]);
    assert_eq!(probability["disagreement"], false);
    assert_eq!(probability["monte_carlo"]["runs"], 100_000);
    assert!(probability["monte_carlo"]["failures"].as_u64() > Some(20), "{probability}");
}
