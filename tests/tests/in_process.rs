//! Lockstep runs whose services take turns in one process: the same bytes as a group of processes.

use group::in_process;
use report::summary::Summary;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use serde_json::Value;
use std::time::Duration;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Digests of all messages of all topics, by topic and sender, of the built-in scenarios.
const DIGESTS: &str = include_str!("../data/digests.json");

fn builtin(name: &str) -> Scenario {
    Scenario::open(name, &Overrides::new(), &controller::laws::check).expect("a built-in scenario")
}

fn digests(scenario: &Scenario) -> Value {
    let group = in_process::run(scenario).expect("it runs");
    let summary = Summary::new(scenario, Mode::Lockstep, &group, Duration::ZERO);
    let topics = summary.messages.into_iter();
    let digests = topics.map(|(topic, counts)| (topic, serde_json::json!(counts.digests)));
    Value::Object(digests.collect())
}

/// The figures that a run's clocks on the wall have no part in.
fn repeatable(summary: &Value) -> Value {
    let control = &summary["control"];
    let [messages, faults, rungs] = ["messages", "faults", "rungs"].map(|key| &summary[key]);
    let outcome = (&summary["outcome"], &summary["duration_s"]);
    serde_json::json!([outcome, control, messages, faults, rungs])
}

/// Runs the same in one process and in a group; both must say the same.
fn same_in_both(scenario: &str, options: &[&str]) {
    let corner = Corner::new(PROGRAM);
    let run = |extra: &[&str]| {
        let own = ["run", scenario, "--mode", "lockstep", "--no-record"];
        let output = corner.run(&[&own, options, extra, &["--json"]].concat());
        // A collision is a result like any other, if it is the same one.
        serde_json::from_slice::<Value>(&output.stdout)
            .unwrap_or_else(|_| panic!("{}", text(&output)))
    };
    let (memory, shared) = (run(&["--in-process"]), run(&[]));
    assert_eq!(
        (&memory["carrier"], &shared["carrier"]),
        (&"memory".into(), &"shared-memory".into())
    );
    assert_eq!(repeatable(&memory), repeatable(&shared), "{scenario} {options:?}");
}

#[test]
fn every_built_in_scenario_gives_the_bytes_of_the_list() {
    let expected: Value = serde_json::from_str(DIGESTS).expect("our own list");
    let expected = expected.as_object().expect("scenarios by name");
    assert_eq!(expected.len(), 16, "the papers' scenarios and those that tests rely on");
    let found: Vec<(&String, Value)> =
        expected.keys().map(|name| (name, digests(&builtin(name)))).collect();
    if std::env::var_os("WRITE_DIGESTS").is_some() {
        let all: serde_json::Map<String, Value> =
            found.into_iter().map(|(name, digests)| (name.clone(), digests)).collect();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/digests.json");
        let text = serde_json::to_string_pretty(&all).expect("plain data") + "\n";
        std::fs::write(path, text).expect("the source is writable");
        panic!("the list was written anew: run the test again without WRITE_DIGESTS");
    }
    for (name, found) in found {
        assert_eq!(found, expected[name], "{name}: WRITE_DIGESTS=1 accepts a change that is meant");
    }
}

#[test]
fn every_law_does_the_same_in_one_process_and_in_a_group() {
    for law in controller::laws::ALL {
        let scenario = if law.name == "predictive" { "truck-follow" } else { "cut-in" };
        same_in_both(scenario, &["--controller", law.name, "--duration", "8"]);
    }
}

#[test]
fn faults_of_messages_do_the_same_in_one_process_and_in_a_group() {
    let topics = ["vehicle/odometry", "radar/tracks", "v2x/spat", "control/command"];
    let kinds = [
        "kind = \"drop\"\nprobability = 0.4",
        "kind = \"delay\"\ndelay_ms = 60\njitter_ms = 90",
        "kind = \"reorder\"\nprobability = 0.3",
        "kind = \"corrupt\"\nprobability = 0.2\nbits = 5",
        "kind = \"freeze\"",
        "kind = \"duplicate\"\nprobability = 0.5",
    ];
    let corner = Corner::new(PROGRAM);
    for mix in 0..4 {
        let mut toml = builtin("cut-in").to_toml();
        for fault in 0..3 {
            let (kind, topic) = (kinds[(mix + 2 * fault) % 6], topics[(mix + fault) % 4]);
            let begin = 1 + mix + fault;
            toml += &format!(
                "\n[[faults]]\n{kind}\ntopic = \"{topic}\"\nat_s = {begin}.0\nfor_s = 1.5\n"
            );
        }
        let file = corner.path().join(format!("mix-{mix}.toml"));
        std::fs::write(&file, toml).expect("a directory of our own");
        let file = file.to_str().expect("plain letters").to_owned();
        same_in_both(&file, &["--duration", "8", "--seed", &(mix + 11).to_string()]);
    }
}

#[test]
fn a_longer_run_allocates_no_more() {
    let corner = Corner::new(PROGRAM);
    let allocations = |duration: &str| {
        let own = ["run", "cacc-a", "--mode", "lockstep", "--in-process", "--duration", duration];
        let summary = corner.json(&own);
        let services = summary["services"].as_array().expect("services").clone();
        let plant = services.into_iter().find(|service| service["name"] == "plant");
        plant.expect("it ran")["allocations_in_loop"].as_u64().expect("this program counts")
    };
    let [short, long] = ["10", "60"].map(allocations);
    // 5,000 more steps of the plant: what is left is room that queues grow to in the first seconds.
    assert!(long < short + 20, "{short} allocations in 10 s, {long} in 60 s");
}

#[test]
fn what_needs_processes_is_refused() {
    let corner = Corner::new(PROGRAM);
    let file = corner.path().join("kill.toml");
    let fault = "\n[[faults]]\nkind = \"kill\"\nservice = \"controller\"\nat_s = 1.0\n";
    std::fs::write(&file, builtin("cacc-a").to_toml() + fault).expect("a directory of our own");
    let file = file.to_str().expect("plain letters");
    for (arguments, expected) in [
        (vec![file, "--mode", "lockstep", "--in-process"], "leave out --in-process"),
        (vec!["cacc-a", "--in-process"], "add --mode lockstep"),
        (
            vec!["cacc-a", "--mode", "lockstep", "--in-process", "--service", "controller=./mine"],
            "leave out --service or --in-process",
        ),
    ] {
        let output = corner.run(&[&["run"], arguments.as_slice()].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output).contains(expected), "{}", text(&output));
    }
}
