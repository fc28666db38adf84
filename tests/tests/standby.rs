//! Services with a standby: killed, stopped and continued, at any time.

use messages::Command;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use runtime::{Group, Guest};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::time::{Duration, Instant};
use system_tests::{Corner, PATIENCE, csv, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn run(corner: &Corner, more: &[&str]) -> Value {
    let arguments = ["run", "following", "--no-record"];
    corner.json(&[&arguments, more].concat())
}

fn service<'a>(summary: &'a Value, name: &str) -> &'a Value {
    let mut services = summary["services"].as_array().expect("a list").iter();
    services.find(|service| service["name"] == name).expect("it takes part")
}

#[test]
fn every_service_that_is_killed_is_taken_over_by_its_standby() {
    let corner = Corner::new(PROGRAM);
    let standby = "supervision.standby=[\"controller\", \"perception-sim\", \"v2x-sim\", \"aebs\"]";
    let kills =
        ["controller", "perception-sim", "v2x-sim", "aebs"].iter().zip(1..).map(|(who, k)| {
            format!("{{ kind = \"kill\", service = \"{who}\", at_s = {} }}", 0.7 * f64::from(k))
        });
    let faults = format!("faults=[{}]", kills.collect::<Vec<_>>().join(", "));
    let more = ["--duration", "4", "--set", standby, "--set", &faults, "--out", "out"];
    let summary = run(&corner, &more);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let faults = summary["faults"].as_array().expect("a list");
    assert_eq!(faults.len(), 4, "{faults:?}");
    for fault in faults {
        assert_eq!(fault["recovered_by"], "take-over", "{fault}");
        assert!(fault["recovered_after_us"].as_f64() > fault["detected_after_us"].as_f64());
    }
    for name in ["controller", "perception-sim", "v2x-sim", "aebs"] {
        let service = service(&summary, name);
        assert_eq!((&service["restarts"], &service["take_overs"]), (&1.into(), &1.into()));
        assert!(service["standby_cost"]["private_kib"].as_u64() > Some(0), "{service}");
    }
    assert!(service(&summary, "plant")["take_overs"].is_null());
    // Silent computations of the standby do not count for the service.
    let cycles = summary["timing"]["cycles"].as_u64().expect("counted");
    assert!((25..=45).contains(&cycles), "of 41: {cycles}");
    let trajectory = corner.path().join("out/trajectory.csv");
    let trajectory = std::fs::read_to_string(trajectory).expect("kept");
    let gaps: Vec<f64> = (csv(&trajectory, &["gap_m"]).iter().map(|row| row[0]))
        .filter(|gap_m| gap_m.is_finite())
        .collect();
    let jump_m = gaps.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(gaps.len() > 60 && jump_m < 0.6, "the vehicle ahead jumped by {jump_m} m");
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_stopped_process_is_replaced_before_its_heartbeats_are_missed_and_does_not_come_back() {
    let corner = Corner::new(PROGRAM);
    let stop = "faults=[{ kind = \"stop\", service = \"controller\", at_s = 1, for_s = 20 }]";
    let standby = "supervision.standby=[\"controller\"]";
    // Heartbeats alone would not end this stop within the run.
    let patient = "supervision.heartbeat_timeout_ms=9000";
    let more = ["--duration", "4", "--set", standby, "--set", stop, "--set", patient];
    let summary = run(&corner, &more);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    assert_eq!(summary["faults"][0]["recovered_by"], "take-over", "{}", summary["faults"]);
    assert_eq!(service(&summary, "controller")["take_overs"], 1);
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_standby_without_meaning_is_refused() {
    let corner = Corner::new(PROGRAM);
    let standby = "supervision.standby=[\"controller\"]";
    for (more, what) in [
        (["--mode", "lockstep", "--set", standby].as_slice(), "needs --mode realtime"),
        (&["--set", "supervision.standby=[\"plant\"]"], "expected"),
        (&["--set", standby, "--set", "supervision.restart=\"never\""], "whose end is to end"),
        (&["--set", standby, "--service", "controller=/bin/true"], "standby"),
        (&["--set", "supervision.standby=[\"aebs\"]", "--set", "aebs.enabled=false"], "aebs"),
    ] {
        let output = corner.run(&[&["run", "following", "--no-record"], more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", text(&output));
        assert!(text(&output).contains(what), "{what}: {}", text(&output));
    }
}

#[test]
fn killed_stopped_and_continued_at_random_there_is_one_accepted_sender() {
    interleave(40, 1);
}

/// All rounds: `cargo test --release -p system-tests --test standby -- --ignored`.
#[test]
#[ignore = "some 20 minutes"]
fn the_same_ten_thousand_times() {
    interleave(10_000, 2);
}

/// Actions on the processes of one service in a round, in order.
#[derive(Clone, Copy, Debug)]
enum Act {
    Kill,
    Stop,
    Continue,
}

/// Performs random actions on the controller and its standby, round by round, and listens to the commands.
fn interleave(rounds: u32, seed: u64) {
    let corner = Corner::new(PROGRAM);
    let mut run = corner.start(&[
        "run",
        "following",
        "--no-record",
        "--duration",
        "80000",
        "--out",
        "out",
        "--set",
        "supervision.standby=[\"controller\"]",
        "--set",
        "controller.period_ms=10",
        "--set",
        "supervision.budget=10000",
        "--set",
        "supervision.window_s=0.05",
        "--set",
        "supervision.standby_timeout_ms=20",
    ]);
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "the run drives");
    let live = std::fs::read_to_string(&live).expect("it is there");
    let group: Group = serde_json::from_str(&live).expect("a group");
    let mut listener = Listener::join(&group);
    let mut random = Pcg64::seed_from_u64(seed);
    for round in 0..rounds {
        let before = listener.newest;
        let begun = Instant::now();
        let mut acts = Vec::new();
        let mut stopped = Vec::new();
        for _ in 0..1 + random.next_u32() % 3 {
            let processes = controllers(&group);
            let Some(&pid) = processes.get(random.next_u32() as usize % processes.len().max(1))
            else {
                continue;
            };
            let act = [Act::Kill, Act::Stop, Act::Continue][random.next_u32() as usize % 3];
            match act {
                Act::Kill => signal(pid, Signal::KILL),
                Act::Stop => {
                    signal(pid, Signal::STOP);
                    stopped.push(pid);
                }
                Act::Continue => stopped.iter().for_each(|&pid| signal(pid, Signal::CONT)),
            }
            acts.push((act, pid));
            // From zero to two control periods and a take-over.
            let wait_us = [0, 200, 2_000, 15_000, 60_000][random.next_u32() as usize % 5];
            std::thread::sleep(Duration::from_micros(wait_us));
            listener.listen();
        }
        stopped.iter().for_each(|&pid| signal(pid, Signal::CONT));
        let heard = listener.heard;
        // Some process drives, beyond messages in flight.
        while listener.heard < heard + 3 {
            listener.listen();
            let ended = run.try_wait().expect("our own child");
            assert!(ended.is_none(), "round {round}: {acts:?}: the run ended");
            assert!(
                begun.elapsed() < PATIENCE,
                "round {round}: {acts:?}: no command after {before}, processes {:?}",
                controllers(&group)
            );
            std::thread::sleep(Duration::from_millis(1));
        }
        if round % 500 == 499 {
            let done = round + 1;
            println!(
                "{done} rounds, {} commands of {} processes",
                listener.heard,
                listener.newest + 1
            );
        }
    }
    println!("{rounds} rounds, {} commands of {} processes", listener.heard, listener.newest + 1);
    assert!(listener.newest > rounds / 4, "only {} processes", listener.newest);
    signal(i32::try_from(run.id()).expect("fits"), Signal::TERM);
    let output = run.wait_with_output().expect("our own child");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output));
    corner.expect_nothing_left(&[]);
}

fn signal(pid: i32, signal: Signal) {
    // It may have ended, and belonged to the run by its command line.
    let _ = kill_process(Pid::from_raw(pid).expect("a process id"), signal);
}

/// Living processes of the controller in this run, by their command lines, in the order of their restarts.
fn controllers(group: &Group) -> Vec<i32> {
    let root = group.root.as_os_str().as_encoded_bytes();
    let of = |entry: std::fs::DirEntry| {
        let pid = entry.file_name().to_str()?.parse::<i32>().ok()?;
        let line = std::fs::read(entry.path().join("cmdline")).ok()?;
        let mut words = line.split(|byte| *byte == 0);
        let is_one = words.next() == Some(b"timegap-controller") && words.any(|word| word == root);
        let incarnation = std::str::from_utf8(words.next()?).ok()?.parse::<u32>().ok()?;
        is_one.then_some((incarnation, pid))
    };
    let entries = std::fs::read_dir("/proc").expect("it is there on Linux").flatten();
    let mut found: Vec<_> = entries.filter_map(of).collect();
    found.sort_unstable();
    found.into_iter().map(|(_, pid)| pid).collect()
}

/// A consumer of commands like the plant: it reads what end-to-end check and epoch accept.
struct Listener {
    observer: Guest,
    commands: runtime::Subscriber<Command>,
    heard: u64,
    newest: u32,
}

impl Listener {
    fn join(group: &Group) -> Self {
        let observer = Guest::join(group, "listener").expect("same user");
        let commands = observer.subscriber().expect("there is room");
        Self { observer, commands, heard: 0, newest: 0 }
    }

    fn listen(&mut self) {
        let (heard, newest) = (&mut self.heard, &mut self.newest);
        let each = |command: &Command| {
            let sender = command.header.incarnation;
            assert!(sender >= *newest, "{sender} is accepted after {newest}");
            *newest = sender;
            *heard += 1;
        };
        self.commands.drain(each).expect("the topic is there");
        // The launcher removes ports of dead processes.
        let _ = &self.observer;
    }
}
