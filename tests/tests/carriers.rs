//! Frames from outside the run: a played capture, a roadside unit of another process, and unavailable
//! carriers.

use its::geonetworking::{Headers, Source, StationType};
use its::pcap::Writer;
use radio::{Carrier, Role};
use report::summary::Summary;
use runtime::Mode;
use scenario::radio::SIMULATED_START_NS;
use scenario::{Overrides, Scenario, builtin};
use serde_json::Value;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::time::Duration;
use supervise::in_process;
use system_tests::{Corner, text, wait_for};
use v2x_sim::frames::Frames;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const SECOND_NS: u64 = 1_000_000_000;

fn corridor() -> Scenario {
    let text = builtin::find("corridor").expect("it is built in").text;
    Scenario::parse("corridor", text).expect("it is right")
}

/// Frames of `corridor`'s units in `seconds`. Each second adds two frames: one of another profile (version 2 in its
/// first header) and one of another message (BTP port 2002).
fn capture(path: &Path, seconds: u64) {
    let units = Frames::new(&corridor());
    let mut writer = Writer::new(File::create(path).expect("our own directory")).expect("a file");
    for tenth in 0..10 * seconds {
        let time_ns = tenth * SECOND_NS / 10;
        let unix_ns = SIMULATED_START_NS + time_ns as i64;
        for frame in units.at(time_ns, SIMULATED_START_NS, None, None).expect("there is room") {
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
    overrides.option("--radio", "v2x.radio", format!("pcap:{}", path.display()));
    overrides.option("--duration", "duration_s", 15);
    let scenario = Scenario::open("corridor", &overrides, &controller::laws::check).expect("right");
    let group = in_process::run(&scenario).expect("it runs");
    let summary = Summary::new(&scenario, Mode::Lockstep, &group, Duration::ZERO);
    serde_json::to_value(summary).expect("plain data")
}

#[test]
fn a_capture_is_received_on_its_own_clock_and_repeats_byte_for_byte() {
    let corner = Corner::new(PROGRAM);
    let path = corner.path().join("corridor.pcap");
    capture(&path, 20);
    let summary = play(&path);
    let verdicts = &summary["radio"]["verdicts"];
    assert_eq!(summary["outcome"], "completed");
    // At 0 s, 1 s, ... 15 s, for a SPATEM and a MAPEM each.
    assert_eq!(verdicts["other_profile"], 32, "{verdicts}");
    assert_eq!(verdicts["unknown_message"], 32, "{verdicts}");
    assert!(verdicts["accepted"].as_u64() > Some(450), "{verdicts}");
    for verdict in ["too_old", "contradicting", "duplicated", "malformed"] {
        assert_eq!(verdicts[verdict], 0, "{verdicts}");
    }
    // The true signals of another maker's units are not known, and not invented.
    assert_eq!(summary["link"]["truth_known"], false);
    assert_eq!(play(&path)["messages"], summary["messages"]);
}

/// Messages of other programs: of North America's profile, of another kind, and CAMs with the vehicle's own
/// station id. Each has its own verdict, and the drive is unchanged.
#[test]
fn frames_of_others_are_counted_under_their_own_verdicts() {
    let corner = Corner::new(PROGRAM);
    let path = corner.path().join("foreign.pcap");
    let units = Frames::new(&corridor());
    let mut writer = Writer::new(File::create(&path).expect("our own directory")).expect("a file");
    let others = [
        (2004, "sae_spat"),
        (2003, "sae_map"),
        (2010, "sae_spat"),
        (2007, "srem"),
        (2004, "srem"),
        (2001, "cam_west"),
        (2001, "cam_east"),
    ];
    for tenth in 0..160_u64 {
        let time_ns = tenth * SECOND_NS / 10;
        let unix_ns = SIMULATED_START_NS + time_ns as i64;
        for frame in units.at(time_ns, SIMULATED_START_NS, None, None).expect("there is room") {
            writer.write(unix_ns, frame.station, &frame.bytes).expect("a file");
        }
        for (port, name) in others.into_iter().filter(|_| tenth % 10 == 5) {
            let frame = framed(port, tenth as u32, &foreign(name));
            writer.write(unix_ns, 1, &frame).expect("a file");
        }
    }
    writer.finish().expect("a file");
    // WAVE short messages have another EtherType.
    let message =
        [&[0xff; 6][..], &[2; 6], &[0x88, 0xdc, 3, 0, 0x80, 2, 24], &foreign("sae_spat")].concat();
    let mut file = File::options().append(true).open(&path).expect("our own file");
    let seconds = (SIMULATED_START_NS / SECOND_NS as i64 + 15) as u32;
    for word in [seconds, 0, message.len() as u32, message.len() as u32] {
        file.write_all(&word.to_le_bytes()).expect("a file");
    }
    file.write_all(&message).expect("a file");
    let summary = play(&path);
    let verdicts = &summary["radio"]["verdicts"];
    assert_eq!(summary["outcome"], "completed");
    assert_eq!(summary["link"]["malformed"], 1, "{}", summary["link"]);
    // One per second for 15 s.
    for (verdict, kinds) in [("other_profile", 2), ("unknown_message", 3), ("same_station_id", 2)] {
        assert_eq!(verdicts[verdict], 15 * kinds, "{verdict}: {verdicts}");
    }
    for verdict in ["contradicting", "duplicated", "malformed", "missing_lane"] {
        assert_eq!(verdicts[verdict], 0, "{verdicts}");
    }
}

/// A message of pycrate.
fn foreign(name: &str) -> Vec<u8> {
    let all = include_str!("../../shared/its/tests/foreign.txt");
    let mut lines = all.lines().filter_map(|line| line.split_once(' '));
    let (_, hex) = lines.find(|(found, _)| *found == name).expect("it is there");
    let byte = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal");
    (0..hex.len()).step_by(2).map(byte).collect()
}

fn framed(port: u16, timestamp: u32, payload: &[u8]) -> Vec<u8> {
    let source = Source {
        station_type: StationType::PassengerCar,
        address: 1,
        timestamp,
        position: its::geodesy::Position { latitude: 487_000_000, longitude: 91_000_000 },
        accurate: true,
        speed: 0,
        heading: 0,
    };
    let mut frame = Vec::new();
    Headers { source, traffic_class: 3, port }.write(payload.len() as u16, &mut frame);
    frame.extend(payload);
    frame
}

#[test]
fn two_vehicles_with_one_station_id_are_distinguished_and_named() {
    let corner = Corner::new(PROGRAM);
    let radio = format!("udp://239.255.31.{}:5524?interface=lo", std::process::id() % 200 + 20);
    let arguments = ["rsu", "corridor", "--radio", &radio, "--duration", "3", "--json"];
    let mut unit = corner.start(&arguments);
    let address = radio.parse().expect("an address");
    let mut vehicles = ["cam_west", "cam_east"].map(|name| {
        let carrier = Carrier::open(&address, Role::Vehicle).expect("a socket");
        (carrier, framed(2001, 0, &foreign(name)))
    });
    while unit.try_wait().expect("our child").is_none() {
        for (carrier, frame) in &mut vehicles {
            carrier.send(frame).expect("room");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let output = unit.wait_with_output().expect("it ended");
    let unit: Value = serde_json::from_slice(&output.stdout).expect("its summary");
    assert_eq!(unit["shared_station_ids"], serde_json::json!([4711]), "{unit}");
    let heard = unit["vehicles"].as_array().expect("a list");
    let ids: Vec<_> = heard.iter().map(|vehicle| vehicle["station_id"].as_u64()).collect();
    assert_eq!(ids, [Some(4711); 2], "{unit}");
    assert_ne!(heard[0]["position_m"], heard[1]["position_m"], "{unit}");
}

/// The command's own roadside unit and vehicle on one host; the vehicle starts first.
#[test]
fn a_vehicle_drives_by_the_signals_of_a_unit_that_runs_alone() {
    let corner = Corner::new(PROGRAM);
    let radio = format!("udp://239.255.31.{}:5523?interface=lo", std::process::id() % 200 + 20);
    let options = ["--duration", "6", "--out", "out", "--no-record", "--json"];
    let vehicle = corner.start(&[&["run", "corridor", "--radio", &radio], &options[..]].concat());
    let live = corner.path().join("out/live.json");
    assert!(wait_for(|| live.exists()), "the vehicle drives");
    let roots = corner.roots();
    let unit = corner.json(&["rsu", "corridor", "--radio", &radio, "--duration", "3"]);
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
