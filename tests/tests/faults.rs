//! Killed, stopped, silenced and impersonated services in whole process groups.

use iceoryx2::prelude::*;
use messages::Command as Message;
use runtime::Group;
use serde_json::Value;
use std::path::Path;
use system_tests::{Corner, csv, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

const ROAD: &str = "schema_version = 1\nname = \"faulty\"\nset_speed_mps = 20\n\
    [plant]\ninitial_speed_mps = 15\n[controller]\nname = \"cacc-mpc\"\n\
    [[actors]]\nname = \"lead\"\ngap_m = 40\ninitial_speed_mps = 12\n";

/// A corner with a scenario file `faulty.toml`: a drive behind a lead, with these faults.
fn corner(duration_s: f64, more: &str) -> Corner {
    let corner = Corner::new(PROGRAM);
    let text = format!("duration_s = {duration_s}\n{ROAD}{more}");
    std::fs::write(corner.path().join("faulty.toml"), text).expect("ours");
    corner
}

fn fault(kind: &str, at_s: f64, more: &str) -> String {
    format!("[[faults]]\nkind = \"{kind}\"\nat_s = {at_s}\n{more}\n")
}

/// Runs the scenario; returns its exit status and summary.
fn run(corner: &Corner, mode: &str) -> (Option<i32>, Value) {
    let arguments =
        ["run", "faulty.toml", "--mode", mode, "--out", "out", "--force", "--no-record", "--json"];
    let output = corner.run(&arguments);
    let summary =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", text(&output)));
    (output.status.code(), summary)
}

fn restarts(summary: &Value) -> Vec<u64> {
    let services = summary["services"].as_array().expect("a list").iter();
    services.map(|service| service["restarts"].as_u64().expect("a count")).collect()
}

#[test]
fn every_service_is_killed_once_and_the_drive_goes_on() {
    let services = ["controller", "perception-sim", "v2x-sim", "plant"];
    let faults = services
        .iter()
        .zip(1..)
        .map(|(service, k)| fault("kill", 0.6 * f64::from(k), &format!("service = \"{service}\"")));
    let corner = corner(4.0, &faults.collect::<String>());
    let (status, summary) = run(&corner, "realtime");
    assert_eq!((status, &summary["outcome"]), (Some(0), &"completed".into()), "{summary}");
    assert_eq!(restarts(&summary), [1, 1, 1, 1, 0]);
    let faults = summary["faults"].as_array().expect("a list");
    assert_eq!(faults.len(), 4, "{faults:?}");
    for fault in faults {
        let detected = fault["detected_after_us"].as_f64().expect("it was found gone");
        let recovered = fault["recovered_after_us"].as_f64().expect("it came back");
        assert!(0.0 < detected && detected < recovered, "{fault}");
    }
    // No vehicle disappeared with its process: the drive's gap continues.
    let text = std::fs::read_to_string(corner.path().join("out/trajectory.csv")).expect("kept");
    let gaps: Vec<f64> = (csv(&text, &["gap_m"]).iter().map(|row| row[0]))
        .filter(|gap_m| gap_m.is_finite())
        .collect();
    assert!(gaps.len() > 60, "{}", gaps.len());
    let jump_m = gaps.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(jump_m < 0.6, "the vehicle ahead jumped by {jump_m} m");
    corner.expect_nothing_left(&[]);
}

#[test]
fn recorder_and_janitor_may_be_killed_and_so_may_what_has_just_been_started() {
    let faults = fault("kill-helper", 0.5, "helper = \"recorder\"")
        + &fault("kill-helper", 0.8, "helper = \"janitor\"")
        + &fault("restart-storm", 1.0, "service = \"controller\"\ntimes = 2\nafter_start_ms = 1")
        + &fault("kill-helper", 3.0, "helper = \"launcher\"");
    let corner = corner(600.0, &faults);
    let output = corner.run(&["run", "faulty.toml", "--out", "out"]);
    // The second janitor cleans up after the launcher.
    assert_eq!(output.status.code(), None, "{}", text(&output));
    corner.expect_nothing_left(&[]);
    let whole =
        corner.run(&["run", "faulty.toml", "--out", "whole", "--json", "--duration", "2.5"]);
    let summary: Value = serde_json::from_slice(&whole.stdout).expect("one JSON object");
    assert_eq!(summary["outcome"], "completed", "{summary}");
    assert_eq!(restarts(&summary)[3], 2, "{summary}");
    let faults = summary["faults"].as_array().expect("a list");
    assert_eq!(faults[0]["helper"], "recorder", "{faults:?}");
    assert_eq!(faults[3]["while_starting"], true, "{faults:?}");
    assert_eq!(summary["recording"]["failed"], "killed by SIGKILL");
    let unrecorded = corner.run(&["run", "faulty.toml", "--out", "none", "--no-record"]);
    assert_eq!(unrecorded.status.code(), Some(2), "{}", text(&unrecorded));
    corner.expect_nothing_left(&[]);
}

#[test]
fn the_next_process_of_each_service_is_started_ahead() {
    let corner = corner(600.0, "");
    let child = corner.start(&["run", "faulty.toml", "--out", "out", "--no-record"]);
    let ahead = corner.wait_for_process("prepare-controller");
    let kill = |pid: i32, signal| {
        let pid = rustix::process::Pid::from_raw(pid).expect("a process id");
        rustix::process::kill_process(pid, signal).expect("of our own run");
    };
    kill(corner.wait_for_process("timegap-controller"), rustix::process::Signal::KILL);
    // The same process under its service's name.
    assert!(wait_for(|| corner.processes().contains(&(ahead, "timegap-controller".into()))));
    assert_ne!(corner.wait_for_process("prepare-controller"), ahead);
    kill(i32::try_from(child.id()).expect("fits"), rustix::process::Signal::INT);
    let output = child.wait_with_output().expect("our own child");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output));
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_stopped_service_is_replaced_and_a_short_stop_is_not() {
    let faults = fault("stop", 0.5, "service = \"v2x-sim\"\nfor_s = 0.05")
        + &fault("stop", 1.0, "service = \"perception-sim\"");
    let corner = corner(3.0, &faults);
    let (status, summary) = run(&corner, "realtime");
    assert_eq!(status, Some(0), "{summary}");
    // Services in order of the data flow: plant, perception-sim, v2x-sim, controller, aebs.
    assert_eq!(restarts(&summary)[1], 1, "{summary}");
    assert_eq!(restarts(&summary)[2], 0, "{summary}");
    let hung = &summary["faults"].as_array().expect("a list")[1];
    let detected = hung["detected_after_us"].as_f64().expect("it was found hung");
    assert!(detected >= 250e3, "not before the heartbeat's timeout: {hung}");
}

