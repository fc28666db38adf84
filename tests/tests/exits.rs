//! Every end of a process of the group has one outcome (the table of `supervise::exits`).

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::process::Child;
use system_tests::{Corner, status_of, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

const ROAD: &str = "schema_version = 1\nname = \"road\"\nset_speed_mps = 20\n\
    [plant]\ninitial_speed_mps = 15\n[controller]\nname = \"cacc-mpc\"\n\
    [[actors]]\nname = \"lead\"\ngap_m = 40\ninitial_speed_mps = 12\n";

/// A drive behind a lead with additional keys.
fn corner(duration_s: f64, more: &str) -> Corner {
    let corner = Corner::new(PROGRAM);
    let text = format!("duration_s = {duration_s}\n{ROAD}{more}");
    std::fs::write(corner.path().join("road.toml"), text).expect("ours");
    corner
}

fn start(corner: &Corner, more: &[&str]) -> Child {
    let arguments = ["run", "road.toml", "--out", "out", "--no-record", "--json"];
    let child = corner.start(&[&arguments, more].concat());
    assert!(wait_for(|| corner.path().join("out/live.json").exists()), "never drove");
    child
}

/// Number of waits of a process: several per step in lockstep.
fn waits(pid: i32) -> Option<u64> {
    status_of(pid, "voluntary_ctxt_switches")
}

fn finish(child: Child) -> (Option<i32>, Value) {
    let output = child.wait_with_output().expect("our own child");
    let summary =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output)));
    (output.status.code(), summary)
}

fn send(pid: i32, signal: Signal) {
    kill_process(Pid::from_raw(pid).expect("a process id"), signal).expect("it lives");
}

/// Reports count from the start of a run, through any death.
fn count(summary: &Value, path: &str) -> u64 {
    summary.pointer(path).and_then(Value::as_u64).unwrap_or_else(|| panic!("{path}: {summary}"))
}

