//! Other programs read timegap's files and messages: PyPI's `mcap`, `rosbags`, `pandas` and `iceoryx2`, and a
//! C compiler.

mod tables;

use messages::{Odometry, TOPICS, Topic};
use recorder::Recording;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};
use system_tests::cases::{self, Needed, needing};
use system_tests::missing::Missing;
use system_tests::{Corner, python, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const SCRIPTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/python");

fn interpreter() -> Result<PathBuf, Missing> {
    python::INTEROP.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

fn pypi() -> Needed {
    interpreter().map(|_| ())
}

fn c_compiler() -> Needed {
    cases::program("cc")
}

fn tshark() -> Needed {
    cases::program("tshark")
}

fn succeeded(command: &mut Command) -> String {
    let output: Output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", text(&output));
    String::from_utf8(output.stdout).expect("text")
}

/// Output of `timegap ARGUMENTS`.
fn printed(corner: &Corner, arguments: &[&str]) -> String {
    succeeded(&mut corner.command(arguments))
}

/// The indented lines of a command's long help: an example that users copy.
fn example(corner: &Corner, command: &str) -> String {
    let help = printed(corner, &[command, "--help"]);
    let after = help.rsplit_once(":\n\n").expect("an example after a colon").1;
    after.lines().map(|line| line.strip_prefix("    ").unwrap_or(line).to_owned() + "\n").collect()
}

/// Every message by topic, sender and sequence number, as its scalars.
type Lines = BTreeMap<(String, String, String), Vec<String>>;

fn other_readers_see_the_same_values() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    // Signals without an announced end have infinite times; a cut-in has several tracks.
    // A truck has topics of its own.
    for (scenario, mode) in
        [("corridor", "lockstep"), ("cut-in", "realtime"), ("truck-follow", "lockstep")]
    {
        let arguments = ["run", scenario, "--mode", mode, "--duration", "1", "--out", scenario];
        printed(&corner, &arguments);
        let recording = Recording::open(&corner.path().join(scenario)).expect("a recording");
        for library in ["mcap", "rosbags"] {
            let script = Path::new(SCRIPTS).join("flatten.py");
            let lines =
                succeeded(Command::new(&python).arg(script).arg(library).arg(recording.path()));
            compare(&recording, &keyed(&lines), library);
        }
    }
}

fn keyed(lines: &str) -> Lines {
    let at = |path: &str| {
        let places = Topic::Odometry.layout().scalars();
        places.iter().position(|place| place.path == path).expect("of the header") + 1
    };
    let (sequence, source) = (at("header.sequence"), at("header.source"));
    lines
        .lines()
        // Viewers have topics of their own.
        .filter(|line| TOPICS.iter().any(|topic| line.starts_with(&format!("{} ", topic.name()))))
        .map(|line| {
            let mut words = line.split(' ').map(str::to_owned);
            let topic = words.next().expect("a topic");
            let words: Vec<_> = words.collect();
            ((topic, words[source].clone(), words[sequence].clone()), words)
        })
        .collect()
}

fn compare(recording: &Recording, theirs: &Lines, library: &str) {
    use messages::Value;
    assert_eq!(theirs.len(), recording.records().count(), "{library}: as many messages");
    for record in recording.records() {
        let places = record.topic.layout().scalars();
        let value = |path: &str| {
            let place = places.iter().find(|place| place.path == path).expect("of the header");
            place.read(record.bytes()).to_string()
        };
        let key =
            (record.topic.name().to_owned(), value("header.source"), value("header.sequence"));
        let words = theirs.get(&key).expect("every message is there");
        assert_eq!(words.len(), places.len() + 1, "{library}: {key:?}");
        let log_time_ns = recording.metadata().epoch_ns + record.log_time_ns;
        assert_eq!(words[0], log_time_ns.to_string(), "{library}: {key:?}");
        for (place, word) in places.iter().zip(&words[1..]) {
            let same = match place.read(record.bytes()) {
                Value::Float(ours) => {
                    let theirs: f64 = word.parse().expect("a number");
                    theirs.to_bits() == ours.to_bits() || theirs.is_nan() && ours.is_nan()
                }
                ours => ours.to_string() == *word,
            };
            assert!(same, "{library}: {key:?} {}: {word}", place.path);
        }
    }
}

fn the_pandas_example_runs_as_printed() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    printed(&corner, &["run", "--mode", "lockstep", "--duration", "2", "--out", "runs/mine"]);
    printed(&corner, &["recording", "export", "runs/mine", "--csv"]);
    let script = example(&corner, "export");
    assert!(script.contains("import pandas"), "{script}");
    let table = succeeded(Command::new(&python).args(["-c", &script]).current_dir(corner.path()));
    let recording = Recording::open(&corner.path().join("runs/mine")).expect("a recording");
    let speeds: Vec<_> =
        recording.messages::<Odometry>().map(|timed| timed.message.speed_mps).collect();
    let row = |name: &str| -> f64 {
        let line = table.lines().find(|line| line.starts_with(name)).expect("a row of the table");
        line.split_whitespace().nth(1).expect("a speed").parse().expect("a number")
    };
    assert_eq!(row("count"), speeds.len() as f64);
    let max = speeds.iter().copied().fold(f64::MIN, f64::max);
    assert!((row("max") - max).abs() < 1e-5, "{table}");
}

