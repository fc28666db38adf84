//! Comparison with Wireshark's dissectors and PyPI's `pycrate`, in both directions.
//!
//! A test without its program is ignored, with the reason in its line.

use its::cam::{Cam, LowFrequency, Motion};
use its::geodesy::Position;
use its::geonetworking::{HEADER_BYTES, Source, StationType};
use its::mapem::{Approach, Connection, IntersectionGeometry, LEFT, Lane, Mapem, STRAIGHT};
use its::spatem::{IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing};
use its::time::{Stamp, TimeMark};
use its::{Frame, Message, pcap};
use libtest_mimic::{Arguments, Trial};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const PYCRATE: &str = "pycrate==0.8.1";

/// Reads lines `KIND HEX`, decodes each and prints the re-encoded value; then prints messages of its own.
const SCRIPT: &str = r#"
import sys
from pycrate_asn1dir import ITS_IS, ITS_CAM_2
types = {
    "spatem": ITS_IS.GLOBAL.MOD["SPATEM-PDU-Descriptions"]["SPATEM"],
    "mapem": ITS_IS.GLOBAL.MOD["MAPEM-PDU-Descriptions"]["MAPEM"],
    "cam": ITS_CAM_2.GLOBAL.MOD["CAM-PDU-Descriptions"]["CAM"],
}
for line in sys.stdin:
    kind, encoded = line.split()
    types[kind].from_uper(bytes.fromhex(encoded))
    value = types[kind].get_val()
    types[kind].set_val(value)
    print(kind, types[kind].to_uper().hex())
spatem = types["spatem"]
spatem.set_val({"header": {"protocolVersion": 2, "messageID": 4, "stationID": 77}, "spat": {
    "timeStamp": 1234, "name": "theirs", "intersections": [{
        "name": "crossing", "id": {"region": 49, "id": 501}, "revision": 3, "status": (1 << 15, 16),
        "timeStamp": 59999, "enabledLanes": [1, 2], "states": [{
            "movementName": "straight", "signalGroup": 9, "state-time-speed": [{
                "eventState": "permissive-Movement-Allowed",
                "timing": {"minEndTime": 35999, "maxEndTime": 36000, "likelyTime": 36001, "confidence": 7},
                "speeds": [{"type": "greenwave", "speed": 139}]}]}]}]}})
print("spatem", spatem.to_uper().hex())
mapem = types["mapem"]
vehicle = {"directionalUse": (2, 2), "sharedWith": (0, 10), "laneType": ("vehicle", (0, 8))}
walk = {"directionalUse": (2, 2), "sharedWith": (0, 10), "laneType": ("crosswalk", (0, 16))}
nodes = ("nodes", [{"delta": ("node-XY1", {"x": -5, "y": 6}), "attributes": {"dWidth": 10}},
                   {"delta": ("node-XY6", {"x": -30000, "y": 0})}])
computed = ("computed", {"referenceLaneId": 1, "offsetXaxis": ("small", 5), "offsetYaxis": ("small", 6)})
mapem.set_val({"header": {"protocolVersion": 2, "messageID": 5, "stationID": 78}, "map": {
    "timeStamp": 99, "msgIssueRevision": 1, "intersections": [{
        "id": {"id": 502}, "revision": 4, "refPoint": {"lat": 487000000, "long": -91000000, "elevation": 5},
        "laneSet": [
            {"laneID": 1, "name": "a", "ingressApproach": 2, "laneAttributes": vehicle, "nodeList": nodes,
             "connectsTo": [{"connectingLane": {"lane": 8}, "signalGroup": 9, "connectionID": 1}]},
            {"laneID": 2, "ingressApproach": 2, "laneAttributes": vehicle, "nodeList": computed},
            {"laneID": 3, "ingressApproach": 2, "laneAttributes": walk, "nodeList": nodes}]}]}})
print("mapem", mapem.to_uper().hex())
"#;

fn mark(value: u16) -> TimeMark {
    TimeMark::new(value).expect("in range")
}

fn source() -> Source {
    Source {
        station_type: StationType::RoadsideUnit,
        address: 0x0200_0000_0501,
        timestamp: 694_310_405,
        position: Position { latitude: 487_000_123, longitude: 91_000_456 },
        accurate: true,
        speed: -12,
        heading: 2700,
    }
}

