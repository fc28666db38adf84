//! A string of cars: gains, a colliding first car, limits, and invalid options.

use serde_json::Value;
use system_tests::{Corner, csv, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

const KILL: &str = "faults=[{kind = \"kill\", service = \"controller\", at_s = 1}]";
const IDEAL: [&str; 2] = ["--set", "perception.ideal=true"];

fn file(corner: &Corner, path: &str) -> String {
    std::fs::read_to_string(corner.path().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

#[test]
fn every_car_follows_the_true_motion_of_the_one_before() {
    let corner = Corner::new(PROGRAM);
    let own = ["string", "following", "--vehicles", "5", "--controllers", "acc-mpc,six-mode"];
    let own = [&own[..], &IDEAL].concat();
    let string = corner.json(&[&own[..], &["--out", "a"]].concat());
    let vehicles = string["vehicles"].as_array().expect("cars");
    let laws: Vec<_> = vehicles.iter().map(|car| &car["controller"]).collect();
    assert_eq!(laws, ["acc-mpc", "six-mode", "acc-mpc", "six-mode", "acc-mpc"]);
    // A car's speed is the next car's disturbance.
    let product = vehicles
        .iter()
        .map(|car| car["speed_gain_l2"].as_f64().expect("a gain"))
        .fold(1.0, |product, gain| product * gain);
    let head_to_tail = string["head_to_tail_gain"].as_f64().expect("a gain");
    assert!((product / head_to_tail - 1.0).abs() < 1e-3, "{product} {head_to_tail}");
    let runs = csv(&file(&corner, "a/runs.csv"), &["vehicle", "min_gap_m"]);
    let gaps: Vec<_> = vehicles.iter().map(|car| car["min_gap_m"].as_f64()).collect();
    assert_eq!(runs.iter().map(|row| Some(row[1])).collect::<Vec<_>>(), gaps);
    let page = file(&corner, "a/report.html");
    assert!(page.contains("Positions of all cars"), "no picture");
    let charts: Vec<&str> = page.split("<script type=\"application/json\">").skip(1).collect();
    assert!(charts.len() >= 2, "{} charts", charts.len());
    let data = |chart: &&str| chart.split("</script>").next().unwrap_or_default().to_owned();
    assert!(charts.iter().map(data).all(|data| !data.contains("NaN")), "a number is none");
    let again = corner.json(&[&own[..], &["--out", "b"]].concat());
    assert_eq!(string, again);
    assert_eq!(file(&corner, "a/string.json"), file(&corner, "b/string.json"));
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_sine_is_swept_and_a_limit_is_found() {
    let corner = Corner::new(PROGRAM);
    let own = ["string", "following", "--vehicles", "2", "--frequencies", "0.02..0.2:log:3"];
    let limit = ["--vary", "runtime.extra_delay_ms=0,1500", "--out", "a"];
    let string = corner.json(&[&own[..], &IDEAL, &limit].concat());
    let frequencies = string["frequencies"].as_array().expect("a curve");
    assert_eq!(frequencies.len(), 3);
    for at in frequencies {
        let gain = |key: &str| at[key].as_f64().expect("a gain");
        assert!(gain("head_to_tail_gain") <= gain("gain") && gain("gain") < 1.0, "{at}");
        assert_eq!(at["gains"].as_array().map(Vec::len), Some(2));
    }
    assert_eq!((&string["string_stable"], &string["peak"]["hz"]), (&true.into(), &0.02.into()));
    let limits = &string["limits"][0];
    assert_eq!((&limits["stable"], &limits["unstable"]), (&0.0.into(), &1500.0.into()), "{limits}");
    let at = limits["ceases_at"].as_f64().expect("between numbers");
    assert!((0.0..1500.0).contains(&at), "{at}");
    // Three strings of two cars, and a car at each frequency and delay, beside the string of the scenario.
    assert_eq!(csv(&file(&corner, "a/runs.csv"), &["vehicle"]).len(), 2 + 6 + 6);
}

#[test]
fn behind_a_car_that_collides_the_others_still_have_a_result() {
    let corner = Corner::new(PROGRAM);
    let scenario = "schema_version = 1\nname = \"crash\"\nduration_s = 40\nset_speed_mps = 30\n\
        [plant]\ninitial_speed_mps = 25\n[perception]\nideal = true\n\
        [controller]\nname = \"acc-mpc\"\n\
        [[actors]]\nname = \"wall\"\ngap_m = 15\ninitial_speed_mps = 0\n";
    std::fs::write(corner.path().join("crash.toml"), scenario).expect("our own directory");
    let arguments = ["string", "crash.toml", "--vehicles", "4", "--out", "a", "--json"];
    let output = corner.run(&arguments);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let string: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let vehicles = string["vehicles"].as_array().expect("cars");
    assert_eq!(vehicles[0]["outcome"], "collision");
    assert_eq!(vehicles.len(), 4);
    for car in &vehicles[1..] {
        assert_eq!(car["behind_collision"], true);
        assert!(car["min_gap_m"].is_number() && car["speed_gain_l2"].is_number(), "{car}");
    }
    assert_eq!(
        (&string["string_stable"], &string["head_to_tail_gain"]),
        (&false.into(), &Value::Null)
    );
}

#[test]
fn strings_driven_at_once_do_what_they_do_one_after_the_other() {
    let corner = Corner::new(PROGRAM);
    let mixed = ["--controllers", "acc-mpc,six-mode", "--frequencies", "0.05,0.1"];
    let said = the_same_at_once(&corner, &[&["following"], &mixed[..]].concat());
    assert!(!said.contains("\"collision\""), "{said}");
}

/// Drives strings of four cars one by one and all at once, and returns what both said.
fn the_same_at_once(corner: &Corner, scenario: &[&str]) -> String {
    let [one_by_one, at_once] = ["1", "4"].map(|jobs| {
        let own = ["--vehicles", "4", "--json", "--jobs", jobs, "--out", jobs];
        let output = corner.run(&[&["string"], scenario, &own].concat());
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
        (text(&output), file(corner, &format!("{jobs}/report.html")))
    });
    assert_eq!(one_by_one, at_once);
    at_once.0
}

#[test]
fn what_does_not_fit_is_refused_before_anything_runs() {
    let corner = Corner::new(PROGRAM);
    let own = ["string", "following"];
    for (arguments, words) in [
        (vec!["--vehicles", "0"], "--vehicles"),
        (vec!["--vehicles", "1001"], "at most 1000 cars"),
        (vec!["--vehicles", "2", "--controllers", "acc-mpc,none"], "unknown value `none`"),
        (vec!["--vehicles", "2", "--frequencies", "1..0.1/4"], "expected A..B:log:N"),
        (vec!["--vehicles", "2", "--vary", "runtime.extra_delay_ms=9..1/1"], "after its end"),
        (vec!["--vehicles", "2", "--vary", "runtime.delay_ms=0,1"], "extra_delay_ms"),
        (vec!["--vehicles", "2", "--frequencies", "--set", "set_speed_mps=2"], "below 2 m/s"),
        (vec!["--vehicles", "2", "--set", KILL], "no such fault (--set faults=[])"),
    ] {
        let output = corner.run(&[&own[..], &arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output));
        assert!(text(&output).contains(words), "{arguments:?}: {}", text(&output));
    }
    for command in
        [&["sweep", "following", "--vary", "set_speed_mps=20"][..], &["compare", "following"]]
    {
        let output = corner.run(&[command, &["--set", KILL, "--out", "none"]].concat());
        assert_eq!(output.status.code(), Some(2), "{command:?}: {}", text(&output));
        assert!(text(&output).contains("no such fault (--set faults=[])"), "{}", text(&output));
        assert!(!corner.path().join("none").exists(), "{command:?} made a directory");
    }
}
