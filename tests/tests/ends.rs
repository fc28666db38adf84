//! No end of a run leaves a process, shared memory, a socket or a file.

use rustix::process::{Pid, Signal, kill_process};
use std::process::{Child, Output};
use std::time::Duration;
use system_tests::{Corner, ignore_no_hang_up, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const SERVICES: [&str; 4] =
    ["timegap-plant", "timegap-perception-sim", "timegap-v2x-sim", "timegap-controller"];

fn signal(pid: i32, signal: Signal) {
    let pid = Pid::from_raw(pid).expect("a process id");
    kill_process(pid, signal).expect("our own process, not yet waited for");
}

fn pid(child: &Child) -> i32 {
    i32::try_from(child.id()).expect("fits")
}

/// A long realtime run that drives.
fn started(corner: &Corner) -> Child {
    started_with(corner, &[])
}

fn started_with(corner: &Corner, more: &[&str]) -> Child {
    let arguments = ["run", "following", "--duration", "600", "--out", "out"];
    let child = corner.start(&[&arguments, more].concat());
    assert!(wait_for(|| corner.path().join("out/live.json").exists()), "never drove");
    child
}

fn finished(child: Child) -> Output {
    child.wait_with_output().expect("our own child")
}

#[test]
fn completion() {
    let corner = Corner::new(PROGRAM);
    let output = corner.run(&["run", "cacc-a", "--duration", "1"]);
    assert!(output.status.success(), "{}", text(&output));
    corner.expect_nothing_left(&[]);
}

#[test]
fn interrupt_and_termination() {
    ignore_no_hang_up();
    for (kind, from) in
        [(Signal::INT, 130), (Signal::QUIT, 130), (Signal::TERM, 130), (Signal::HUP, 130)]
    {
        let corner = Corner::new(PROGRAM);
        let child = started(&corner);
        let roots = corner.roots();
        signal(pid(&child), kind);
        let output = finished(child);
        assert_eq!(output.status.code(), Some(from), "{}", text(&output));
        corner.expect_nothing_left(&roots);
    }
}

#[test]
fn interrupt_before_anything_was_started() {
    let corner = Corner::new(PROGRAM);
    for mode in ["lockstep", "realtime"] {
        let child = corner.start(&[
            "run",
            "following",
            "--mode",
            mode,
            "--duration",
            "600",
            "--out",
            "out",
        ]);
        // The first action of a run.
        while !corner.path().join("out/scenario.toml").exists() {
            std::thread::yield_now();
        }
        signal(pid(&child), Signal::INT);
        let output = finished(child);
        assert_eq!(output.status.code(), Some(130), "{}", text(&output));
        assert!(!corner.path().join("out").exists(), "nothing was driven");
        corner.expect_nothing_left(&[]);
    }
}

#[test]
fn death_of_any_service_that_is_not_to_be_restarted() {
    for service in SERVICES {
        let corner = Corner::new(PROGRAM);
        let child = started_with(&corner, &["--set", "supervision.restart=\"never\""]);
        let roots = corner.roots();
        signal(corner.wait_for_process(service), Signal::KILL);
        let output = finished(child);
        assert_eq!(output.status.code(), Some(1), "{}", text(&output));
        let name = service.trim_start_matches("timegap-");
        let said = text(&output);
        assert!(said.contains(name) && said.contains("SIGKILL"), "{said}");
        assert!(corner.path().join("out/summary.json").exists(), "the results are kept");
        corner.expect_nothing_left(&roots);
    }
}

#[test]
fn death_of_the_launcher_even_with_a_stopped_service() {
    for stopped in [None, Some("timegap-v2x-sim")] {
        let corner = Corner::new(PROGRAM);
        let child = started(&corner);
        let roots = corner.roots();
        if let Some(service) = stopped {
            signal(corner.wait_for_process(service), Signal::STOP);
        }
        signal(pid(&child), Signal::KILL);
        let _ = finished(child);
        corner.expect_nothing_left(&roots);
    }
}

#[test]
fn death_of_the_launcher_at_any_instant_of_its_start() {
    let corner = Corner::new(PROGRAM);
    for delay_ms in [0, 1, 2, 4, 7, 11, 16, 22, 30, 40, 60, 90] {
        let child =
            corner.start(&["run", "following", "--duration", "600", "--out", "out", "--force"]);
        std::thread::sleep(Duration::from_millis(delay_ms));
        let roots = corner.roots();
        signal(pid(&child), Signal::KILL);
        let _ = finished(child);
        // A launcher that dies before its janitor starts leaves an empty root to the next run.
        let gone = || corner.processes().is_empty() && Corner::shared_memory(&roots).is_empty();
        assert!(wait_for(gone), "after {delay_ms} ms: {:?}", corner.processes());
    }
    let output = corner.run(&["run", "cacc-a", "--mode", "lockstep"]);
    assert!(output.status.success(), "{}", text(&output));
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_dead_runs_leftovers_are_removed_by_the_next() {
    let corner = Corner::new(PROGRAM);
    let _ = corner.run(&["list"]);
    let uid = rustix::process::geteuid().as_raw();
    let root = corner.path().join(format!("timegap-{uid}")).join("dead-1");
    std::fs::create_dir_all(&root).expect("our own directory");
    let base = root.parent().expect("it has one");
    let private = std::os::unix::fs::PermissionsExt::from_mode(0o700);
    std::fs::set_permissions(base, private).expect("our own directory");
    std::fs::write(root.join("lock"), "").expect("our own directory");
    let memory = std::path::Path::new("/dev/shm/timegap_dead-1_segment");
    std::fs::write(memory, "left").expect("shared memory is writable");
    let output = corner.run(&["run", "cacc-a", "--mode", "lockstep"]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(!root.exists() && !memory.exists());
}

#[test]
fn two_runs_at_once_do_not_disturb_each_other() {
    let corner = Corner::new(PROGRAM);
    let alone = corner.json(&["run", "cut-in", "--mode", "lockstep", "--duration", "20"]);
    let start =
        || corner.start(&["run", "cut-in", "--mode", "lockstep", "--duration", "20", "--json"]);
    let both = [start(), start()];
    for child in both {
        let output = finished(child);
        assert!(output.status.success(), "{}", text(&output));
        let summary: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("one JSON object");
        assert_eq!(summary["messages"], alone["messages"]);
        assert_eq!(summary["control"], alone["control"]);
    }
    corner.expect_nothing_left(&[]);
    let runs = std::fs::read_dir(corner.path().join("runs")).expect("runs were kept").count();
    assert_eq!(runs, 3, "each run has a directory of its own");
}
