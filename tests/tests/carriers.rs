//! Frames that are not simulated in the run: a capture that is played into it, a roadside unit of another
//! process, and what cannot be had.

use group::in_process;
use its::pcap::Writer;
use report::summary::Summary;
use runtime::Mode;
use scenario::radio::SIMULATED_START_NS;
use scenario::{Overrides, Scenario, builtin};
use serde_json::Value;
use std::fs::File;
use std::path::Path;
use std::time::Duration;
use system_tests::{Corner, text, wait_for};
use v2x_sim::frames::Frames;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const SECOND_NS: u64 = 1_000_000_000;

fn corridor() -> Scenario {
    let text = builtin::find("corridor").expect("it is built in").text;
    Scenario::parse("corridor", text).expect("it is right")
}

/// What `corridor`'s units send in so many seconds; once in a second also a frame of another profile (the
/// version of its first header is 2) and one of a message that is not read here (its BTP port is 2002).
fn capture(path: &Path, seconds: u64) {
    let units = Frames::new(&corridor().v2x);
    let mut writer = Writer::new(File::create(path).expect("our own directory")).expect("a file");
    for tenth in 0..10 * seconds {
        let time_ns = tenth * SECOND_NS / 10;
        let unix_ns = SIMULATED_START_NS + time_ns as i64;
        for frame in units.at(time_ns, SIMULATED_START_NS, None).expect("there is room") {
            writer.write(unix_ns, frame.station, &frame.bytes).expect("a file");
            if tenth % 10 == 0 && frame.station == 100_001 {
                let (mut profile, mut port) = (frame.bytes.clone(), frame.bytes.clone());
                profile[0] = 0x21;
                port[40..42].copy_from_slice(&2002_u16.to_be_bytes());
                writer.write(unix_ns, frame.station, &profile).expect("a file");
                writer.write(unix_ns, frame.station, &port).expect("a file");
            }
        }
    }
    writer.finish().expect("a file");
}

fn play(path: &Path) -> Value {
    let mut overrides = Overrides::new();
    overrides.option("--radio", "v2x.radio", &format!("pcap:{}", path.display()));
    overrides.option("--duration", "duration_s", "15");
    let scenario = Scenario::open("corridor", &overrides, &controller::laws::check).expect("right");
    let group = in_process::run(&scenario).expect("it runs");
    let summary = Summary::new(&scenario, Mode::Lockstep, &group, Duration::ZERO);
    serde_json::to_value(summary).expect("plain data")
}

#[test]
fn a_capture_is_heard_on_its_own_clock_and_repeats_byte_for_byte() {
    let corner = Corner::new(PROGRAM);
    let path = corner.path().join("corridor.pcap");
    capture(&path, 20);
    let summary = play(&path);
    let verdicts = &summary["radio"]["verdicts"];
    assert_eq!(summary["outcome"], "completed");
    // At 0 s, 1 s, ... 15 s, of a SPATEM and a MAPEM each.
    assert_eq!(verdicts["other_profile"], 32, "{verdicts}");
    assert_eq!(verdicts["unknown_message"], 32, "{verdicts}");
    assert!(verdicts["accepted"].as_u64() > Some(450), "{verdicts}");
    for verdict in ["too_old", "contradicting", "duplicated", "malformed"] {
        assert_eq!(verdicts[verdict], 0, "{verdicts}");
    }
    // What another maker's signals really showed is not known, and nothing is made up.
    assert_eq!(summary["link"]["truth_known"], false);
    assert_eq!(play(&path)["messages"], summary["messages"]);
}

/// The command's own roadside unit and its own vehicle on one host; the vehicle begins first.
#[test]
fn a_vehicle_drives_by_the_signals_of_a_unit_that_runs_alone() {
    let corner = Corner::new(PROGRAM);
    let radio = format!("udp://239.255.31.{}:5523?interface=lo", std::process::id() % 200 + 20);
    let options = ["--duration", "12", "--out", "out", "--no-record", "--json"];
    let vehicle = corner.start(&[&["run", "corridor", "--radio", &radio], &options[..]].concat());
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "the vehicle drives");
    let roots = corner.roots();
    let unit = corner.json(&["rsu", "corridor", "--radio", &radio, "--duration", "8"]);
    let output = vehicle.wait_with_output().expect("it ends");
    let vehicle: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("no JSON: {}", text(&output)));
    let link = &vehicle["link"];
    assert_eq!(vehicle["outcome"], "completed", "{}", text(&output));
    assert_eq!(link["truth_known"], true, "{link}");
    let sent = unit["spatem"].as_u64().zip(unit["mapem"].as_u64()).map(|(s, m)| s + m);
    let station = &link["stations"][0];
    let heard = station["received"].as_u64().zip(station["lost"].as_u64()).map(|(r, l)| r + l);
    assert_eq!(heard, sent, "{unit} {link}");
    assert!(station["clock_offset_us"].is_number(), "{link}");
    assert_eq!(unit["vehicles"][0]["station_id"], 4711, "{unit}");
    corner.expect_nothing_left(&roots);
}