#[test]
fn a_busy_machine_is_endured_and_let_go_again() {
    let faults = fault("hog", 0.3, "core = 0\nfor_s = 1") + &fault("memory", 0.5, "megabytes = 64");
    let corner = corner(2.0, &faults);
    let (status, summary) = run(&corner, "realtime");
    assert_eq!((status, restarts(&summary)), (Some(0), vec![0; 5]), "{summary}");
    assert_eq!(summary["faults"].as_array().map(Vec::len), Some(2), "{summary}");
    for service in summary["services"].as_array().expect("a list") {
        let heartbeats = service["heartbeats"]["count"].as_u64();
        assert!((10..=25).contains(&heartbeats.expect("counted")), "{service}");
    }
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_service_that_dies_too_often_leads_to_a_stop_in_lane() {
    let storm = fault("restart-storm", 0.5, "service = \"controller\"\ntimes = 50");
    let budget = "[supervision]\nbudget = 3\n";
    let corner = corner(30.0, &(budget.to_owned() + &storm));
    let (status, summary) = run(&corner, "realtime");
    assert_eq!((status, &summary["outcome"]), (Some(1), &"safe_stop".into()), "{summary}");
    assert_eq!(restarts(&summary), [0, 0, 0, 3, 0]);
    assert!(summary["duration_s"].as_f64() < Some(25.0), "it ended when the vehicle stood");
    let stopping = summary["rungs"]["plant"]["time_s"]["stop-in-lane"].as_f64();
    assert!(stopping > Some(2.0), "{}", summary["rungs"]);
    corner.expect_nothing_left(&[]);
}

#[test]
fn message_faults_repeat_byte_by_byte_and_no_corruption_passes() {
    let radar = "topic = \"radar/tracks\"\nfor_s = 2\nprobability = 0.3";
    let faults = fault("corrupt", 1.0, &format!("{radar}\nbits = 7"))
        + &fault("delay", 2.0, &format!("{radar}\ndelay_ms = 60\njitter_ms = 100"))
        + &fault("reorder", 3.0, radar)
        + &fault("duplicate", 4.0, "topic = \"vehicle/odometry\"\nfor_s = 1")
        + &fault("drop", 5.0, "topic = \"radar/tracks\"\nfor_s = 2.5")
        + &fault("freeze", 9.0, "topic = \"v2x/spat\"\nfor_s = 1")
        + &fault("clock-step", 11.0, "service = \"v2x-sim\"\namount = 30\nfor_s = 1");
    let corner = corner(14.0, &faults);
    let [first, second] = [run(&corner, "lockstep"), run(&corner, "lockstep")];
    assert_eq!(first.0, Some(0), "{}", first.1);
    for (topic, counts) in first.1["messages"].as_object().expect("topics") {
        assert_eq!(counts["digests"], second.1["messages"][topic]["digests"], "{topic}");
        assert_eq!(counts["e2e"], second.1["messages"][topic]["e2e"], "{topic}");
    }
    let faults = first.1["faults"].as_array().expect("a list");
    let disturbed = |kind: &str| {
        let fault = faults.iter().find(|fault| fault["kind"] == kind).expect("it was asked for");
        fault["messages"].as_u64().expect("counted")
    };
    assert_eq!(first.1["messages"]["radar/tracks"]["e2e"]["error"], disturbed("corrupt"));
    assert_eq!(first.1["messages"]["vehicle/odometry"]["e2e"]["repeated"], disturbed("duplicate"));
    assert!(disturbed("corrupt") > 0 && disturbed("drop") > 40);
    let future = &first.1["messages"]["v2x/spat"]["e2e"]["from_the_future"];
    assert!(future.as_u64() > Some(5), "{future}");
    // 2.5 s without radar: the lead is predicted, then the vehicle brakes, then it uses the radar again.
    let rungs = &first.1["rungs"]["controller"];
    assert!(rungs["time_s"]["lead-predicted"].as_f64() > Some(0.5), "{rungs}");
    assert!(rungs["time_s"]["lead-lost"].as_f64() > Some(0.5), "{rungs}");
    let last = rungs["changes"].as_array().and_then(|changes| changes.last()).expect("changes");
    assert_eq!(last["to"], "full", "{rungs}");
}

#[test]
fn a_controller_whose_clock_is_behind_stops_at_a_red_light() {
    let corner = Corner::new(PROGRAM);
    let lights = ["--set", "v2x.signals.0.offset_s=14", "--set", "v2x.signals.1.offset_s=11"];
    let run = ["run", "corridor", "--mode", "lockstep", "--in-process", "--duration", "40"];
    for behind_s in [0.3, 0.8, 1.0] {
        let fault = format!(
            "faults=[{{ kind = \"clock-step\", service = \"controller\", amount = -{behind_s}, \
             for_s = 12.0, when = {{ red_line_below_m = 67.0 }} }}]"
        );
        let summary = corner.json(&[&run[..], &lights, &["--set", &fault]].concat());
        assert_eq!(summary["outcome"], "completed", "{behind_s}: {summary}");
        assert!(summary["faults"][0]["messages"].as_u64() > Some(100), "{}", summary["faults"]);
        let levels = &summary["rungs"]["plant"]["time_s"];
        assert_eq!(levels["full"], 40.0, "its plans are followed from their start: {levels}");
    }
}

#[test]
fn a_clock_that_is_ahead_is_counted_and_changes_nothing() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "cacc-a", "--mode", "lockstep", "--in-process", "--duration", "6"];
    let whole = corner.json(&run);
    for ahead_s in [0.0001, 0.0049, 0.09, 3.0] {
        let fault = format!(
            "faults=[{{ kind = \"clock-step\", service = \"controller\", amount = {ahead_s}, at_s = 1 }}]"
        );
        let summary = corner.json(&[&run[..], &["--set", &fault]].concat());
        let disturbed = summary["faults"][0]["messages"].as_u64();
        assert!(disturbed > Some(50), "{}", summary["faults"]);
        let ahead = &summary["messages"]["control/command"]["e2e"]["from_the_future"];
        assert!(ahead.as_u64() > Some(40), "{ahead_s}: {ahead}");
        assert_eq!(summary["rungs"]["plant"]["time_s"], whole["rungs"]["plant"]["time_s"]);
        assert_eq!(summary["control"], whole["control"], "{ahead_s}");
    }
}

