//! `timegap recording trace`, read with Perfetto's own definitions.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use system_tests::cases::{self, Needed, case, needing};
use system_tests::missing::Missing;
use system_tests::python::TRACE;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Reads a trace with the public protos and prints its contents as JSON.
const READER: &str = r#"
import collections, json, sys
from perfetto.protos.perfetto.trace import perfetto_trace_pb2 as pb

trace = pb.Trace()
trace.ParseFromString(open(sys.argv[1], "rb").read())
names, slices, open_slices, flows, counters, instants = {}, [], collections.defaultdict(list), collections.defaultdict(list), collections.Counter(), []
last = 0
for packet in trace.packet:
    if packet.HasField("track_descriptor"):
        names[packet.track_descriptor.uuid] = packet.track_descriptor.name
    if not packet.HasField("track_event"):
        continue
    assert packet.timestamp >= last
    last = packet.timestamp
    event = packet.track_event
    track = names[event.track_uuid]
    for flow in event.flow_ids:
        flows[flow].append(track)
    for flow in event.terminating_flow_ids:
        flows[flow].append(track)
    if event.type == pb.TrackEvent.TYPE_SLICE_BEGIN:
        open_slices[track].append((packet.timestamp, event.name, list(event.categories)))
    elif event.type == pb.TrackEvent.TYPE_SLICE_END:
        begin, name, categories = open_slices[track].pop()
        slices.append([track, name, begin, packet.timestamp, categories])
    elif event.type == pb.TrackEvent.TYPE_COUNTER:
        counters[track] += 1
    elif event.type == pb.TrackEvent.TYPE_INSTANT:
        instants.append([track, event.name, list(event.categories)])
assert not any(open_slices.values()), open_slices
clocks = [c.clock_id for p in trace.packet if p.HasField("clock_snapshot") for c in p.clock_snapshot.clocks]
print(json.dumps({"tracks": list(names.values()), "slices": slices, "flows": list(flows.values()),
                  "counters": counters, "instants": instants, "clocks": clocks}))
"#;

