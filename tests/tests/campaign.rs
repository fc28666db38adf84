//! A campaign comes to the same verdict in one go, interrupted and resumed, and in shards. Each run
//! that it blames can be repeated.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::Write;
use std::process::Command;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// 2 scenarios, 2 controllers, 2 faults, 2 seeds: 16 runs.
const CAMPAIGN: &str = r#"schema_version = 1
name = "small"
scenarios = ["cacc-a", "cut-in"]
controllers = ["cacc-mpc", "acc-mpc"]
seeds = 2
set = ["duration_s=3"]

[[faults]]
kind = "drop"
topic = ["radar/tracks", "control/command"]
at_s = [0.5, 1.5]
for_s = 1.0

[[faults]]
kind = "corrupt"
topic = "radar/tracks"
probability = [0.1, 1.0]
bits = [1, 64]

[require]
max_collisions = 0
max_aborted = 0
max_leaks = 0
max_undetected_corruptions = 0
min_critical_faults = 0 # the runs are short
"#;

fn corner(campaign: &str) -> Corner {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), campaign).expect("our own directory");
    corner
}

/// The verdict that was written to `directory`.
fn verdict(corner: &Corner, directory: &str) -> String {
    let path = corner.path().join(directory).join("campaign.json");
    std::fs::read_to_string(path).expect("a verdict")
}

fn journal(corner: &Corner, directory: &str) -> Vec<String> {
    let path = corner.path().join(directory).join("runs.jsonl");
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().map(ToString::to_string).collect()
}

fn succeed(corner: &Corner, arguments: &[&str]) {
    let output = corner.run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
}

#[test]
fn interrupted_or_in_shards_the_verdict_is_the_same() {
    let corner = corner(CAMPAIGN);
    succeed(&corner, &["campaign", "small.toml", "--out", "whole"]);
    let whole = verdict(&corner, "whole");
    let json: Value = serde_json::from_str(&whole).expect("JSON");
    assert_eq!(json["runs"], 16);
    assert!(json["corrupted"].as_u64() > Some(0), "something was corrupted: {whole}");
    assert_eq!(json["combinations"].as_array().map(Vec::len), Some(8));

    // Interrupted after two runs, and the last line torn as by a crash.
    let child = corner.start(&["campaign", "small.toml", "--resume", "resumed", "--jobs", "1"]);
    assert!(wait_for(|| journal(&corner, "resumed").len() >= 2), "nothing ran");
    let pid = Pid::from_raw(i32::try_from(child.id()).expect("fits")).expect("a process id");
    kill_process(pid, Signal::INT).expect("our own child");
    let output = child.wait_with_output().expect("our own child");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output));
    assert!(text(&output).contains("timegap resume resumed"), "{}", text(&output));
    let kept = journal(&corner, "resumed").len();
    assert!((2..16).contains(&kept), "{kept} runs were kept");
    let path = corner.path().join("resumed/runs.jsonl");
    let mut file = std::fs::OpenOptions::new().append(true).open(path).expect("the journal");
    file.write_all(b"{\"run\":15,").expect("our own file");
    drop(file);
    succeed(&corner, &["resume", "resumed"]);
    assert_eq!(journal(&corner, "resumed").len(), 16, "no run twice");
    assert_eq!(verdict(&corner, "resumed"), whole);

    for shard in ["1/3", "2/3", "3/3"] {
        let out = format!("shard{}", &shard[..1]);
        succeed(&corner, &["campaign", "small.toml", "--shard", shard, "--out", &out]);
    }
    let merge = ["merge", "shard3", "shard1", "shard2", "--out", "merged"];
    succeed(&corner, &merge);
    assert_eq!(verdict(&corner, "merged"), whole);
    let output = corner.run(&["merge", "shard1", "shard3", "--out", "part"]);
    assert_eq!(output.status.code(), Some(1), "a part is not a whole: {}", text(&output));
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_broken_requirement_comes_with_the_command_that_repeats_it() {
    let corner = corner(&CAMPAIGN.replace("max_collisions = 0", "min_gap_m = 45"));
    let output = corner.run(&["campaign", "small.toml", "--out", "out", "--seeds", "1"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let json: Value = serde_json::from_str(&verdict(&corner, "out")).expect("JSON");
    let failure = &json["failures"][0];
    let why = failure["why"].as_str().expect("a reason");
    let repeat = failure["repeat"].as_str().expect("a command");
    assert!(text(&output).contains(repeat), "{}", text(&output));
    let output = Command::new("sh")
        .args(["-c", &format!("{} --json", repeat.replace("timegap run", "\"$0\" run")), PROGRAM])
        .current_dir(corner.path())
        .env("XDG_RUNTIME_DIR", corner.path())
        .output()
        .expect("a shell");
    let again: Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert_eq!(why, format!("gap_m {}", again["control"]["min_gap_m"]), "{repeat}");
}

#[test]
fn what_does_not_fit_is_refused_before_anything_runs() {
    let corner = corner(CAMPAIGN);
    let refused = |arguments: &[&str], words: &[&str]| {
        let output = corner.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output));
        let said = text(&output);
        assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
    };
    refused(&["campaign"], &["<CAMPAIGN>"]);
    refused(&["campaign", "none"], &["none", "kills"]);
    refused(&["campaign", "small.toml", "--shard", "4/3"], &["4/3", "I/N"]);
    refused(&["merge", "nowhere"], &["nowhere", "cannot read"]);
    let write = |text: String| {
        std::fs::write(corner.path().join("bad.toml"), text).expect("our own directory");
    };
    write(CAMPAIGN.replace("duration_s=3", "duration=3"));
    refused(&["campaign", "bad.toml"], &["duration=3", "^", "duration_s"]);
    write(CAMPAIGN.replace("[0.5, 1.5]", "[1.5, 0.5]"));
    refused(&["campaign", "bad.toml"], &["at_s", "the smaller first"]);
    write(CAMPAIGN.replace("\"corrupt\"", "\"kill\""));
    refused(&["campaign", "bad.toml"], &["faults", "kill"]);
    assert!(!corner.path().join("runs").exists(), "nothing was begun");
}