#[test]
fn no_service_whose_clock_is_ahead_leaves_the_others_blind() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "tight-brake", "--mode", "lockstep", "--in-process"];
    let whole = corner.json(&run);
    let least_m = |summary: &Value| summary["control"]["min_gap_m"].as_f64().expect("a gap");
    for service in ["perception-sim", "aebs", "controller", "plant"] {
        let fault = format!(
            "faults=[{{ kind = \"clock-step\", service = \"{service}\", amount = 0.11, at_s = 0.5 }}]"
        );
        let summary = corner.json(&[&run[..], &["--set", &fault]].concat());
        assert_eq!(summary["outcome"], "completed", "{service}: {summary}");
        let levels = &summary["rungs"]["plant"]["time_s"];
        assert_eq!(levels, &whole["rungs"]["plant"]["time_s"], "{service}");
        let apart_m = least_m(&summary) - least_m(&whole);
        assert!(apart_m.abs() < 0.2, "{service}: {apart_m}");
    }
}

#[test]
fn the_counts_of_a_fault_outlive_its_process() {
    let corner = corner(
        3.0,
        "[[faults]]\nkind = \"corrupt\"\ntopic = \"control/command\"\nat_s = 0.5\nfor_s = 0.5\n\
         [[faults]]\nkind = \"stale\"\ntopic = \"vehicle/odometry\"\namount = 0.05\nat_s = 0.5\nfor_s = 0.2\n\
         [[faults]]\nkind = \"kill\"\nservice = \"plant\"\nat_s = 1.5\n",
    );
    let output = corner.run(&["run", "faulty.toml", "--mode", "realtime", "--no-record", "--json"]);
    let summary: Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert_eq!(restarts(&summary)[0], 1, "{summary}");
    let faults = summary["faults"].as_array().expect("a list");
    let of = |kind: &str| faults.iter().find(|fault| fault["kind"] == kind).expect("it struck");
    for kind in ["corrupt", "stale"] {
        let fault = of(kind);
        assert!(fault["messages"].as_u64() >= Some(3), "{fault}");
        let begun_s = fault["t_s"].as_f64().expect("a time");
        assert!((0.4..1.1).contains(&begun_s), "{fault}");
    }
}

