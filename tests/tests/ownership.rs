//! A results directory has one owner, and holds the results of one command.

use rustix::process::{Pid, Signal, kill_process};
use std::path::Path;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn files(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    let mut names: Vec<_> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Names and bytes of a directory's files.
fn contents(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let of = |name: String| (name.clone(), std::fs::read(directory.join(name)).unwrap_or_default());
    files(directory).into_iter().map(of).collect()
}

#[test]
fn results_are_never_mixed() {
    let corner = Corner::new(PROGRAM);
    let out = corner.path().join("out");
    let refused = |arguments: &[&str], words: &str| {
        let output = corner.run(&[arguments, &["--out", "out"]].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output));
        assert!(text(&output).contains(words), "{arguments:?}: {}", text(&output));
    };
    let running = corner.start(&["run", "following", "--duration", "600", "--out", "out"]);
    assert!(wait_for(|| out.join("live.json").exists()), "never drove");
    let before = files(&out);
    let lockstep = ["run", "cacc-a", "--mode", "lockstep"];
    refused(&lockstep, "still running");
    refused(&["run", "cacc-a", "--mode", "lockstep", "--force"], "still running");
    refused(&["sweep", "cacc-a", "--vary", "set_speed_mps=10..12/2"], "still running");
    assert_eq!(files(&out), before);
    let pid = Pid::from_raw(i32::try_from(running.id()).expect("fits")).expect("not zero");
    kill_process(pid, Signal::INT).expect("our own process, not yet waited for");
    let output = running.wait_with_output().expect("our own child");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output));

    let before = contents(&out);
    refused(&lockstep, "--force");
    refused(&["sweep", "cacc-a", "--vary", "set_speed_mps=10..12/2"], "--force");
    let output =
        corner.run(&["run", "--service", "controller=/bin/false", "--out", "out", "--force"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    let study = ["search", "tight-brake", "--vary", "actors.0.gap_m=1..2", "--budget", "2"];
    let none = ["--set", "actors.0.initial_speed_mps=0", "--out", "out", "--force"];
    let output = corner.run(&[&study[..], &none].concat());
    assert_eq!(output.status.code(), Some(2), "no scene can be avoided: {}", text(&output));
    assert!(contents(&out) == before, "what was refused, or did not start, left all as it was");
    for old in ["trace.pftrace", "notes.txt"] {
        std::fs::write(out.join(old), "old").expect("our own directory");
    }
    std::fs::create_dir(out.join("csv")).expect("our own directory");
    let output = corner.run(&[&lockstep, ["--out", "out", "--force"].as_slice()].concat());
    assert!(output.status.success(), "{}", text(&output));
    let expected = [
        "metadata.yaml",
        "notes.txt",
        "recording.mcap",
        "report.html",
        "scenario.toml",
        "summary.json",
        "trajectory.csv",
    ];
    assert_eq!(files(&out), expected, "nothing of the run before, and nothing of the user's lost");
}

#[test]
fn a_run_that_does_not_start_leaves_nothing() {
    let corner = Corner::new(PROGRAM);
    for arguments in [
        ["run", "--service", "controller=/bin/false"].as_slice(),
        &["run", "--service", "controller=/bin/false", "--out", "a/b"],
    ] {
        let output = corner.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    }
    assert_eq!(files(corner.path()), [] as [&str; 0]);
}