/// All ten states, at the bounds of time marks.
fn spatem() -> Spatem {
    let events = MovementPhase::ALL.into_iter().zip(0_u16..).map(|(state, n)| MovementEvent {
        state,
        timing: (n != 0).then(|| Timing {
            start: (n % 2 == 0).then(|| mark(n)),
            min_end: mark(4000 * n - 1),
            max_end: Some(TimeMark::BEYOND),
            likely_end: Some(TimeMark::UNKNOWN),
            confidence: Some(n as u8 + 6),
            next: (n % 3 == 0).then(|| mark(17)),
        }),
    });
    let movements = [(1, events.collect()), (254, Vec::new())].map(|(signal_group, mut events)| {
        if events.is_empty() {
            events.push(MovementEvent { state: MovementPhase::Dark, timing: None });
        }
        MovementState { signal_group, events }
    });
    let stamp = Some(Stamp { minute_of_year: 218_159, millisecond: 59_999 });
    let intersection = |id, revision, status| IntersectionState {
        region: (id == 501).then_some(49),
        id,
        revision,
        status,
        stamp,
        movements: movements.to_vec(),
    };
    let intersections = vec![intersection(501, 127, 1 << 5), intersection(65_535, 0, 0)];
    Spatem { station_id: 4_294_967_295, intersections }
}

fn mapem() -> Mapem {
    let ingress = Lane {
        id: 1,
        approach: Approach::Ingress(3),
        maneuvers: STRAIGHT | LEFT,
        nodes: vec![
            (-511, 0),
            (1023, -1023),
            (-2047, 2047),
            (4095, 5),
            (8191, -8191),
            (-32_768, 32_767),
        ],
        connections: vec![
            Connection { lane: 2, maneuver: Some(STRAIGHT), signal_group: Some(254) },
            Connection { lane: 2, maneuver: None, signal_group: None },
        ],
    };
    let egress = Lane {
        id: 2,
        approach: Approach::Egress(15),
        maneuvers: 0,
        nodes: vec![(0, 0), (500, 0)],
        connections: Vec::new(),
    };
    let geometry = IntersectionGeometry {
        region: Some(49),
        id: 501,
        revision: 127,
        reference: Position { latitude: -337_000_000, longitude: 1_799_999_999 },
        lane_width_cm: Some(325),
        lanes: vec![ingress, egress],
        unread_lanes: 0,
    };
    Mapem { station_id: 501, revision: 9, intersections: vec![geometry] }
}

fn cam() -> Cam {
    Cam {
        station_id: 42,
        generation_delta: 65_535,
        station_type: 5,
        position: Position { latitude: 487_000_000, longitude: -91_000_000 },
        motion: Motion {
            heading: 3599,
            speed: 1389,
            acceleration: -35,
            yaw_rate: -12,
            length: 45,
            width: 19,
        },
        low_frequency: Some(LowFrequency { role: 9, lights: 0b100_0001 }),
    }
}

fn frames() -> [Frame; 3] {
    let messages = [Message::Spatem(spatem()), Message::Mapem(mapem()), Message::Cam(cam())];
    messages.map(|message| Frame { source: source(), message })
}

fn run(command: &mut Command) -> String {
    let output = command.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
    String::from_utf8(output.stdout).expect("text")
}

/// The values of fields in all frames that tshark finds, in order. One call reads all: each takes a third of a second.
fn fields<'a>(capture: &Path, names: &[&'a str]) -> BTreeMap<&'a str, Vec<String>> {
    let mut command = Command::new("tshark");
    command.arg("-r").arg(capture).args(["-T", "fields", "-E", "aggregator=,"]);
    command.args(["-E", "occurrence=a"]).args(names.iter().flat_map(|name| ["-e", *name]));
    let text = run(&mut command);
    let of = |column: usize| {
        let cells = text.lines().filter_map(move |line| line.split('\t').nth(column));
        let values = cells.flat_map(|cell| cell.split(',')).filter(|value| !value.is_empty());
        values.map(str::to_owned).collect()
    };
    names.iter().enumerate().map(|(column, name)| (*name, of(column))).collect()
}