fn a_python_process_hears_a_running_group() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    let module = printed(&corner, &["print", "layouts", "--python"]);
    std::fs::write(corner.path().join("timegap_messages.py"), module).expect("writable");
    let mut run = corner.start(&["run", "cacc-a", "--duration", "600", "--out", "runs/mine"]);
    let live = corner.path().join("runs/mine/live.json");
    assert!(wait_for(|| live.exists()), "never drove");
    let listen = example(&corner, "layouts")
        + "import time\n\
           heard = []\n\
           while len(heard) < 20:\n    \
               if sample is not None:\n        \
                   odometry = sample.payload().contents\n        \
                   heard.append(bytes(odometry).hex())\n    \
               time.sleep(0.001)\n    \
               sample = subscriber.receive()\n\
           print(*heard, sep='\\n')\n";
    let output = Command::new(&python)
        .args(["-c", &listen])
        .current_dir(corner.path())
        .output()
        .expect("it starts");
    let pid = rustix::process::Pid::from_child(&run);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("our child");
    run.wait().expect("our child");
    assert!(output.status.success(), "{}", text(&output));
    // Python received the recorded bytes.
    let recording = Recording::open(&corner.path().join("runs/mine")).expect("a recording");
    let recorded: Vec<String> = recording
        .records()
        .filter(|record| record.topic == Topic::Odometry)
        .map(|record| record.bytes().iter().map(|byte| format!("{byte:02x}")).collect())
        .collect();
    for heard in String::from_utf8_lossy(&output.stdout).lines() {
        assert!(recorded.iter().any(|message| message == heard), "{heard}");
    }
}

fn a_c_compiler_lays_the_structs_out_alike() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("timegap.h"), printed(&corner, &["print", "layouts", "--c"]))
        .expect("writable");
    let layouts: Value =
        serde_json::from_str(&printed(&corner, &["print", "layouts", "--json"])).expect("JSON");
    let structs = layouts["structs"].as_array().expect("structs");
    let (mut body, mut expected) = (String::new(), String::new());
    for layout in structs {
        let name = layout["name"].as_str().expect("a name");
        body += &format!("    printf(\"%zu\\n\", sizeof(Timegap{name}));\n");
        expected += &format!("{}\n", layout["bytes"]);
        for field in layout["fields"].as_array().expect("fields") {
            let field_name = field["name"].as_str().expect("a name");
            body += &format!("    printf(\"%zu\\n\", offsetof(Timegap{name}, {field_name}));\n");
            expected += &format!("{}\n", field["offset"]);
        }
    }
    for topic in TOPICS {
        assert!(structs.iter().any(|layout| layout["name"] == topic.layout().name));
    }
    let source =
        format!("#include \"timegap.h\"\n#include <stdio.h>\nint main(void) {{\n{body}}}\n");
    std::fs::write(corner.path().join("main.c"), source).expect("writable");
    let compiled = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "main.c", "-o", "main"])
        .current_dir(corner.path())
        .output()
        .expect("looked for before");
    assert!(compiled.status.success(), "{}", text(&compiled));
    assert_eq!(succeeded(&mut Command::new(corner.path().join("main"))), expected);
}