#[test]
fn the_held_command_of_a_plant_that_died_reacts_once() {
    let kill = |at_s: f64| fault("kill", at_s, "service = \"plant\"");
    let corner = corner(4.0, &[0.95, 1.45, 1.95, 2.45, 2.95].map(kill).concat());
    let (status, summary) = run(&corner, "realtime");
    assert_eq!((status, restarts(&summary)[0]), (Some(0), 5), "{summary}");
    let count = |value: &Value| value.as_u64().expect("a count");
    for (reaction, topic) in [
        (&summary["timing"]["reaction_time_us"], "radar/tracks"),
        (&summary["aebs"]["reaction_time_us"], "radar/detections"),
    ] {
        let (reactions, samples) = (&reaction["count"], &summary["messages"][topic]["sent"]);
        assert!(count(reactions) > 20, "{topic}: {reaction}");
        assert!(count(reactions) <= count(samples), "{topic}: {reactions} of {samples}");
    }
}

#[test]
fn faults_come_into_a_run_that_goes_on() {
    let corner = corner(4.0, "");
    let arguments =
        ["run", "faulty.toml", "--mode", "realtime", "--out", "out", "--no-record", "--json"];
    let running = corner.start(&arguments);
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "the run drives");
    for (arguments, status) in [
        (["inject", "out", "kill", "controller"].as_slice(), 0),
        (&["inject", "out", "drop", "v2x/spat", "--for", "0.5"], 0),
        (&["inject", "out", "kill"], 2),
        (&["inject", "out", "kill", "engine"], 2),
        (&["inject", "out", "drop", "health/heartbeat"], 2),
        (&["inject", "out", "drop", "radio/frames"], 2),
        (&["inject", "out", "clock-step", "obu", "--amount", "1"], 2),
        (&["inject", "out", "kill", "obu"], 2),
        (
            &[
                "inject", "out", "bias", "v2x/spat", "--field", "end_s", "--amount", "1", "--for",
                "0.1",
            ],
            0,
        ),
        (&["inject", "nowhere", "kill", "controller"], 2),
    ] {
        let output = corner.run(arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", text(&output));
    }
    let output = running.wait_with_output().expect("it ends");
    let summary: Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert_eq!(restarts(&summary), [0, 0, 0, 1, 0], "{summary}");
    let kinds: Vec<_> = (summary["faults"].as_array().expect("a list").iter())
        .map(|fault| fault["kind"].as_str().expect("a name").to_owned())
        .collect();
    assert_eq!(kinds, ["kill", "drop", "bias"]);
}