fn tshark_reads_every_field() {
    let capture = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("oracle.pcap");
    let mut writer = pcap::Writer::new(std::fs::File::create(&capture).expect("it can be written"))
        .expect("it can be written");
    for (frame, k) in frames().into_iter().zip(0..) {
        let bytes = frame.encode().expect("in range");
        writer.write(1_780_315_170_123_456_000 + k, 501, &bytes).expect("it can be written");
    }
    writer.finish().expect("it can be written");

    let tshark =
        |arguments: &[&str]| run(Command::new("tshark").arg("-r").arg(&capture).args(arguments));
    assert_eq!(tshark(&["-Y", "_ws.malformed || _ws.expert.severity >= 0x600000"]), "");
    assert_eq!(tshark(&["-Y", "its", "-T", "fields", "-e", "frame.number"]).lines().count(), 3);
    let all = tshark(&["-V"]);
    assert!(!all.contains("alformed"), "{all}");

    let twice = |values: &[i64]| [values, values].concat();
    let expected: Vec<(&str, Vec<i64>)> = vec![
        ("btpb.dstport", vec![2004, 2003, 2001]),
        ("geonw.src_pos.lat", vec![487_000_123; 3]),
        ("geonw.src_pos.long", vec![91_000_456; 3]),
        ("geonw.src_pos.tst", vec![694_310_405; 3]),
        ("geonw.src_pos.speed", vec![-12; 3]),
        ("geonw.src_pos.hdg", vec![2700; 3]),
        ("geonw.ch.mhl", vec![1; 3]),
        ("geonw.ch.tc.id", vec![3, 3, 2]),
        ("its.stationID", vec![4_294_967_295, 501, 42]),
        // SPATEM: two intersections with the same movements.
        ("dsrc.moy", twice(&[218_159])),
        ("dsrc.eventState", twice(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 1])),
        (
            "dsrc.minEndTime",
            twice(&[3999, 7999, 11_999, 15_999, 19_999, 23_999, 27_999, 31_999, 35_999]),
        ),
        ("dsrc.maxEndTime", twice(&[36_000; 9])),
        ("dsrc.likelyTime", twice(&[36_001; 9])),
        ("dsrc.startTime", twice(&[2, 4, 6, 8])),
        ("dsrc.nextTime", twice(&[17; 3])),
        ("dsrc.confidence", twice(&[7, 8, 9, 10, 11, 12, 13, 14, 15])),
        ("dsrc.signalGroup", vec![1, 254, 1, 254, 254]),
        ("dsrc.revision", vec![127, 0, 127]),
        // MAPEM.
        ("dsrc.msgIssueRevision", vec![9]),
        ("dsrc.laneWidth", vec![325]),
        ("dsrc.laneID", vec![1, 2]),
        ("dsrc.ingressApproach", vec![3]),
        ("dsrc.egressApproach", vec![15]),
        ("dsrc.x", vec![-511, 1023, -2047, 4095, 8191, -32_768, 0, 500]),
        ("dsrc.y", vec![0, -1023, 2047, 5, -8191, 32_767, 0, 0]),
        ("dsrc.lat", vec![-337_000_000]),
        ("dsrc.long", vec![1_799_999_999]),
        // CAM.
        ("cam.generationDeltaTime", vec![65_535]),
        ("its.headingValue", vec![3599]),
        ("its.speedValue", vec![1389]),
        ("its.longitudinalAccelerationValue", vec![-35]),
        ("its.yawRateValue", vec![-12]),
        ("its.vehicleLengthValue", vec![45]),
    ];
    let names: Vec<_> =
        expected.iter().map(|(name, _)| *name).chain(["frame.time_epoch"]).collect();
    let found = fields(&capture, &names);
    let epochs = &found["frame.time_epoch"];
    assert!(epochs[0].starts_with("1780315170.123456"), "{epochs:?}");
    for (name, expected) in expected {
        let found: Vec<i64> = found[name].iter().map(|v| v.parse().expect(name)).collect();
        assert_eq!(found, expected, "{name}");
    }
}

/// A Python with pycrate. Test processes run side by side: the first one creates it, and the others wait.
fn interpreter() -> Result<PathBuf, String> {
    let venv = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pycrate-venv");
    let lock = File::create(venv.with_extension("lock")).map_err(|error| error.to_string())?;
    lock.lock().map_err(|error| error.to_string())?;
    let python = venv.join("bin/python");
    let has = |python: &Path| {
        let output = Command::new(python).args(["-c", "import pycrate_asn1dir.ITS_IS"]).output();
        output.is_ok_and(|output| output.status.success())
    };
    if has(&python) {
        return Ok(python);
    }
    let step = |command: &mut Command, what: &str| match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr);
            Err(format!("{what}: {}", text.trim().lines().last().unwrap_or("no reason given")))
        }
        Err(error) => Err(format!("{what}: {error}")),
    };
    // The remains of an interrupted attempt would be in the way.
    step(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&venv), "python3 -m venv")?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", PYCRATE];
    step(Command::new(&python).args(pip), "pip install pycrate")?;
    if has(&python) { Ok(python) } else { Err("pycrate does not start".to_owned()) }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let digits = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).expect("hexadecimal");
    (0..text.len()).step_by(2).map(digits).collect()
}