fn wireshark_reads_the_frames_of_a_run() {
    let corner = Corner::new(PROGRAM);
    printed(&corner, &["run", "corridor", "--mode", "lockstep", "--duration", "3", "--out", "out"]);
    printed(&corner, &["recording", "export", "out", "--pcap"]);
    let capture = corner.path().join("out/radio.pcap");
    let tshark = |arguments: &[&str]| {
        succeeded(Command::new("tshark").arg("-r").arg(&capture).args(arguments))
    };
    assert_eq!(tshark(&["-Y", "_ws.malformed || _ws.expert.severity >= 0x600000"]), "");
    let fields =
        ["-T", "fields", "-e", "frame.time_epoch", "-e", "its.stationID", "-e", "btpb.dstport"];
    let lines = tshark(&fields);
    let recording = Recording::open(&corner.path().join("out")).expect("a recording");
    let heard = recording.messages::<messages::RadioFrames>().map(|timed| timed.message.count);
    let sent = recording.messages::<messages::RadioSent>().count();
    assert_eq!(lines.lines().count(), heard.sum::<u64>() as usize + sent, "{lines}");
    // A SPATEM per period and a MAPEM per second, then the ego's own CAMs.
    let count = |what: &str| lines.lines().filter(|line| line.ends_with(what)).count();
    assert_eq!((count("\t100001\t2004"), count("\t100001\t2003")), (31, 4), "{lines}");
    assert_eq!(count("\t4711\t2001"), sent, "{lines}");
    assert!(lines.starts_with("1780315200.000000"), "{lines}");
}

/// An independent implementation of AUTOSAR E2E profile 7 accepts every recorded message, and no message with a flipped
/// bit. It protects each with the same bytes.
fn another_implementation_of_the_end_to_end_protection_agrees() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    printed(&corner, &["run", "corridor", "--mode", "lockstep", "--duration", "2", "--out", "out"]);
    let recording = Recording::open(&corner.path().join("out")).expect("a recording");
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let messages: Vec<String> = (recording.records())
        .map(|record| {
            format!("{} {}", record.topic.data_id(record.header().source), hex(record.bytes()))
        })
        .collect();
    let file = corner.path().join("messages");
    std::fs::write(&file, messages.join("\n") + "\n").expect("ours");
    let script = Path::new(SCRIPTS).join("e2e_check.py");
    let input = std::fs::File::open(&file).expect("just written");
    let answers = succeeded(Command::new(&python).arg(script).stdin(input));
    assert!(messages.len() > 300 && answers.lines().count() == messages.len());
    for (answer, message) in answers.lines().zip(&messages) {
        let bytes = message.split_once(' ').expect("two words").1;
        let protected = answer.strip_prefix("1 0 ").expect("intact, and not any more");
        let unused = bytes.strip_prefix(protected).expect("the same bytes");
        assert!(unused.bytes().all(|digit| digit == b'0'), "{message}");
    }
}

/// The results directory opens as a rosbag2 with the types of the package only.
fn a_run_is_a_rosbag2_in_the_order_of_time() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    printed(&corner, &["print", "layouts", "--msg", "ros"]);
    for (scenario, mode) in [("corridor", "lockstep"), ("cut-in", "realtime")] {
        let arguments = ["run", scenario, "--mode", mode, "--duration", "1", "--out", scenario];
        printed(&corner, &arguments);
        let script = Path::new(SCRIPTS).join("rosbag.py");
        let counts = succeeded(
            Command::new(&python)
                .arg(script)
                .args([scenario, "ros/timegap_msgs"])
                .current_dir(corner.path()),
        );
        for topic in ["/tf", "/scene/markers", "/scene/outlines", "vehicle/odometry"] {
            assert!(counts.lines().any(|line| line.starts_with(topic)), "{topic}: {counts}");
        }
    }
}

