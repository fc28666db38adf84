//! `timegap bench --graph`: chains of a user's nodes, their faults, and refusals. No test asserts a speed.

use serde_json::Value;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Two timers, a fusion, a program, a standby.
const GRAPH: &str = r#"
name = "faulty"
topics = { image = 9000, map = 512, objects = 64 }
[[nodes]]
name = "camera"
period_ms = 10
load_us = 100
publishes = ["image"]
[[nodes]]
name = "mapper"
period_ms = 20
publishes = ["map"]
[[nodes]]
name = "detect"
trigger = ["image", "map"]
load_us = 200
publishes = ["objects"]
standby = true
[[nodes]]
name = "brake"
trigger = ["objects"]
program = "sh -c 'while read line; do echo done; done'"
[[chains]]
name = "camera to brake"
path = ["camera", "detect", "brake"]
[[chains]]
name = "map to brake"
path = ["mapper", "detect", "brake"]
deadline_ms = 60000
"#;

const FAULTS: &str = r#"
[[faults]]
kind = "kill"
node = "detect"
at_s = 0.4
[[faults]]
kind = "kill"
node = "camera"
at_s = 0.8
[[faults]]
kind = "delay"
topic = "objects"
at_s = 1.2
for_s = 0.2
delay_ms = 5
"#;

fn run(corner: &Corner, graph: &str, seconds: &str) -> (Option<i32>, Value, String) {
    std::fs::write(corner.path().join("g.toml"), graph).expect("our own corner");
    let output = corner.run(&["bench", "--graph", "g.toml", "--seconds", seconds, "--json"]);
    let json = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code(), json, text(&output))
}

