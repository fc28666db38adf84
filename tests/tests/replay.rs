//! Replay: recorded inputs give the recorded commands again, through the real controller.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Replays `out` and expects all `cycles` commands to be identical.
fn expect_identical(corner: &Corner, cycles: u64) -> Value {
    let replayed = corner.json(&["recording", "replay", "out"]);
    assert_eq!(replayed["identical"], true, "{replayed}");
    assert_eq!(replayed["cycles"], cycles, "{replayed}");
    assert_eq!(replayed["identical_commands"], replayed["commands"]);
    assert_eq!(replayed["identical_diagnostics"], cycles);
    assert_eq!(replayed["first_difference"], Value::Null);
    corner.expect_nothing_left(&[]);
    replayed
}

#[test]
fn a_lockstep_run_repeats_to_the_byte() {
    let corner = Corner::new(PROGRAM);
    for (scenario, controller) in
        [("cut-in", "acc-mpc"), ("cacc-a", "cacc-mpc"), ("cut-in", "quadratic-bounded")]
    {
        let law = ["--controller", controller];
        let run =
            ["run", scenario, "--mode", "lockstep", "--duration", "8", "--out", "out", "--force"];
        let summary = corner.json(&[&run[..], &law[..]].concat());
        let cycles = summary["timing"]["cycles"].as_u64().expect("a count");
        let replayed = expect_identical(&corner, cycles);
        assert_eq!(replayed["not_compared"], Value::Array(Vec::new()), "every byte");
    }
}

#[test]
fn a_realtime_run_repeats_also_across_a_restart() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "cut-in", "--duration", "6", "--out", "out", "--json"];
    let child = corner.start(&run);
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "never drove");
    let file = corner.path().join("out/recording.mcap");
    let written = || std::fs::metadata(&file).is_ok_and(|file| file.len() > 20_000);
    assert!(wait_for(written), "nothing was recorded");
    let controller = Pid::from_raw(corner.wait_for_process("timegap-controller"));
    kill_process(controller.expect("a process id"), Signal::KILL).expect("ours");
    let output = child.wait_with_output().expect("our child");
    assert!(output.status.success(), "{}", text(&output));
    let info = corner.json(&["recording", "info", "out"]);
    assert_eq!(info["incarnations"]["controller"], 2, "{info}");
    let cycles = info["topics"]["control/command"]["messages"].as_u64().expect("a count");
    let replayed = expect_identical(&corner, cycles);
    let free = replayed["not_compared"].as_array().expect("names");
    assert!(free.iter().all(|field| field != "plan_mps2" && field != "header.origins"), "{free:?}");
}

#[test]
fn a_disturbed_run_repeats_with_its_silent_cycles() {
    const FAULTS: &str = r#"
        [[faults]]
        kind = "drop"
        topic = "vehicle/odometry"
        at_s = 1.0
        for_s = 2.2

        # The radar's measurement of the ego's speed would take its place.
        [[faults]]
        kind = "drop"
        topic = "radar/tracks"
        at_s = 0.9
        for_s = 2.4

        [[faults]]
        kind = "corrupt"
        topic = "radar/tracks"
        probability = 0.3
        bits = 3
        at_s = 3.3

        [[faults]]
        kind = "delay"
        topic = "vehicle/odometry"
        delay_ms = 30
        jitter_ms = 40
        at_s = 3.2
    "#;
    let corner = Corner::new(PROGRAM);
    let scenario = corner.run(&["list", "--show", "cut-in"]);
    let scenario = String::from_utf8(scenario.stdout).expect("text") + FAULTS;
    std::fs::write(corner.path().join("faulty.toml"), scenario).expect("writable");
    let summary = corner.json(&["run", "faulty.toml", "--duration", "4", "--out", "out"]);
    let cycles = summary["timing"]["cycles"].as_u64().expect("a count");
    let replayed = expect_identical(&corner, cycles);
    // A silent cycle sends an empty plan, which is a command too.
    assert_eq!(replayed["commands"], cycles, "{replayed}");
    let silent = summary["rungs"]["controller"]["time_s"]["silent"].as_f64();
    assert!(silent > Some(0.3), "no cycle was silent: {}", summary["rungs"]);
}

#[test]
fn another_law_and_a_changed_one_are_compared() {
    let corner = Corner::new(PROGRAM);
    let summary = corner.json(&["run", "--mode", "lockstep", "--out", "out"]);
    let cycles = summary["timing"]["cycles"].as_u64().expect("a count");
    for change in [["--controller", "acc-mpc"], ["--set", "set_speed_mps=12"]] {
        let replayed = corner.json(&[&["recording", "replay", "out"][..], &change[..]].concat());
        assert_eq!((&replayed["identical"], &replayed["changed"]), (&false.into(), &true.into()));
        assert!(replayed["max_request_difference_mps2"].as_f64() > Some(0.01), "{replayed}");
        let field = &replayed["first_difference"]["field"];
        assert!(field.as_str().is_some_and(|field| !field.contains("protection")), "{replayed}");
        let table = std::fs::read_to_string(corner.path().join("out/replay.csv")).expect("written");
        let rows = system_tests::csv(
            &table,
            &["recorded_request_mps2", "replayed_request_mps2", "difference_mps2"],
        );
        assert_eq!(rows.len() as u64, cycles);
        assert!(rows.iter().all(|row| row[1] - row[0] == row[2]));
    }
    corner.expect_nothing_left(&[]);
}
