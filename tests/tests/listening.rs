//! Listening is harmless: a foreign program that joins a run on every topic and never reads delays nothing.
//! `live.json` has all that such a program needs.

use iceoryx2::prelude::*;
use messages::{Command, Message, Odometry, RadarTracks, Spat, Topic};
use runtime::Group;
use serde_json::Value;
use std::fmt::Debug;
use std::process::Output;
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
/// Long enough for the attack to begin during the drive.
const SIMULATED_S: &str = "300";

/// A subscriber outside the group: this test's process is not a member.
type Deaf<T> = iceoryx2::port::subscriber::Subscriber<ipc::Service, T, ()>;

fn node(group: &Group) -> Node<ipc::Service> {
    let mut config = iceoryx2::config::Config::default();
    config.global.prefix = FileName::new(group.prefix.as_bytes()).expect("short");
    let root = group.root.to_str().expect("text");
    config.global.set_root_path(&iceoryx2::prelude::Path::new(root.as_bytes()).expect("short"));
    NodeBuilder::new()
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .config(&config)
        .create()
        .expect("same user")
}

fn attach<T: Message + Debug>(node: &Node<ipc::Service>) -> Deaf<T> {
    let name: ServiceName = T::TOPIC.name().try_into().expect("a name");
    let topic = node.service_builder(&name).publish_subscribe::<T>().open().expect("it is there");
    topic.subscriber_builder().create().expect("there is room for observers")
}

/// Starts a run and returns `live.json` as soon as the vehicle drives.
fn started(corner: &Corner, arguments: &[&str]) -> (std::process::Child, Value) {
    let child = corner.start(arguments);
    let live = corner.path().join("out/live.json");
    let mut said = None;
    assert!(
        wait_for(|| {
            said = std::fs::read_to_string(&live).ok();
            said.is_some()
        }),
        "never drove"
    );
    (child, serde_json::from_str(&said.expect("read")).expect("JSON"))
}

/// Attaches to every topic of the controller, never reads, and waits for the end. Returns the number of
/// odometry messages in its queue too.
fn attacked(corner: &Corner, arguments: &[&str]) -> (Output, usize) {
    let (child, live) = started(corner, arguments);
    let group: Group = serde_json::from_value(live).expect("live.json is a group file and more");
    let node = node(&group);
    let odometry = attach::<Odometry>(&node);
    let others = (attach::<RadarTracks>(&node), attach::<Spat>(&node), attach::<Command>(&node));
    let output = child.wait_with_output().expect("our child");
    let mut waiting = 0;
    while let Ok(Some(_)) = odometry.receive() {
        waiting += 1;
    }
    drop(others);
    (output, waiting)
}

fn summary(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(output));
    serde_json::from_slice(&output.stdout).expect("a summary")
}

#[test]
fn a_listener_that_never_reads_does_not_stop_a_lockstep_run() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "following", "--mode", "lockstep", "--duration", SIMULATED_S, "--json"];
    let alone = corner.json(&["run", "following", "--mode", "lockstep", "--duration", SIMULATED_S]);
    let (output, waiting) = attacked(&corner, &[&run[..], &["--out", "out"]].concat());
    let attacked = summary(&output);
    assert!(waiting > 10, "it was connected and its buffer filled: {waiting}");
    assert_eq!(attacked["outcome"], "completed", "{attacked}");
    for topic in [Topic::Odometry, Topic::RadarTracks, Topic::Command] {
        let digests = |summary: &Value| summary["messages"][topic.name()]["digests"].clone();
        assert_eq!(digests(&attacked), digests(&alone), "{}: the same bytes", topic.name());
    }
    assert_eq!(attacked["recording"]["lost"], 0, "the group's own listeners are waited for");
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_listener_that_never_reads_does_not_stop_a_realtime_run() {
    let corner = Corner::new(PROGRAM);
    let (output, waiting) =
        attacked(&corner, &["run", "following", "--duration", "3", "--json", "--out", "out"]);
    assert!(waiting > 10, "it was connected and its buffer filled: {waiting}");
    assert_eq!(summary(&output)["outcome"], "completed", "{}", text(&output));
    corner.expect_nothing_left(&[]);
}

#[test]
fn the_live_file_has_its_start_and_the_meaning_of_the_messages() {
    let corner = Corner::new(PROGRAM);
    let before_ns = runtime::monotonic_ns();
    let arguments = ["run", "following", "--duration", "2", "--out", "out", "--json"];
    let (child, live) = started(&corner, &[&arguments[..], &["--controller", "six-mode"]].concat());
    let start_ns = live["start_monotonic_ns"].as_i64().expect("an instant");
    assert!(start_ns > before_ns, "{start_ns}");
    let since_1970 = std::time::SystemTime::UNIX_EPOCH.elapsed().expect("after 1970").as_nanos();
    let started_unix_ns = live["started_unix_ns"].as_i64().expect("an epoch");
    let ahead_ns = i128::from(started_unix_ns) - since_1970 as i128;
    assert!(ahead_ns < 60_000_000_000 && ahead_ns > -60_000_000_000, "{started_unix_ns}");
    assert_eq!(live["topics"]["vehicle/odometry"]["struct"], "Odometry");
    let fields = live["types"]["Odometry"]["fields"].as_array().expect("fields");
    let speed = fields.iter().find(|field| field["name"] == "speed_mps").expect("a field");
    assert!(speed["meaning"].as_str().is_some_and(|text| text.contains("m/s")), "{speed}");
    assert_eq!(live["names"]["rung"]["0"], "full");
    assert!(live["names"]["mode"].as_array().is_some_and(|modes| modes.len() == 6), "{live}");
    let output = child.wait_with_output().expect("our child");
    assert!(output.status.success(), "{}", text(&output));
    assert!(!corner.path().join("out/live.json").exists(), "it is there while it drives");
}