#[test]
fn process_faults_in_lockstep_and_senseless_ones_are_refused_before_anything_runs() {
    for (fault, what) in [
        (fault("kill", 1.0, "service = \"plant\""), "realtime"),
        (fault("kill", 1.0, "service = \"plant\""), "faulty.toml:"),
        (fault("kill", 1.0, ""), "needs `service`"),
        (fault("drop", 1.0, "topic = \"health/heartbeat\""), "radar/tracks"),
        (
            fault("bias", 1.0, "topic = \"v2x/spat\"\nfield = \"gap_m\"\namount = 1"),
            "no such figure",
        ),
        (fault("drop", 1.0, "topic = \"v2x/spat\"\nbits = 1"), "means nothing"),
        (fault("melt", 1.0, ""), "kind"),
    ] {
        let corner = corner(1.0, &fault);
        let output = corner.run(&["run", "faulty.toml", "--mode", "lockstep", "--out", "out"]);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(what), "{what}: {}", text(&output));
    }
}

/// A process of the same user opens `control/command` with correct type and header names, and requests full
/// braking.
#[test]
fn an_unknown_sender_on_the_command_topic_is_ignored_and_reported() {
    let corner = corner(3.0, "");
    let arguments =
        ["run", "faulty.toml", "--mode", "realtime", "--out", "out", "--no-record", "--json"];
    let running = corner.start(&arguments);
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "the run drives");
    let group: Group = serde_json::from_str(&std::fs::read_to_string(&live).expect("it drives"))
        .expect("a group file");
    impersonate(&group);
    let output = running.wait_with_output().expect("it ends");
    let summary: Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let unknown = summary["messages"]["control/command"]["e2e"]["stranger"].as_u64();
    assert!(unknown > Some(0), "{}", summary["messages"]["control/command"]);
    let braking = summary["control"]["min_accel_mps2"].as_f64().expect("it drove");
    assert!(braking > -1.0, "the vehicle did not brake: {braking}");
}

fn impersonate(group: &Group) {
    let mut config = iceoryx2::config::Config::default();
    config.global.prefix = FileName::new(group.prefix.as_bytes()).expect("short");
    let root = group.root.to_str().expect("text");
    config.global.set_root_path(&iceoryx2::prelude::Path::new(root.as_bytes()).expect("short"));
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>().expect("same user");
    let name: ServiceName = "control/command".try_into().expect("a name");
    let topic = node.service_builder(&name).publish_subscribe::<Message>().open().expect("it is");
    let publisher = topic.publisher_builder().create().expect("there is room");
    for sequence in 1..=50 {
        let mut message: Message = bytemuck::Zeroable::zeroed();
        message.header.sequence = sequence;
        message.header.source = messages::Service::Controller.to_wire();
        message.header.step = sequence;
        message.plan_period_ns = 100_000_000;
        message.plan_len = 1;
        message.plan_mps2[0] = -8.0;
        let data_id = messages::Topic::Command.data_id(message.header.source);
        let bytes = bytemuck::bytes_of_mut(&mut message);
        messages::e2e::profile7::protect(bytes, data_id, u32::try_from(sequence).expect("small"));
        publisher.send_copy(message).expect("sent");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
}

#[test]
fn the_files_of_a_run_are_for_its_user_alone() {
    use std::os::unix::fs::PermissionsExt;
    let corner = corner(3.0, "");
    let mut running = corner.start(&["run", "faulty.toml", "--mode", "realtime", "--out", "out"]);
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "the run drives");
    let roots = corner.roots();
    let mode = |path: &Path| {
        let metadata = std::fs::symlink_metadata(path).expect("it is there");
        metadata.permissions().mode() & 0o777
    };
    assert_eq!(roots.len(), 1);
    assert_eq!(mode(&roots[0]), 0o700);
    let memory = Corner::shared_memory(&roots);
    assert!(!memory.is_empty());
    for name in memory {
        let mode = mode(&Path::new("/dev/shm").join(&name));
        assert_eq!(mode & 0o077, 0, "{name}: {mode:o}");
    }
    assert!(running.wait().expect("it ends").success());
    corner.expect_nothing_left(&roots);
}
