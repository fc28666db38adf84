//! Lockstep runs in one process give the same bytes as process groups.

use rand_core::Rng;
use rand_pcg::Pcg64;
use report::summary::Summary;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use serde_json::Value;
use std::time::Duration;
use supervise::{Error, GroupOutcome, in_process};
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

/// The figures that wall clocks do not affect. In a run that ends early, counts of received messages are affected too.
/// A stopped service may have read the last message or not.
fn repeatable(summary: &Value) -> Value {
    let control = &summary["control"];
    let [faults, rungs] = ["faults", "rungs"].map(|key| &summary[key]);
    let mut messages = summary["messages"].clone();
    if summary["outcome"] != "completed" {
        for counts in messages.as_object_mut().into_iter().flat_map(|topics| topics.values_mut()) {
            for count in ["received", "lost", "e2e", "e2e_errors"] {
                counts[count].take();
            }
        }
    }
    let outcome = (&summary["outcome"], &summary["duration_s"]);
    serde_json::json!([outcome, control, messages, faults, rungs])
}

/// Runs the scenario in one process and in a group; results must agree.
fn same_in_both(scenario: &str, options: &[&str]) {
    let corner = Corner::new(PROGRAM);
    let run = |extra: &[&str]| {
        let own = ["run", scenario, "--mode", "lockstep", "--no-record"];
        let output = corner.run(&[&own, options, extra, &["--json"]].concat());
        // A collision is a valid result, if it is the same one.
        serde_json::from_slice::<Value>(&output.stdout)
            .unwrap_or_else(|_| panic!("{}", text(&output)))
    };
    let (memory, shared) = (run(&["--in-process", "--digests"]), run(&[]));
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
    assert_eq!(expected.len(), 17, "the papers' scenarios and those that tests rely on");
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
    for law in controller::laws::own() {
        let scenario = if law.trucks_alone { "truck-follow" } else { "cut-in" };
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

/// A random mix of one to four message faults over all topics, by its number.
fn random_mix(number: u64) -> String {
    let mut random = Pcg64::new(number.into(), 0x313);
    let mut draw = |below: u64| (random.next_u64() >> 11) % below;
    let topics = ["vehicle/odometry", "radar/tracks", "v2x/spat", "v2x/map", "control/command"];
    let mut toml = String::new();
    for _ in 0..1 + draw(4) {
        let topic = topics[draw(topics.len() as u64) as usize];
        let share = 0.05 + 0.9 * draw(100) as f64 / 100.0;
        let kind = match draw(6) {
            0 => format!("kind = \"drop\"\nprobability = {share}"),
            1 => format!("kind = \"delay\"\ndelay_ms = {}\njitter_ms = {}", draw(200), draw(120)),
            2 => format!("kind = \"reorder\"\nprobability = {share}"),
            3 => format!("kind = \"corrupt\"\nprobability = {share}\nbits = {}", 1 + draw(64)),
            4 => "kind = \"freeze\"".to_owned(),
            _ => format!("kind = \"duplicate\"\nprobability = {share}"),
        };
        let (at_s, for_s) = (draw(60) as f64 / 10.0, 0.2 + draw(40) as f64 / 10.0);
        toml += &format!(
            "\n[[faults]]\n{kind}\ntopic = \"{topic}\"\nat_s = {at_s:.1}\nfor_s = {for_s:.1}\n"
        );
    }
    toml
}

fn random_mixes_do_the_same(mixes: std::ops::Range<u64>) {
    let corner = Corner::new(PROGRAM);
    let laws = ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded"];
    for mix in mixes {
        let scenario = ["cut-in", "cacc-a", "following", "stop-and-go"][(mix % 4) as usize];
        let law = laws[(mix / 4 % 4) as usize];
        let file = corner.path().join("mix.toml");
        std::fs::write(&file, builtin(scenario).to_toml() + &random_mix(mix)).expect("ours");
        let file = file.to_str().expect("plain letters").to_owned();
        let seed = mix.to_string();
        same_in_both(&file, &["--duration", "8", "--controller", law, "--seed", &seed]);
    }
}

#[test]
fn a_sample_of_random_fault_mixes_does_the_same_in_one_process_and_in_a_group() {
    random_mixes_do_the_same(0..8);
}

#[test]
fn without_crcs_and_digests_a_run_is_the_same() {
    for mix in 0..24 {
        let name = ["cut-in", "cacc-a", "stop-and-go", "corridor"][(mix % 4) as usize];
        let text = builtin(name).to_toml() + &random_mix(mix);
        let scenario = Scenario::parse("mix", &text).expect("a scenario");
        let told = |group: Result<GroupOutcome, Error>| {
            let group = group.expect("it runs");
            let summary = Summary::new(&scenario, Mode::Lockstep, &group, Duration::ZERO);
            let mut summary = serde_json::to_value(summary).expect("plain data");
            let topics = summary["messages"].as_object_mut().expect("topics by name");
            let digests = topics.values_mut().map(|counts| counts["digests"].take());
            let digests = digests.filter(|of| of.as_object().is_some_and(|of| !of.is_empty()));
            (digests.count(), repeatable(&summary), group.drive.steps)
        };
        let sealed = told(in_process::run(&scenario));
        let unsealed = told(in_process::run_watched(
            &scenario,
            runtime::Sealing::Unsealed,
            &|| false,
            &mut |_| {},
        ));
        assert!(sealed.0 > 5 && unsealed.0 == 0, "{mix}: {} and {}", sealed.0, unsealed.0);
        assert_eq!(sealed.1, unsealed.1, "{mix}");
        assert!(sealed.2 == unsealed.2, "{mix}: another drive");
    }
}

/// All mixes, or those from `FAULT_MIXES_FROM` to before `FAULT_MIXES_TO`.
#[test]
#[ignore = "an hour on a busy machine: run it with --ignored"]
fn a_thousand_random_fault_mixes_do_the_same_in_one_process_and_in_a_group() {
    let bound = |name: &str, usual: u64| {
        let text = std::env::var(name).ok();
        text.map_or(usual, |text| text.parse().unwrap_or_else(|_| panic!("{name}={text}")))
    };
    random_mixes_do_the_same(bound("FAULT_MIXES_FROM", 0)..bound("FAULT_MIXES_TO", 1_000));
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
    // 5,000 more steps of the plant; queues reach their size in the first seconds.
    assert!(long < short + 20, "{short} allocations in 10 s, {long} in 60 s");
}

#[test]
fn options_that_need_processes_are_refused() {
    let corner = Corner::new(PROGRAM);
    let file = corner.path().join("kill.toml");
    let fault = "\n[[faults]]\nkind = \"kill\"\nservice = \"controller\"\nat_s = 1.0\n";
    std::fs::write(&file, builtin("cacc-a").to_toml() + fault).expect("a directory of our own");
    let file = file.to_str().expect("plain letters");
    for (arguments, expected) in [
        (vec![file, "--mode", "lockstep", "--in-process"], "and without --in-process"),
        (vec!["cacc-a", "--in-process"], "add --mode lockstep"),
        (
            vec!["cacc-a", "--mode", "lockstep", "--in-process", "--service", "controller=./mine"],
            "cannot be used with '--service <NAME=PROGRAM>'",
        ),
    ] {
        let output = corner.run(&[&["run"], arguments.as_slice()].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output).contains(expected), "{}", text(&output));
    }
}