/// Files of the format's own library are read: the same messages in any packing.
fn recordings_of_another_writer_are_the_same() {
    let python = interpreter().expect("looked for before");
    let corner = Corner::new(PROGRAM);
    printed(&corner, &["run", "corridor", "--mode", "lockstep", "--duration", "2", "--out", "out"]);
    let script = Path::new(SCRIPTS).join("rewrite.py");
    let file = corner.path().join("out/recording.mcap");
    succeeded(Command::new(&python).arg(script).arg(&file).arg(corner.path()));
    let ours = corner.json(&["recording", "info", "out"]);
    for name in ["zstd", "lz4", "plain", "bare"] {
        let other = format!("{name}.mcap");
        assert_eq!(corner.json(&["recording", "diff", "out", &other])["equal"], true, "{name}");
        let info = corner.json(&["recording", "info", &other]);
        assert_eq!((&info["messages"], &info["topics"]), (&ours["messages"], &ours["topics"]));
    }
    // A recorder of ours never writes these forms.
    for (name, reason) in [("unchunked", "messages outside of chunks"), ("reversed", "log times")] {
        let refused = corner.run(&["recording", "diff", "out", &format!("{name}.mcap")]);
        assert_eq!(refused.status.code(), Some(2), "{name}: {}", text(&refused));
        assert!(text(&refused).contains(reason), "{name}: {}", text(&refused));
    }
    let whole = std::fs::read(corner.path().join("zstd.mcap")).expect("just written");
    std::fs::write(corner.path().join("cut.mcap"), &whole[..whole.len() / 2]).expect("writable");
    let cut = corner.run(&["recording", "export", "cut.mcap", "--csv", "--out", "csv"]);
    // Its metadata followed the messages.
    assert_eq!(cut.status.code(), Some(2), "{}", text(&cut));
}

/// The layout for Foxglove names topics and fields of a recording.
fn the_shipped_layout_shows_what_is_there() {
    let layout = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/foxglove-layout.json");
    let layout: Value =
        serde_json::from_slice(&std::fs::read(layout).expect("shipped")).expect("JSON");
    let panels = layout["configById"].as_object().expect("panels");
    let mut paths = 0;
    for path in panels.values().flat_map(|panel| panel["paths"].as_array().into_iter().flatten()) {
        let (topic, field) =
            path["value"].as_str().and_then(|v| v.split_once('.')).expect("a path");
        let topic = Topic::by_name(topic).expect("a topic of ours");
        assert!(topic.layout().scalars().iter().any(|place| place.path == field), "{field}");
        paths += 1;
    }
    assert!(paths > 5, "{paths}");
}

fn always() -> Needed {
    Ok(())
}

fn main() -> ExitCode {
    cases::run(&[
        needing(tshark, "wireshark_reads_the_frames_of_a_run", wireshark_reads_the_frames_of_a_run),
        needing(
            pypi,
            "a_run_is_a_rosbag2_in_the_order_of_time",
            a_run_is_a_rosbag2_in_the_order_of_time,
        ),
        needing(
            pypi,
            "recordings_of_another_writer_are_the_same",
            recordings_of_another_writer_are_the_same,
        ),
        needing(
            always,
            "the_shipped_layout_shows_what_is_there",
            the_shipped_layout_shows_what_is_there,
        ),
        needing(pypi, "other_readers_see_the_same_values", other_readers_see_the_same_values),
        needing(
            pypi,
            "kept_trajectories_are_those_of_the_runs",
            tables::kept_trajectories_are_those_of_the_runs,
        ),
        needing(
            pypi,
            "every_drive_of_a_study_has_its_row_and_its_trajectory",
            tables::every_drive_of_a_study_has_its_row_and_its_trajectory,
        ),
        needing(
            pypi,
            "parquet_tables_hold_what_csv_tables_hold",
            tables::parquet_tables_hold_what_csv_tables_hold,
        ),
        needing(pypi, "the_pandas_example_runs_as_printed", the_pandas_example_runs_as_printed),
        needing(
            pypi,
            "a_python_process_hears_a_running_group",
            a_python_process_hears_a_running_group,
        ),
        needing(
            c_compiler,
            "a_c_compiler_lays_the_structs_out_alike",
            a_c_compiler_lays_the_structs_out_alike,
        ),
        needing(
            pypi,
            "another_implementation_of_the_end_to_end_protection_agrees",
            another_implementation_of_the_end_to_end_protection_agrees,
        ),
    ])
}