#[test]
fn a_graph_with_faults_is_measured_to_its_end_and_leaves_nothing() {
    let corner = Corner::new(PROGRAM);
    let (status, report, said) = run(&corner, &format!("{GRAPH}{FAULTS}"), "2");
    assert_eq!(status, Some(0), "{said}");
    assert_eq!(system_tests::schema::check(&corner.schemas()["graph"], &report), [""; 0]);
    let chains = report["chains"].as_array().expect("two");
    for chain in chains {
        let count = |name: &str| chain[name]["count"].as_u64().expect("measured");
        assert!(chain["reactions"].as_u64() > Some(10), "{chain}");
        assert_eq!(count("reaction_time_us"), count("net_reaction_us"));
        assert!(count("data_age_us") >= count("reaction_time_us"));
        let hops = report["hops"].as_array().expect("three a chain");
        let hops: Vec<_> = hops.iter().filter(|hop| hop["chain"] == chain["chain"]).collect();
        assert_eq!(hops.len(), 3);
        assert!(hops.iter().all(|hop| hop["work_us"]["count"] == chain["reactions"]), "{chain}");
    }
    let node = |name: &str| {
        let nodes = report["nodes"].as_array().expect("four");
        nodes.iter().find(|node| node["node"] == name).expect("it is there").clone()
    };
    assert_eq!(
        (&node("detect")["take_overs"], &node("camera")["take_overs"]),
        (&1.into(), &0.into())
    );
    assert_eq!(node("camera")["replacements"], 1);
    let faults = report["faults"].as_array().expect("three");
    let of = |name: &str| {
        faults.iter().find(|fault| fault["fault"] == format!("kill {name}")).expect("a record")
    };
    for (name, by) in [("detect", "take-over"), ("camera", "restart")] {
        assert_eq!(of(name)["recovered_by"], by, "{faults:?}");
        assert!(of(name)["recovered_after_us"].as_f64() > Some(0.0), "{faults:?}");
    }
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_chain_that_is_late_is_status_1() {
    let corner = Corner::new(PROGRAM);
    let (status, report, said) = run(&corner, &GRAPH.replace("60000", "0.05"), "0.5");
    assert_eq!(status, Some(1), "{said}");
    assert!(report["chains"][1]["misses"].as_u64() > Some(0), "{report}");
}

#[test]
fn a_run_is_judged_by_an_earlier_one() {
    let corner = Corner::new(PROGRAM);
    let (status, report, said) = run(&corner, GRAPH, "0.6");
    assert_eq!(status, Some(0), "{said}");
    let samples = report["samples"].as_array().expect("two figures a chain");
    assert_eq!(samples.len(), 4);
    // A baseline with reactions of no time at all, in each block.
    let mut fast = report.clone();
    for sample in fast["samples"].as_array_mut().expect("a list") {
        let values = sample["values"].as_array_mut().expect("a value a block");
        values.iter_mut().for_each(|value| *value = 0.0.into());
    }
    std::fs::write(corner.path().join("fast.json"), fast.to_string()).expect("our own corner");
    let gate = ["bench", "--graph", "g.toml", "--seconds", "0.6", "--json", "--against"];
    let output = corner.run(&[&gate[..], &["fast.json", "--junit", "gate.xml"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let judged: Value = serde_json::from_slice(&output.stdout).expect("one object");
    let worse = judged["against"]["differences"].as_array().expect("a list");
    assert!(worse.iter().any(|change| change["better"] == false), "{worse:?}");
    let junit = std::fs::read_to_string(corner.path().join("gate.xml")).expect("written");
    assert!(junit.contains("<failure"), "{junit}");
    std::fs::write(corner.path().join("none.json"), "{}").expect("our own corner");
    let output = corner.run(&[&gate[..], &["none.json"]].concat());
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("--against none.json: it has no samples"), "{}", text(&output));
}

#[test]
fn what_cannot_be_run_is_refused_with_its_place() {
    let corner = Corner::new(PROGRAM);
    for (was, is, status, words) in [
        ("period_ms = 20", "perod_ms = 20", 2, ["g.toml:11:1", "did you mean `period_ms`?"]),
        ("period_ms = 20", "period_ms = 0", 2, ["g.toml:11:13", "0.05 to 60000 ms"]),
        (
            "[\"image\", \"map\"]",
            "[\"imge\"]",
            2,
            ["unknown topic `imge`", "did you mean `image`?"],
        ),
        ("[\"map\"]", "[\"image\"]", 2, ["`camera` publishes `image` too", "one writer"]),
        (
            "[\"mapper\", \"detect\"",
            "[\"mapper\", \"brake\", \"detect\"",
            2,
            ["`brake` reads nothing", "`map`"],
        ),
        (
            "[\"mapper\", \"detect\"",
            "[\"mapr\", \"detect\"",
            2,
            ["unknown node `mapr`", "`mapper`"],
        ),
        (
            "period_ms = 20",
            "trigger = [\"objects\"]",
            2,
            ["a cycle that nothing starts", "period_ms"],
        ),
        ("standby = true", "core = 1000", 3, ["g.toml: node detect", "core 1000"]),
        ("sh -c", "./no-such -c", 2, ["no program `./no-such`", "g.toml:22:11"]),
    ] {
        assert!(GRAPH.contains(was), "{was}");
        let (found, _, said) = run(&corner, &GRAPH.replacen(was, is, 1), "0.2");
        assert_eq!(found, Some(status), "{is}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{is}: {said}");
        assert!(!corner.path().join("runs").exists(), "nothing ran");
    }
}

#[test]
fn the_examples_are_graphs() {
    let corner = Corner::new(PROGRAM);
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/graph");
    for file in std::fs::read_dir(folder).expect("it is there") {
        let text = std::fs::read_to_string(file.expect("a file").path()).expect("readable");
        let (status, report, said) = run(&corner, &text, "0.5");
        assert!(matches!(status, Some(0 | 1)), "{said}");
        assert!(report["chains"].as_array().is_some_and(|chains| !chains.is_empty()), "{said}");
    }
    corner.expect_nothing_left(&[]);
}
