//! The recording: complete, harmless to the run, and readable after any damage.

use recorder::Recording;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::process::Child;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn kill(pid: i32) {
    let pid = Pid::from_raw(pid).expect("a process id");
    kill_process(pid, Signal::KILL).expect("our own process, not yet waited for");
}

/// Messages that the run's services sent.
fn sent(summary: &Value) -> u64 {
    let topics = summary["messages"].as_object().expect("topics");
    topics.values().map(|topic| topic["sent"].as_u64().expect("a count")).sum()
}

/// A run with a recording that holds messages. In lockstep a second of it takes milliseconds. It is long enough for the
/// recorder's end to come in the drive.
fn started(corner: &Corner, mode: &str) -> Child {
    let arguments =
        ["run", "following", "--mode", mode, "--duration", "800", "--out", "out", "--json"];
    let child = corner.start(&arguments);
    let file = corner.path().join("out/recording.mcap");
    let written = || std::fs::metadata(&file).is_ok_and(|file| file.len() > 60_000);
    assert!(wait_for(written), "nothing was recorded");
    child
}

#[test]
fn lockstep_recordings_lose_nothing_and_repeat() {
    let corner = Corner::new(PROGRAM);
    let run = |out: &str, seed: &str| {
        let arguments = ["run", "cut-in", "--mode", "lockstep", "--seed", seed, "--out", out];
        let summary = corner.json(&arguments);
        let recording = &summary["recording"];
        assert_eq!(recording["failed"], Value::Null);
        assert_eq!(
            (recording["lost"].as_u64(), recording["messages"].as_u64()),
            (Some(0), Some(sent(&summary)))
        );
        summary["messages"].clone()
    };
    let recorded = run("a", "7");
    assert_eq!(recorded, run("b", "7"));
    let bytes = |run: &str| {
        std::fs::read(corner.path().join(run).join(recorder::FILE)).expect("just recorded")
    };
    assert!(bytes("a") == bytes("b"), "the same run gives the same file");
    run("c", "8");
    let unrecorded = corner.json(&[
        "run",
        "cut-in",
        "--mode",
        "lockstep",
        "--seed",
        "7",
        "--no-record",
        "--out",
        "d",
    ]);
    assert_eq!(unrecorded["recording"], Value::Null);
    assert!(!corner.path().join("d/recording.mcap").exists());
    assert_eq!(recorded, unrecorded["messages"], "the recorder changes nothing");

    assert_eq!(corner.json(&["recording", "diff", "a", "b"])["equal"], true);
    let output = corner.run(&["recording", "diff", "a", "c", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let first: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let first = &first["first"];
    assert_eq!(first["topic"], "radar/tracks", "only the radar draws lots at first");
    assert_eq!(first["source"], "perception-sim");
    assert_ne!(first["a"], first["b"]);
    let output = corner.run(&["recording", "diff", "a", "c"]);
    let field = first["field"].as_str().expect("a field");
    assert!(text(&output).contains(field), "{}", text(&output));
}

#[test]
fn at_one_kilohertz_every_message_is_recorded_or_counted() {
    let corner = Corner::new(PROGRAM);
    let fast = ["plant", "perception", "v2x", "controller"].map(|s| format!("{s}.period_ms=1"));
    // The only law that runs at such a period.
    let mut arguments =
        vec!["run", "cacc-a", "--controller", "six-mode", "--duration", "3", "--out", "out"];
    for key in &fast {
        arguments.extend(["--set", key]);
    }
    let summary = corner.json(&arguments);
    let recording = &summary["recording"];
    let [messages, lost] =
        ["messages", "lost"].map(|key| recording[key].as_u64().expect("a count"));
    assert_eq!(messages + lost, sent(&summary), "{recording}");
    assert!(messages > 3000, "{recording}");
    let read = Recording::open(&corner.path().join("out")).expect("a recording");
    assert_eq!(read.records().count() as u64, messages);
    assert_eq!(read.survey().tally.lost(), lost);
}

#[test]
fn the_recorder_is_no_real_time_process() {
    let corner = Corner::new(PROGRAM);
    let child = started(&corner, "realtime");
    let pid = corner.wait_for_process("timegap-recorder");
    // The policy of each thread, field 41 of stat(5), counted after the name: 0 is SCHED_OTHER.
    let tasks = std::fs::read_dir(format!("/proc/{pid}/task")).expect("it lives");
    let policies: Vec<_> = tasks
        .flatten()
        .filter_map(|task| std::fs::read_to_string(task.path().join("stat")).ok())
        .filter_map(|stat| {
            stat.rsplit_once(") ").and_then(|(_, rest)| rest.split(' ').nth(38).map(str::to_owned))
        })
        .collect();
    kill_process(Pid::from_child(&child), Signal::INT).expect("our child");
    child.wait_with_output().expect("our child");
    assert!(policies.len() > 1 && policies.iter().all(|policy| policy == "0"), "{policies:?}");
}

#[test]
fn a_realtime_run_outlives_its_recorder() {
    outlives_its_recorder("realtime");
}

#[test]
fn a_lockstep_run_outlives_its_recorder() {
    outlives_its_recorder("lockstep");
}

fn outlives_its_recorder(mode: &str) {
    let corner = Corner::new(PROGRAM);
    let child = started(&corner, mode);
    let roots = corner.roots();
    kill(corner.wait_for_process("timegap-recorder"));
    if mode == "realtime" {
        let launcher = Pid::from_child(&child);
        std::thread::sleep(std::time::Duration::from_millis(200));
        kill_process(launcher, Signal::INT).expect("our child");
    }
    let output = child.wait_with_output().expect("our child");
    let expected = if mode == "realtime" { 130 } else { 0 };
    assert_eq!(output.status.code(), Some(expected), "{}", text(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let recording = &summary["recording"];
    let is_killed = recording["failed"].as_str().is_some_and(|why| why.contains("SIGKILL"));
    assert!(is_killed, "{recording}");
    assert_eq!(recording["lost"], Value::Null, "no process was left to count");
    readable_and_recoverable(&corner);
    corner.expect_nothing_left(&roots);
}

#[test]
fn a_recording_outlives_its_run() {
    let corner = Corner::new(PROGRAM);
    let child = started(&corner, "realtime");
    let roots = corner.roots();
    let output = corner.run(&["recording", "recover", "out"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("still being recorded"), "{}", text(&output));
    let processes = corner.processes();
    kill(i32::try_from(child.id()).expect("fits"));
    for (pid, name) in processes {
        if name != "timegap-janitor" {
            // Some ended with the launcher.
            let _ = kill_process(Pid::from_raw(pid).expect("a process id"), Signal::KILL);
        }
    }
    child.wait_with_output().expect("our child");
    readable_and_recoverable(&corner);
    corner.expect_nothing_left(&roots);
}

fn readable_and_recoverable(corner: &Corner) {
    let before = corner.json(&["recording", "info", "out"]);
    let messages = before["messages"].as_u64().expect("a count");
    assert!(messages > 100 && before["lost"] == 0, "{before}");
    assert_eq!(before["ended"], false);
    assert_eq!(before["damage"].as_array().map(Vec::len), Some(1), "{before}");
    let recovered = corner.json(&["recording", "recover", "out"]);
    assert_eq!(recovered["messages"], before["messages"]);
    let after = corner.json(&["recording", "info", "out"]);
    assert_eq!((&after["ended"], &after["damage"]), (&true.into(), &Value::Array(Vec::new())));
    assert_eq!(after["topics"], before["topics"]);
    let same = corner.json(&["recording", "diff", "out", "out/recording.mcap.broken"]);
    assert_eq!((&same["equal"], &same["messages"]), (&true.into(), &before["messages"]));
}

#[test]
fn results_may_have_any_name_and_are_recorded_and_replayed() {
    use std::os::unix::ffi::OsStrExt;
    let corner = Corner::new(PROGRAM);
    for name in [&b"-x"[..], b"a b\nc", b"\xff"] {
        let directory = std::ffi::OsStr::from_bytes(name);
        let mut out = std::ffi::OsString::from("--out=");
        out.push(directory);
        let run = ["run", "cacc-a", "--mode", "lockstep", "--duration", "1"];
        let ran = corner.command(&run).arg(out).output().expect("it starts");
        assert!(ran.status.success(), "{}", text(&ran));
        assert!(corner.path().join(directory).join("recording.mcap").exists(), "{}", text(&ran));
        for command in [
            &["recording", "replay"][..],
            &["recording", "info"],
            &["recording", "trace"],
            &["recording", "export", "--csv"],
            &["recording", "recover"],
        ] {
            let mut asked = corner.command(&[command, &["--json", "--"]].concat());
            let asked = asked.arg(directory).output().expect("it starts");
            assert!(asked.status.success(), "{command:?}: {}", text(&asked));
        }
    }
}

#[test]
fn a_full_disk_ends_the_recording_and_not_the_run() {
    let corner = Corner::new(PROGRAM);
    std::fs::create_dir(corner.path().join("out")).expect("writable");
    std::os::unix::fs::symlink("/dev/full", corner.path().join("out/recording.mcap"))
        .expect("writable");
    for mode in ["lockstep", "realtime"] {
        let arguments =
            ["run", "cacc-a", "--mode", mode, "--duration", "2", "--out", "out", "--force"];
        let summary = corner.json(&arguments);
        let recording = &summary["recording"];
        let why = recording["failed"].as_str().expect("a reason");
        assert!(why.contains("No space left"), "{why}");
        assert_eq!(recording["messages"], 0);
        assert_eq!(recording["lost"].as_u64(), Some(sent(&summary)));
    }
}

#[test]
fn a_full_disk_is_named_by_recover_and_leaves_no_part_of_a_file() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "cacc-a", "--mode", "lockstep", "--duration", "2", "--out", "out"];
    assert!(corner.run(&run).status.success());
    let part = corner.path().join("out/whole.mcap.part");
    std::os::unix::fs::symlink("/dev/full", &part).expect("writable");
    let output = corner.run(&["recording", "recover", "out", "--file", "out/whole.mcap"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(text(&output).contains("No space left on device"), "{}", text(&output));
    assert!(part.symlink_metadata().is_err(), "it is removed");
}

#[test]
fn a_damaged_recording_is_used_as_far_as_it_goes_and_said() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "cut-in", "--mode", "lockstep", "--duration", "4", "--out", "out"];
    assert_eq!(corner.json(&run)["recording"]["failed"], Value::Null);
    let file = corner.path().join("out/recording.mcap");
    let whole = std::fs::read(&file).expect("just recorded");
    let cut = &whole[..whole.len() * 2 / 3];
    std::fs::write(&file, cut).expect("ours");
    for command in [
        &["recording", "export", "out", "--csv"][..],
        &["recording", "replay", "out"],
        &["recording", "trace", "out"],
    ] {
        let output = corner.run(command);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {}", text(&output));
        assert!(text(&output).contains("never ended"), "{}", text(&output));
    }
    assert_eq!(corner.json(&["recording", "info", "out"])["ended"], false);
    // Without a message, no file is overwritten.
    let first = &whole[..9000.min(whole.len())];
    std::fs::write(&file, first).expect("ours");
    let output = corner.run(&["recording", "recover", "out"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert_eq!(std::fs::read(&file).expect("still there"), first);
    let left = std::fs::read_dir(corner.path().join("out")).expect("a directory").flatten();
    let names: Vec<_> = left.map(|entry| entry.file_name()).collect();
    assert!(names.iter().all(|name| !name.to_string_lossy().ends_with(".part")), "{names:?}");
}

/// Announced lengths without data are refused, in an address space without room for them.
#[test]
fn lengths_of_gigabytes_need_no_memory() {
    let corner = Corner::new(PROGRAM);
    let magic = b"\x89MCAP0\r\n";
    let text_of_4_gib = [&4_u32.to_le_bytes()[..], b"name", &u32::MAX.to_le_bytes()].concat();
    let record = |length: u64, body: &[u8]| [b"\x0C", &length.to_le_bytes()[..], body].concat();
    let files = [
        record(1 << 32, b"few"),
        record(u64::MAX, b"few"),
        record(text_of_4_gib.len() as u64, &text_of_4_gib),
    ];
    for body in files {
        let file = [&magic[..], &body].concat();
        std::fs::write(corner.path().join("huge.mcap"), file).expect("writable");
        for command in ["info", "recover", "replay", "trace", "export --csv"] {
            let line = format!("ulimit -v 524288; exec {PROGRAM} {command} huge.mcap");
            let output = std::process::Command::new("sh")
                .args(["-c", &line])
                .current_dir(corner.path())
                .output()
                .expect("a shell");
            assert_eq!(output.status.code(), Some(2), "{command}: {}", text(&output));
            assert!(text(&output).contains("which run"), "{command}: {}", text(&output));
        }
    }
}

#[test]
fn a_file_that_is_not_a_recording_is_refused_with_status_2() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("text.mcap"), "no recording").expect("writable");
    for command in [
        ["recording", "info", "text.mcap"],
        ["recording", "recover", "text.mcap"],
        ["recording", "info", "nowhere"],
    ] {
        let output = corner.run(&command);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(command[2]), "{}", text(&output));
    }
}
