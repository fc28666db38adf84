//! The bridge to Foxglove beside a run: what a viewer sees, and what becomes of a run whose bridge or viewer misbehaves.

use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use system_tests::cases::{self, Needed, needing};
use system_tests::{Corner, python, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const VIEWER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/python/viewer.py");

fn pypi() -> Needed {
    python::BRIDGE.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR"))).map(|_| ())
}

fn always() -> Needed {
    Ok(())
}

/// Waits for the line with the bridge's port on a command's standard error.
fn port(child: &mut Child) -> u16 {
    let mut lines = BufReader::new(child.stderr.as_mut().expect("piped")).lines();
    let line = lines.find_map(|line| Some(line.ok()?.split_once("ws://127.0.0.1:")?.1.to_owned()));
    line.and_then(|port| port.parse().ok()).expect("a line with the address")
}

/// Starts a viewer, which ends with the bridge.
fn view(port: u16, fault: &[&str]) -> Child {
    let python =
        python::BRIDGE.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR"))).expect("looked for");
    let mut command = Command::new(python);
    command.arg(VIEWER).arg(port.to_string()).args(fault);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
}

fn seen(viewer: Child) -> Value {
    let output = viewer.wait_with_output().expect("our child");
    assert!(output.status.success(), "{}", text(&output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// A run's summary, and what it wrote beside.
fn summary(mut child: Child) -> (Value, String) {
    let (mut out, mut err) = (String::new(), String::new());
    child.stdout.take().expect("piped").read_to_string(&mut out).expect("text");
    child.stderr.take().expect("piped").read_to_string(&mut err).expect("text");
    assert!(child.wait().expect("our child").success(), "{out}\n{err}");
    (serde_json::from_str(&out).expect("a summary"), err)
}

fn start(corner: &Corner, seconds: &str) -> Child {
    let run = ["run", "following", "--duration", seconds, "--out", "out", "--json"];
    corner.start(&[&run[..], &["--bridge", "foxglove:0"]].concat())
}

fn a_viewer_sees_the_drive_and_injects_a_fault() {
    let corner = Corner::new(PROGRAM);
    let mut run = start(&corner, "5");
    let fault = r#"{"kind":"drop","topic":"radar/tracks","for_s":0.5,"at_s":1}"#;
    let seen = seen(view(port(&mut run), &[fault]));
    let (summary, said) = summary(run);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    assert_eq!(seen["subprotocol"], "foxglove.sdk.v1");
    assert_eq!(seen["end"], "the run has ended", "{seen}");
    assert_eq!(seen["answer"]["ok"], true, "{seen}");
    assert_eq!(summary["faults"][0]["topic"], "radar/tracks", "{summary}");
    assert_eq!(seen["parameters"]["controller.name"], "acc-mpc");
    assert!(seen["speed_mps"].as_f64().is_some_and(|speed| speed > 5.0), "{seen}");
    for topic in
        ["vehicle/odometry", "radar/tracks", "control/diagnostics", "/tf", "/scene/markers"]
    {
        assert!(seen["messages"][topic].as_u64() > Some(5), "{topic}: {seen}");
    }
    assert!(!said.contains("warn"), "{said}");
    corner.expect_nothing_left(&[]);
}

fn a_run_in_progress_and_its_recording_are_shown() {
    let corner = Corner::new(PROGRAM);
    let run = corner.start(&["run", "following", "--duration", "6", "--out", "out", "--json"]);
    assert!(wait_for(|| corner.path().join("out/live.json").exists()), "it never drove");
    let mut guest = corner.start(&["bridge", "foxglove:0", "--run", "out"]);
    let joined = seen(view(port(&mut guest), &[]));
    assert!(guest.wait().expect("our child").success());
    assert_eq!(joined["end"], "the run has ended", "{joined}");
    assert!(joined["messages"]["vehicle/odometry"].as_u64() > Some(5), "{joined}");
    assert_eq!(summary(run).0["outcome"], "completed");
    let mut player = corner.start(&["bridge", "foxglove:0", "--run", "out", "--speed", "8"]);
    let played = seen(view(port(&mut player), &["{\"kind\":\"drop\"}"]));
    assert!(player.wait().expect("our child").success());
    assert_eq!(played["end"], "the recording has ended", "{played}");
    assert_eq!(played["answer"], Value::Null, "a recording takes no faults");
    let recorded = corner.json(&["recording", "info", "out"]);
    for topic in ["vehicle/odometry", "radar/tracks", "control/command"] {
        let messages = &recorded["topics"][topic]["messages"];
        assert_eq!(&played["messages"][topic], messages, "{topic}: {recorded}");
    }
    corner.expect_nothing_left(&[]);
}

fn a_killed_or_stopped_bridge_and_wild_viewers_leave_the_run_alone() {
    for kind in ["killed", "stopped", "wild"] {
        let corner = Corner::new(PROGRAM);
        let mut run = start(&corner, "4");
        let port = port(&mut run);
        let pid = corner.wait_for_process("timegap-bridge").to_string();
        assert!(wait_for(|| corner.path().join("out/live.json").exists()), "it never drove");
        let mut streams = Vec::new();
        match kind {
            "wild" => {
                for k in 0..40 {
                    let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port));
                    let mut stream = stream.expect("it listens");
                    // Refused ones are closed.
                    let _ = stream.write_all(&vec![k; 10_000]);
                    streams.push(stream);
                }
            }
            "killed" => kill("-KILL", &pid),
            _ => kill("-STOP", &pid),
        }
        let (summary, said) = summary(run);
        assert_eq!(summary["outcome"], "completed", "{kind}: {summary}");
        assert_eq!(summary["recording"]["lost"], 0, "{kind}: {summary}");
        let lines = said.lines().filter(|line| line.contains("WARN")).count();
        let gone = said.matches("the bridge is gone, the run continues without it").count();
        assert!(lines <= 11, "{kind}: {said}");
        assert_eq!(gone, usize::from(kind == "killed"), "{kind}: {said}");
        corner.expect_nothing_left(&[]);
    }
}

fn kill(signal: &str, pid: &str) {
    assert!(Command::new("kill").args([signal, pid]).status().expect("it starts").success());
}

fn a_taken_port_and_wrong_words_end_before_the_drive() {
    let corner = Corner::new(PROGRAM);
    let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a free port");
    let address = format!("foxglove:{}", taken.local_addr().expect("it is bound").port());
    for (arguments, status, what) in [
        (&["run", "following", "--bridge", &address][..], 3, "in use"),
        (&["run", "following", "--bridge", "rviz"], 2, "expected foxglove[:PORT]"),
        (&["run", "following", "--bridge", "foxglove:x"], 2, "expected a number from 0 to 65535"),
        (&["bridge", "foxglove", "--run", "nowhere"], 2, "nowhere"),
        (&["bridge", "foxglove"], 2, "there is no run in ./runs"),
        (&["bridge", "foxglove", "--speed", "0"], 2, "--speed 0: out of range"),
    ] {
        let output = corner.run(arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", text(&output));
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(what) && said.lines().count() == 1, "{arguments:?}: {said}");
        corner.expect_nothing_left(&[]);
    }
    assert!(!corner.path().join("runs").exists(), "nothing was kept");
}

fn main() -> ExitCode {
    cases::run(&[
        needing(pypi, "a_viewer_sees_the_drive", a_viewer_sees_the_drive_and_injects_a_fault),
        needing(
            pypi,
            "a_run_in_progress_and_its_recording_are_shown",
            a_run_in_progress_and_its_recording_are_shown,
        ),
        needing(
            always,
            "wild_viewers_leave_the_run_alone",
            a_killed_or_stopped_bridge_and_wild_viewers_leave_the_run_alone,
        ),
        needing(
            always,
            "a_taken_port_ends_before_the_drive",
            a_taken_port_and_wrong_words_end_before_the_drive,
        ),
    ])
}
