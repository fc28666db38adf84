//! Bad input gets one clear error with its place and the expected value, and leaves nothing. The exit status is 2 (3
//! for a fault of the machine).

use std::path::Path;
use std::process::{Command, ExitCode};
use system_tests::cases::{self, case, needing};
use system_tests::{Corner, text};

mod machine;
#[cfg(feature = "zenoh")]
mod zenoh;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Runs the command, which must end with `status` and print all `words`.
fn refused(arguments: &[&str], status: i32, words: &[&str]) {
    let corner = Corner::new(PROGRAM);
    refused_in(&corner, arguments, status, words);
}

fn refused_in(corner: &Corner, arguments: &[&str], status: i32, words: &[&str]) {
    let output = corner.run(arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", text(&output));
    for word in words {
        assert!(said.contains(word), "{arguments:?} should say `{word}`:\n{said}");
    }
    let errors = said.lines().filter(|line| line.starts_with("error")).count();
    assert_eq!(errors, 1, "one error:\n{said}");
    assert!(output.stdout.is_empty(), "nothing on standard output: {}", text(&output));
    corner.expect_nothing_left(&[]);
}

/// A scenario file with these lines after the head of lines 1 to 3.
fn scenario(corner: &Corner, lines: &str) -> String {
    let text = format!("schema_version = 1\nname = \"mine\"\nduration_s = 1\n{lines}");
    std::fs::write(corner.path().join("mine.toml"), text).expect("our own directory");
    "mine.toml".into()
}

fn refused_scenario(lines: &str, words: &[&str]) {
    let corner = Corner::new(PROGRAM);
    let file = scenario(&corner, lines);
    refused_in(&corner, &["run", &file], 2, words);
}

fn scenario_files() {
    refused(&["run", "no-such"], 2, &["no-such", "cacc-a"]);
    refused(&["run", "./no-such.toml"], 2, &["no-such.toml"]);
    refused_scenario("[plant]\nperiod_ms = -10\n", &["mine.toml:5:13", "^", "1 to 10000"]);
    refused_scenario(
        "[plant]\npowertrain = { mass_kg = 0, max_power_kw = 90 }\n",
        &["mine.toml:5", "^", "100 to 100000 kg"],
    );
    refused_scenario("set_speed_mps = nan\n", &["mine.toml:4:17", "^", "0 to 100 m/s"]);
    refused_scenario("set_speed = 20\n", &["mine.toml:4:1", "^", "set_speed_mps"]);
    refused_scenario("[controller]\nname = \"pid\"\n", &["mine.toml:5:8", "^", "cacc-mpc"]);
    refused_scenario("[controller\n", &["mine.toml:4", "^"]);
    refused_scenario("[perception]\nperiod_ms = 15\n", &["mine.toml:5", "^", "multiple"]);
    refused_scenario(
        "[controller]\nname = \"six-mode\"\nsix_mode = { braking_mps2 = -1 }\n",
        &["mine.toml:6", "^", "braking_mps2"],
    );
    refused_scenario("schema_version = 2\n", &["mine.toml"]);
    two_models_of_the_radar();
}

/// `ideal` is a complete model of the radar: another one beside it is ambiguous.
fn two_models_of_the_radar() {
    refused_scenario(
        "[perception]\nideal = true\nradar.model = \"object-list\"\n",
        &["mine.toml:6", "^", "perception.ideal = true", "perception.ideal = false"],
    );
    let more = ["run", "cacc-a", "--set", "perception.radar.model=detections"];
    refused(&more, 2, &["--set perception.radar.model=detections", "perception.ideal = false"]);
}

/// OpenSCENARIO features outside driver assistance.
fn driver_assistance() {
    refused_scenario(
        "[aebs]\nenabled = true\ndeceleration_mps2 = 4\n",
        &["mine.toml:6", "^", "no authority", "at least 5 m/s²"],
    );
    refused_scenario(
        "[[actors]]\nname = \"lead\"\ngap_m = 20\nprofile.cycle = \"nedc\"\n",
        &["mine.toml:7", "^", "nedc", "udds"],
    );
    refused(&["test", "r157", "--sample", "0"], 2, &["--sample", "'0'"]);
    refused(
        &["run", "following", "--set", "faults=[{ kind = \"hog\", core = 1023, at_s = 1 }]"],
        2,
        &["faults.0", "core 1023", "expected one of 0"],
    );
    refused(
        &["test", "r157", "--models-only", "--matrix", "following", "--table", "models.csv"],
        2,
        &["there are none", "--matrix cut-in"],
    );
    refused(
        &["test", "r157", "--models-only", "--processes"],
        2,
        &["--models-only", "--processes"],
    );
    refused(&["list", "--show", "cacc-a", "--param", "A=1"], 2, &["A=1", "--show FILE.xosc"]);
    refused(&["compare", "cacc-a", "cacc-a"], 2, &["cacc-a is there twice"]);
    refused(
        &["string", "cacc-a", "--vehicles", "2", "--vary", "controller.name=acc-mpc,six-mode"],
        2,
        &["controller.name", "--controllers"],
    );
    vehicles_wider_than_the_lane();
}

fn vehicles_wider_than_the_lane() {
    let corner = Corner::new(PROGRAM);
    let write = |name: &str, text: &str| {
        std::fs::write(corner.path().join(name), text).expect("our own directory");
    };
    std::fs::create_dir(corner.path().join("catalogs")).expect("our own directory");
    write("cut_in.xosc", include_str!("../../../examples/openscenario/cut_in.xosc"));
    let road = include_str!("../../../examples/openscenario/straight.xodr");
    write("straight.xodr", &road.replace("a=\"3.5\"", "a=\"1.6\""));
    let users = include_str!("../../../examples/openscenario/catalogs/road_users.xosc");
    write("catalogs/road_users.xosc", users);
    refused_in(&corner, &["run", "cut_in.xosc"], 2, &["cut_in.xosc", "wide", "1.6 m of lane"]);
}

fn options() {
    refused(&["run", "--set", "plant.period_ms=0"], 2, &["--set", "plant.period_ms", "1 to 10000"]);
    refused(&["run", "--set", "plant.mass=1"], 2, &["--set", "plant.mass"]);
    refused(&["run", "--set", "nonsense"], 2, &["--set", "KEY=VALUE"]);
    refused(&["run", "--controller", "pid"], 2, &["--controller", "acc-mpc"]);
    refused(&["run", "--duration", "-3"], 2, &["--duration", "duration"]);
    refused(&["run", "--service", "radar=/bin/true"], 2, &["radar", "perception-sim"]);
    refused(&["list", "--show", "no-such"], 2, &["no-such", "cacc-a"]);
    refused(&["test", "plausibility", "--sample", "3"], 2, &["--sample"]);
}

/// Likely slips, and the words that help.
fn slips_of_the_hand() {
    refused(&["run", "--duration", "30s"], 2, &["--duration 30s", "a number alone, such as 30"]);
    refused(
        &["run", "--set", "set_speed_mps=20mps"],
        2,
        &["`20mps` is not a number", "such as 20"],
    );
    let command = "[\"python3\", \"law.py\"]";
    refused(&["run", "--controller", "external"], 2, &["controller.command", command]);
    refused(&["run", "--set", "controller.command=python3 law.py"], 2, &[command]);
    let key = "did you mean `plant.powertrain.mass_kg`?";
    refused(&["run", "--set", "plant.mass_kg=1500"], 2, &["unknown key `mass_kg`", key]);
    refused(&["inject", "somewhere", "kill", "recorder"], 2, &["kill-helper recorder"]);
    refused(&["campaign", "mesages"], 2, &["did you mean `messages`?"]);
    refused_scenario("[plant]\nmass_kg = 1500\n", &["mine.toml:5:1", "^", key]);
}

/// Storyboards that a reader or a world refuses, with the line.
fn storyboards() {
    let corner = Corner::new(PROGRAM);
    let good = include_str!("../../../examples/openscenario/cut_in.xosc");
    let refuse = |from: &str, to: &str, words: &[&str]| {
        assert!(good.contains(from), "{from}");
        std::fs::write(corner.path().join("bad.xosc"), good.replacen(from, to, 1)).expect("ours");
        refused_in(&corner, &["run", "bad.xosc"], 2, words);
    };
    let entities = "<!DOCTYPE a [<!ENTITY b \"c\">]>\n<OpenSCENARIO";
    refuse("<OpenSCENARIO", entities, &["bad.xosc:4", "document type"]);
    let external = "<!DOCTYPE a SYSTEM \"a.dtd\">\n<Open";
    refuse("<Open", external, &["bad.xosc:"]);
    refuse("<Storyboard>", "<Storybord>", &["bad.xosc:", "not XML"]);
}

fn a_tampered_design() {
    let corner = Corner::new(PROGRAM);
    let shipped = include_str!("../../../shared/laws/designs/quadratic-bounded.json");
    std::fs::write(corner.path().join("good.json"), shipped).expect("our own directory");
    // The first digit after the first decimal point of the gains.
    let gains = shipped.find("\"rules\"").expect("the design has rules");
    let point = gains + shipped[gains..].find('.').expect("a number") + 1;
    let mut bytes = shipped.as_bytes().to_vec();
    bytes[point] = if bytes[point] == b'9' { b'1' } else { b'9' };
    std::fs::write(corner.path().join("bad.json"), bytes).expect("our own directory");
    let run = |design: &str| {
        let key = format!("controller.quadratic_bounded.design={design}");
        let arguments = [
            "run",
            "quadratic-bounded-follow",
            "--mode",
            "lockstep",
            "--duration",
            "1",
            "--set",
            &key,
        ];
        corner.run(&arguments)
    };
    let good = run("good.json");
    assert!(good.status.success(), "{}", text(&good));
    let bad = run("bad.json");
    assert_eq!(bad.status.code(), Some(2), "{}", text(&bad));
    assert!(text(&bad).contains("bad.json") && text(&bad).contains("design"), "{}", text(&bad));
}

fn radios() {
    let run = |radio, words: &[&str]| refused(&["run", "corridor", "--radio", radio], 2, words);
    run("morse", &["--radio", "`morse` is not a radio", "udp://"]);
    run("tcp://1.2.3.4:5", &["`tcp://1.2.3.4:5` is not a radio"]);
    run("udp://somewhere:5520", &["is not an IP address with a port"]);
    // An address for documentation, which no host has (RFC 5737).
    run("udp://192.0.2.7:5520", &["cannot listen on 192.0.2.7:5520"]);
    run("udp://239.255.3.1:5520?interface=nowhere0", &["no network interface `nowhere0`"]);
    run("pcap:no-such.pcap", &["no-such.pcap", "No such file"]);
    run("pcap:/dev/null", &["/dev/null"]);
    let lockstep = ["run", "corridor", "--mode", "lockstep", "--radio", "udp://239.255.3.1:5520"];
    refused(&lockstep, 2, &["simulated time", "--mode realtime", "pcap:FILE"]);
    refused(&[&lockstep[..], &["--in-process"]].concat(), 2, &["simulated time"]);
    let rsu = |radio, words: &[&str]| refused(&["rsu", "corridor", "--radio", radio], 2, words);
    rsu("frames", &["missing --radio", "udp://ADDRESS:PORT"]);
    rsu("pcap:drive.pcap", &["a capture cannot be sent to"]);
    rsu("udp://239.255.3.1:0", &["port 0"]);
    refused(&["rsu", "following", "--radio", "udp://239.255.3.1:5520"], 2, &["no signals"]);
    refused(&["rsu", "--duration", "-1", "--radio", "zenoh"], 2, &["seconds from 0.001"]);
    another_link_type();
    zenoh();
}

/// A capture of a Bluetooth adapter (link type 201) has no Ethernet header.
fn another_link_type() {
    let corner = Corner::new(PROGRAM);
    let words = [0xa1b2_c3d4_u32, 4 << 16 | 2, 0, 0, 65_535, 201, 1, 0, 4, 4, 0];
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    std::fs::write(corner.path().join("wireless.pcap"), bytes).expect("our own directory");
    let arguments = ["run", "corridor", "--radio", "pcap:wireless.pcap"];
    refused_in(&corner, &arguments, 2, &["wireless.pcap", "link type is 201", "1 (Ethernet)"]);
}

#[cfg(not(feature = "zenoh"))]
fn zenoh() {
    refused(&["run", "corridor", "--radio", "zenoh"], 2, &["--features zenoh"]);
}

#[cfg(feature = "zenoh")]
fn zenoh() {
    zenoh::configurations_that_are_none();
    zenoh::a_router_that_is_not_there();
    zenoh::a_router_that_says_nothing();
    zenoh::a_peer_that_is_not_there();
    zenoh::wrong_certificates();
}

fn output_directories() {
    // Not even root can create a directory below a file.
    refused(&["run", "--out", "/dev/null/results"], 2, &["/dev/null/results", "cannot"]);
    refused(&["run", "--out", "/proc/results"], 2, &["/proc/results", "cannot"]);
}

fn a_service_that_exits_at_once() {
    refused(
        &["run", "--service", "controller=/bin/true"],
        2,
        &["controller", "before it was ready"],
    );
    refused(&["run", "--service", "plant=/no/such/program"], 2, &["/no/such/program"]);
}

/// Endless output is neither kept nor awaited.
fn a_service_that_floods_its_output() {
    let program = ["/usr/bin/yes", "/bin/yes"].into_iter().find(|path| Path::new(path).exists());
    let service = format!("controller={}", program.expect("yes is everywhere"));
    refused(&["run", "--service", &service], 2, &["controller", "endless text"]);
}

/// A pipe is not a scenario file: reading would wait for it.
fn a_pipe_as_a_scenario() {
    let corner = Corner::new(PROGRAM);
    let pipe = corner.path().join("pipe.toml");
    let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is there");
    assert!(made.success());
    refused_in(&corner, &["run", "pipe.toml"], 2, &["pipe.toml", "not a regular file"]);
}

fn unknown_commands_and_faults_without_meaning() {
    refused(&["rnu"], 2, &["'rnu'", "'run'"]);
    refused(&["campaign", "nosuch"], 2, &["messages", "radio", "takeovers"]);
    refused(&["inject", "nowhere", "kill", "controller", "--for", "2"], 2, &["for"]);
    refused_scenario(
        "[[faults]]\nkind = \"kill\"\nservice = \"plant\"\nat_s = 1\nfor_s = 2\n",
        &["mine.toml:8:1", "^", "for_s"],
    );
}

/// Two files truncated before their first message are not equal.
fn recordings_without_a_message_that_can_be_read() {
    let corner = Corner::new(PROGRAM);
    let run = ["run", "cacc-a", "--mode", "lockstep", "--duration", "1", "--out", "x"];
    let output = corner.run(&run);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let bytes = std::fs::read(corner.path().join("x/recording.mcap")).expect("it was recorded");
    // Records of MCAP: an opcode, a length of eight bytes, the content; 6 is a chunk of messages.
    let mut at = 8;
    while bytes[at] != 6 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
        at += 9 + usize::try_from(length).expect("it is in memory");
    }
    for (name, length) in [("a.mcap", at + 20), ("b.mcap", at + 30)] {
        std::fs::write(corner.path().join(name), &bytes[..length]).expect("our own directory");
    }
    let output = corner.run(&["recording", "diff", "a.mcap", "b.mcap"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(
        text(&output).contains("a.mcap: damaged before its first message"),
        "{}",
        text(&output)
    );
}

fn a_service_that_never_becomes_ready() {
    let corner = Corner::new(PROGRAM);
    let program = corner.path().join("sleeper");
    std::fs::write(&program, "#!/bin/sh\nexec sleep 600\n").expect("our own directory");
    let executable = std::os::unix::fs::PermissionsExt::from_mode(0o700);
    std::fs::set_permissions(&program, executable).expect("our own file");
    let service = format!("v2x-sim={}", program.display());
    let arguments = ["run", "--service", &service, "--ready-timeout", "0.5"];
    refused_in(&corner, &arguments, 2, &["v2x-sim", "not ready within 0.5 s"]);
}

fn main() -> ExitCode {
    cases::run(&[
        case("scenario_files", scenario_files),
        case("driver_assistance", driver_assistance),
        case("options", options),
        case("slips_of_the_hand", slips_of_the_hand),
        case("storyboards", storyboards),
        case("a_tampered_design", a_tampered_design),
        case("radios", radios),
        case("output_directories", output_directories),
        case("a_service_that_exits_at_once", a_service_that_exits_at_once),
        case("a_service_that_never_becomes_ready", a_service_that_never_becomes_ready),
        case("a_service_that_floods_its_output", a_service_that_floods_its_output),
        case("a_pipe_as_a_scenario", a_pipe_as_a_scenario),
        case("low_limits_of_the_machine", machine::low_limits_of_the_machine),
        case(
            "unknown_commands_and_faults_without_meaning",
            unknown_commands_and_faults_without_meaning,
        ),
        case("a_full_standard_output", machine::a_full_standard_output),
        case(
            "recordings_without_a_message_that_can_be_read",
            recordings_without_a_message_that_can_be_read,
        ),
        case("a_foreign_base_directory", machine::a_foreign_base_directory),
        needing(cases::mount_namespace, "full_shared_memory", machine::full_shared_memory),
        needing(
            cases::mount_namespace,
            "read_only_shared_memory",
            machine::read_only_shared_memory,
        ),
        needing(cases::mount_namespace, "full_disk", machine::full_disk),
    ])
}