/// A foreign payload after our headers.
fn framed(port: u16, payload: &[u8]) -> Vec<u8> {
    let headers = its::geonetworking::Headers { source: source(), traffic_class: 3, port };
    let mut frame = Vec::new();
    headers.write(payload.len() as u16, &mut frame);
    frame.extend(payload);
    frame
}

fn pycrate_encodes_the_same_bytes_and_its_frames_are_read() {
    let python = interpreter().expect("it was there");
    let ours: Vec<String> = ["spatem", "mapem", "cam"]
        .into_iter()
        .zip(frames())
        .map(|(kind, frame)| {
            let bytes = frame.encode().expect("in range");
            format!("{kind} {}", hex(&bytes[HEADER_BYTES..]))
        })
        .collect();
    let input = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("oracle.txt");
    std::fs::write(&input, ours.join("\n")).expect("it can be written");
    let said = run(Command::new(python)
        .args(["-c", SCRIPT])
        .stdin(std::fs::File::open(&input).expect("just written")));
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[..3], ours, "pycrate encodes what it read to the same bytes");

    let theirs = |line: &str| unhex(line.split(' ').nth(1).expect("kind and bytes"));
    let frame = Frame::decode(&framed(2004, &theirs(lines[3]))).expect("a SPATEM of theirs");
    let Message::Spatem(spatem) = frame.message else { panic!("{frame:?}") };
    let intersection = &spatem.intersections[0];
    assert_eq!((spatem.station_id, intersection.region, intersection.id), (77, Some(49), 501));
    assert_eq!(intersection.status, 1, "bit 0 is the first");
    assert_eq!(intersection.stamp, Some(Stamp { minute_of_year: 1234, millisecond: 59_999 }));
    let movement = &intersection.movements[0];
    assert_eq!(movement.signal_group, 9);
    assert_eq!(movement.events[0].state, MovementPhase::PermissiveMovementAllowed);
    let timing = movement.events[0].timing.expect("they gave one");
    assert_eq!((timing.min_end.value(), timing.confidence), (35_999, Some(7)));
    assert_eq!(
        (timing.max_end, timing.likely_end),
        (Some(TimeMark::BEYOND), Some(TimeMark::UNKNOWN))
    );

    let frame = Frame::decode(&framed(2003, &theirs(lines[4]))).expect("a MAPEM of theirs");
    let Message::Mapem(mapem) = frame.message else { panic!("{frame:?}") };
    let geometry = &mapem.intersections[0];
    assert_eq!((geometry.id, geometry.revision, geometry.unread_lanes), (502, 4, 2));
    assert_eq!(geometry.reference, Position { latitude: 487_000_000, longitude: -91_000_000 });
    let lane = &geometry.lanes[0];
    assert_eq!((lane.id, lane.approach), (1, Approach::Ingress(2)));
    assert_eq!(lane.nodes, [(-5, 6), (-30_000, 0)]);
    assert_eq!(lane.connections[0].signal_group, Some(9));
}

/// The foreign messages of other tests are pycrate's.
fn pycrate_makes_the_messages_of_others() {
    let python = interpreter().expect("it was there");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/foreign.py");
    let made: String =
        ["sae", "is", "cam"].map(|which| run(Command::new(&python).args([script, which]))).concat();
    assert_eq!(made, include_str!("foreign.txt"));
}

fn tshark() -> Result<(), String> {
    match Command::new("tshark").arg("--version").output() {
        Ok(_) => Ok(()),
        Err(_) => Err("no tshark".to_owned()),
    }
}

fn trial(name: &'static str, missing: Result<(), String>, run: fn()) -> Trial {
    let trial = Trial::test(name, move || {
        run();
        Ok(())
    });
    match missing {
        Ok(()) => trial,
        Err(reason) => trial.with_kind(format!("SKIPPED: {reason}")).with_ignored_flag(true),
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = vec![
        trial("tshark_reads_every_field", tshark(), tshark_reads_every_field),
        trial(
            "pycrate_encodes_the_same_bytes_and_its_frames_are_read",
            interpreter().map(|_| ()),
            pycrate_encodes_the_same_bytes_and_its_frames_are_read,
        ),
        trial(
            "pycrate_makes_the_messages_of_others",
            interpreter().map(|_| ()),
            pycrate_makes_the_messages_of_others,
        ),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}