/// A Python with PyPI's `perfetto` in a reused virtual environment.
fn python() -> Result<PathBuf, Missing> {
    TRACE.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

fn perfetto() -> Needed {
    python().map(|_| ())
}

fn read(python: &PathBuf, corner: &Corner) -> Value {
    let trace = corner.path().join("out/trace.pftrace");
    let output = Command::new(python).args(["-c", READER]).arg(trace).output().expect("it starts");
    assert!(output.status.success(), "{}", text(&output));
    serde_json::from_slice(&output.stdout).expect("the reader prints JSON")
}

fn perfetto_reads_what_was_written() {
    let python = python().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    let summary = corner.json(&["run", "--duration", "2", "--out", "out"]);
    let written = corner.json(&["recording", "trace", "out"]);
    let seen = read(&python, &corner);

    let list = |key: &str| seen[key].as_array().expect("a list").clone();
    let named = |name: &str| {
        let tracks = list("tracks");
        tracks.iter().any(|track| track.as_str().is_some_and(|track| track.starts_with(name)))
    };
    for service in ["perception-sim", "v2x-sim", "controller", "plant"] {
        assert!(named(service), "{service}: {}", seen["tracks"]);
    }
    assert!(!named("core"), "the stamps do not say what a processor did: {}", seen["tracks"]);
    assert_eq!(list("clocks").len(), 2, "run time and the wall's clock");
    for figure in ["speed", "request", "gap"] {
        assert!(seen["counters"][figure].as_u64() > Some(0), "{figure}");
    }

    // Every cycle of the controller is a slice, and the arrows follow the chain.
    let slices = list("slices");
    let of = |track: &str, name: &str| {
        slices
            .iter()
            .filter(|s| s[0].as_str().is_some_and(|t| t.starts_with(track)) && s[1] == name)
            .count() as u64
    };
    let cycles = summary["timing"]["cycles"].as_u64().expect("counted");
    assert_eq!(of("controller", "cycle"), cycles);
    assert!(of("plant", "cycle") >= 200, "{}", of("plant", "cycle"));
    assert_eq!(
        written["cycles"].as_u64(),
        Some(slices.iter().filter(|s| s[1] == "cycle").count() as u64)
    );
    let chains = summary["timing"]["reaction_time_us"]["count"].as_u64().expect("counted");
    let whole = list("flows")
        .iter()
        .filter(|flow| {
            let way: Vec<_> = flow.as_array().into_iter().flatten().collect();
            let on = |at: usize, name: &str| {
                way.get(at).and_then(|t| t.as_str()).is_some_and(|t| t.starts_with(name))
            };
            way.len() == 3 && on(0, "perception-sim") && on(1, "controller") && on(2, "plant")
        })
        .count() as u64;
    // The last command may have reached the plant after its last message.
    assert!(whole + 1 >= chains && whole <= chains, "{whole} arrows of {chains} chains");

    // Misses are marked, and nothing else.
    let missed = |items: Vec<Value>, at: usize| {
        let marked = items.into_iter().filter(|item| {
            item[at].as_array().into_iter().flatten().any(|category| category == "deadline-miss")
        });
        marked.count() as u64
    };
    assert_eq!(Some(missed(slices.clone(), 4)), written["deadline_misses"].as_u64());
    assert_eq!(missed(list("instants"), 2), missed(slices, 4));
}

fn what_went_wrong_is_marked() {
    let corner = Corner::new(PROGRAM);
    let faults = "schema_version = 1\nname = \"stopped\"\nduration_s = 2\n\
                  [[faults]]\nkind = \"stop\"\nservice = \"controller\"\nat_s = 0.55\nfor_s = 0.25\n";
    std::fs::write(corner.path().join("stopped.toml"), faults).expect("written");
    let run = corner.run(&["run", "stopped.toml", "--out", "out", "--json"]);
    assert!(matches!(run.status.code(), Some(0 | 1)), "{}", text(&run));
    let written = corner.json(&["recording", "trace", "out"]);
    // The fault, and the misses of a controller that stopped for two periods.
    assert!(written["incidents"].as_u64() >= Some(2), "{written}");

    let python = python().expect("looked for before");
    let seen = read(&python, &corner);
    let instants = seen["instants"].as_array().expect("a list");
    let named = |track: &str, name: &str| {
        instants.iter().any(|instant| {
            instant[0].as_str().is_some_and(|t| t.starts_with(track)) && instant[1] == name
        })
    };
    assert!(named("controller", "fault: stop"), "{instants:?}");
    assert!(
        named("controller", "deadline missed")
            || named("controller", "release skipped")
            || named("controller", "back after restart 1"),
        "{instants:?}"
    );
}

fn what_is_no_recording_is_refused() {
    let corner = Corner::new(PROGRAM);
    let nothing = corner.run(&["recording", "trace", "nowhere"]);
    assert_eq!(nothing.status.code(), Some(2), "{}", text(&nothing));
    std::fs::write(corner.path().join("x.mcap"), "no recording").expect("written");
    let foreign = corner.run(&["recording", "trace", "x.mcap"]);
    assert_eq!(foreign.status.code(), Some(2), "{}", text(&foreign));
    assert!(text(&foreign).contains("x.mcap"));
    let run = ["run", "following", "--mode", "lockstep", "--duration", "1", "--out", "short"];
    assert!(corner.run(&run).status.success());
    let recording = corner.path().join("short/recording.mcap");
    let before = std::fs::read(&recording).expect("recorded");
    for command in ["trace", "replay", "recover"] {
        let output = corner.run(&[command, "short", "--out", "short/../short/recording.mcap"]);
        assert_eq!(output.status.code(), Some(2), "{command}: {}", text(&output));
        assert!(text(&output).contains("is the recording itself"), "{}", text(&output));
        assert_eq!(std::fs::read(&recording).expect("it is there"), before, "{command}");
    }
}

fn main() -> ExitCode {
    cases::run(&[
        needing(perfetto, "perfetto_reads_what_was_written", perfetto_reads_what_was_written),
        needing(perfetto, "what_went_wrong_is_marked", what_went_wrong_is_marked),
        case("what_is_no_recording_is_refused", what_is_no_recording_is_refused),
    ])
}