#[test]
fn a_service_that_is_ended_from_outside_is_replaced_and_its_past_counts() {
    let services =
        ["timegap-controller", "timegap-perception-sim", "timegap-v2x-sim", "timegap-plant"];
    let corner = corner(6.0, "");
    let running = start(&corner, &[]);
    for (service, signal) in services.into_iter().zip([Signal::TERM, Signal::INT].repeat(2)) {
        let pid = corner.wait_for_process(service);
        // Each has a history that could be lost.
        std::thread::sleep(std::time::Duration::from_millis(900));
        send(pid, signal);
        assert!(wait_for(|| corner.wait_for_process(service) != pid), "{service} is not replaced");
    }
    let (status, summary) = finish(running);
    assert_eq!((status, &summary["outcome"]), (Some(0), &"completed".into()), "{summary}");
    let restarts: Vec<_> = (summary["services"].as_array().expect("a list").iter())
        .map(|service| service["restarts"].as_u64())
        .collect();
    assert_eq!(restarts, [1, 1, 1, 1, 0].map(Some), "the emergency brake lived on: {summary}");
    let faults = summary["faults"].as_array().expect("a list");
    assert_eq!(faults.len(), 4, "{faults:?}");
    for fault in faults {
        assert_eq!(fault["kind"], "died");
        assert!(fault["detected_after_us"].is_null(), "its instant was not measured: {fault}");
        assert!(fault["recovered_after_us"].is_f64(), "{fault}");
    }
    // 600 steps, 60 control cycles: the counts of dead processes remain.
    let odometry = "/messages/vehicle~1odometry";
    assert!(count(&summary, &format!("{odometry}/sent")) > 560, "{}", summary["messages"]);
    let (sent, received) = (
        count(&summary, &format!("{odometry}/sent")),
        count(&summary, &format!("{odometry}/received")),
    );
    assert!(received <= sent && received > 300, "{}", summary["messages"]);
    assert!((50..=64).contains(&count(&summary, "/timing/cycles")), "{}", summary["timing"]);
    // Percentiles include all processes; each lacks at most its last cycle.
    let cycles = count(&summary, "/timing/cycles");
    for times in ["release_jitter_us", "solve_us"] {
        let counted = count(&summary, &format!("/timing/{times}/count"));
        assert!((cycles - 10..=cycles).contains(&counted), "{times}: {}", summary["timing"]);
    }
    assert!(count(&summary, "/timing/data_age_us/count") > 520, "{}", summary["timing"]);
    assert!(count(&summary, "/timing/reaction_time_us/count") > 45, "{}", summary["timing"]);
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_service_that_was_given_up_never_leaves_a_completed_run() {
    let storm = "[[faults]]\nkind = \"restart-storm\"\nservice = \"controller\"\nat_s = 0.5\n\
                 times = 50\n[supervision]\nbudget = 1\n";
    // It ends before the vehicle stands.
    let corner = corner(2.5, storm);
    let (status, summary) = finish(start(&corner, &[]));
    assert_eq!((status, &summary["outcome"]), (Some(1), &"aborted".into()), "{summary}");
    let why = summary["aborted_because"].as_str().expect("a reason");
    assert!(why.contains("controller ended too often"), "{why}");
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_plant_that_is_gone_ends_the_run_with_its_last_figures() {
    let storm = "[[faults]]\nkind = \"restart-storm\"\nservice = \"plant\"\nat_s = 1\n\
                 times = 50\n[supervision]\nbudget = 1\n";
    for more in [[].as_slice(), &["--set", "supervision.services.plant=\"never\""]] {
        let corner = corner(600.0, storm);
        let (status, summary) = finish(start(&corner, more));
        assert_eq!((status, &summary["outcome"]), (Some(1), &"aborted".into()), "{summary}");
        let driven_s = summary["duration_s"].as_f64();
        assert!(driven_s > Some(0.9) && driven_s < Some(30.0), "{summary}");
        let gap_m = summary["control"]["min_gap_m"].as_f64();
        assert!(gap_m > Some(30.0) && gap_m < Some(41.0), "{}", summary["control"]);
        corner.expect_nothing_left(&[]);
    }
}

/// In lockstep all wait for a stopped process: the error names it and the reached time. Two groups wait at once.
#[test]
fn a_stopped_service_is_named_in_lockstep() {
    std::thread::scope(|scope| {
        for service in ["controller", "plant"] {
            scope.spawn(move || is_named_when_it_is_stopped(service));
        }
    });
}

fn is_named_when_it_is_stopped(service: &str) {
    let corner = corner(3000.0, "");
    let running = start(&corner, &["--mode", "lockstep"]);
    let pid = corner.wait_for_process(&format!("timegap-{service}"));
    // Stopped in its first step, it would have driven nowhere.
    assert!(wait_for(|| waits(pid) > Some(2000)), "it does not drive");
    send(pid, Signal::STOP);
    let (status, summary) = finish(running);
    assert_eq!((status, &summary["outcome"]), (Some(1), &"aborted".into()), "{summary}");
    let why = summary["aborted_because"].as_str().unwrap_or_default();
    assert!(why.contains(service) && why.contains("hung"), "{why}");
    let services = summary["services"].as_array().expect("a list");
    let stopped = services.iter().find(|one| one["name"] == service).expect("it is listed");
    assert_eq!(stopped["exit"], "hung", "{stopped}");
    assert!(summary["duration_s"].as_f64() > Some(0.0), "{summary}");
    corner.expect_nothing_left(&[]);
}

/// A command late at the plant is late, whatever the controller reports.
#[test]
fn commands_that_do_not_come_are_missed_at_the_plant() {
    let silence = "[[faults]]\nkind = \"drop\"\ntopic = \"control/command\"\nat_s = 1\nfor_s = 1\n";
    let corner = corner(3.0, silence);
    for mode in ["realtime", "lockstep"] {
        let summary = corner.json(&["run", "road.toml", "--no-record", "--mode", mode]);
        let missed = count(&summary, "/timing/missed_at_plant");
        assert!((9..=13).contains(&missed), "{mode}: {}", summary["timing"]);
        assert!(count(&summary, "/timing/worst_deadline_misses") >= missed);
    }
}
