//! Readers of bytes from outside, with mutated examples. `fuzz/` has the same readers as libFuzzer targets.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use scenario::builtin;
use std::path::Path;
use system_tests::Corner;
use system_tests::fuzz::TARGETS;

/// Mutations of each example.
const MUTATIONS: u32 = 300;

fn examples(name: &str) -> Vec<Vec<u8>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let file = |path: &str| std::fs::read(data.join(path)).expect("it is in the repository");
    let text = |text: &str| text.as_bytes().to_vec();
    match name {
        "scenario" => builtin::ALL.iter().map(|builtin| text(builtin.text)).collect(),
        "speed_table" => vec![
            text("time_s,speed_mps\n0,10\n1.5,12\n4,0\n"),
            text("t,a,b\n0,48.1,11.5\n100,48.1001,11.5\n200,48.1003,11.50001\n"),
        ],
        "bag" => vec![file("examples/lead/drive.mcap")[..2_000].to_vec()],
        "road" => vec![
            text("distance_m,height_m\n0,10\n50,11\n100,9.5\n"),
            text("distance_m,grade\n0,0.01\n50,-0.02\n"),
        ],
        "openscenario" => {
            let example = |name: &str| file(&format!("examples/openscenario/{name}.xosc"));
            // The road is the same file, so that none is named.
            let road = "<LogicFile filepath=\"./straight.xodr\"/>";
            let without_road = |name: &str| {
                let scenario = String::from_utf8(example(name)).expect("it is text");
                text(&scenario.replace(road, ""))
            };
            vec![
                without_road("cut_in"),
                without_road("joining_car"),
                example("cut_in_variation"),
                example("crossing_pedestrian"),
            ]
        }
        "opendrive" => vec![
            file("shared/openscenario/tests/roads/own.xodr"),
            file("examples/openscenario/straight.xodr"),
            file("examples/curves/two_roads.xodr"),
        ],
        "plan" => vec![
            text(
                "pieces = [{ line_m = 3000 }, { spiral_m = 80 }, { arc_m = 400, radius_m = 500, turn = \"left\" }, \
                 { spiral_m = 80 }, { line_m = 9000 }]\n",
            ),
            text(
                "generated = { seed = 1, length_km = 20, min_radius_m = 250, max_radius_m = 2000, spiral_m = [30, 200] }\n\
                 start = { x_m = 5, y_m = 7, heading_deg = 30 }\nlanes = { left = 1, right = 2, width_m = 3.5 }\n",
            ),
        ],
        "unit" => {
            let description = text(
                "<fmiModelDescription fmiVersion=\"2.0\" guid=\"1\"><CoSimulation modelIdentifier=\"unit\"/>\
                 <UnitDefinitions><Unit name=\"k\"><BaseUnit m=\"1\" s=\"-1\" factor=\"0.3\"/></Unit></UnitDefinitions>\
                 <ModelVariables><ScalarVariable name=\"v\" valueReference=\"0\" causality=\"input\"><Real unit=\"k\"/>\
                 </ScalarVariable><ScalarVariable name=\"a\" valueReference=\"1\" causality=\"output\"><Real/>\
                 </ScalarVariable></ModelVariables></fmiModelDescription>",
            );
            let unit = fmi::pack(&[("modelDescription.xml", &description)]).expect("short");
            vec![description, unit]
        }
        "design" => vec![file("shared/laws/designs/quadratic-bounded.json")],
        "link" => vec![
            text(r#"{"start":{"start_ns":12}}"#),
            text(
                r#"{"inject":{"number":1,"begin_ns":5,"fault":{"kind":"drop","topic":"v2x/spat"}}}"#,
            ),
            text(r#"{"kind":"bias","topic":"radar/tracks","field":"gap_m","amount":3}"#),
        ],
        "end_to_end" => {
            let mut message = vec![3; 120];
            messages::e2e::profile7::protect(&mut message, 7, 1);
            vec![message]
        }
        "capture" => {
            // Classic, microseconds, little-endian; one packet that is a bare frame.
            let header = [0xa1b2_c3d4, 0x0004_0002, 0, 0, 65_535, 147, 1, 0, 4, 4, 0x1111_1111];
            vec![header.iter().flat_map(|word: &u32| word.to_le_bytes()).collect()]
        }
        "recording" => {
            // A complete one of a short drive.
            let corner = Corner::new(env!("CARGO_BIN_EXE_timegap-under-test"));
            let _ =
                corner.json(&["run", "--mode", "lockstep", "--duration", "0.2", "--out", "out"]);
            let path = corner.path().join("out").join(recorder::FILE);
            vec![std::fs::read(path).expect("it was recorded")]
        }
        "frame" => {
            let corridor = builtin::find("corridor").expect("it is built in").text;
            let corridor = scenario::Scenario::parse("corridor", corridor).expect("it is right");
            let units = v2x_sim::frames::Frames::new(&corridor);
            let start_ns = scenario::radio::SIMULATED_START_NS;
            let sent = units.at(0, start_ns, None, None).expect("there is room");
            sent.into_iter().map(|frame| frame.bytes).collect()
        }
        "storyboard" => (0..20).map(|seed: u8| (0..240).map(|i: u8| i ^ seed).collect()).collect(),
        other => panic!("no example of {other}"),
    }
}

fn mutate(example: &[u8], random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = example.to_vec();
    for _ in 0..=random.next_u32() % 6 {
        let at = random.next_u32() as usize % bytes.len().max(1);
        let byte = (random.next_u32() >> 24) as u8;
        match random.next_u32() % 6 {
            0 if !bytes.is_empty() => bytes[at] = byte,
            1 if !bytes.is_empty() => bytes[at] ^= 1 << (byte % 8),
            2 => bytes.insert(at.min(bytes.len()), byte),
            3 if !bytes.is_empty() => drop(bytes.remove(at)),
            4 => bytes.truncate(at),
            // A number becomes extreme.
            _ => {
                let digit = bytes.iter().skip(at).position(u8::is_ascii_digit);
                if let Some(digit) = digit {
                    let absurd: &[&[u8]] =
                        &[b"1e308", b"-9", b"nan", b"inf", b"0", b"18446744073709551616"];
                    let absurd = absurd[random.next_u32() as usize % absurd.len()];
                    bytes.splice(at + digit..=at + digit, absurd.iter().copied());
                }
            }
        }
    }
    bytes
}

#[test]
fn no_reader_panics_on_mutated_examples() {
    let mut random = Pcg64Mcg::seed_from_u64(20_261_121);
    for target in TARGETS {
        for example in examples(target.name) {
            (target.read)(&example);
            for _ in 0..MUTATIONS {
                (target.read)(&mutate(&example, &mut random));
            }
        }
    }
}

#[test]
fn every_reader_has_its_fuzz_target() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/fuzz_targets");
    for target in TARGETS {
        let text = std::fs::read_to_string(folder.join(format!("{}.rs", target.name)));
        let text = text.unwrap_or_else(|e| panic!("{}: {e}", target.name));
        assert!(text.contains(&format!("fuzz::{}(", target.name)), "{}", target.name);
    }
}

#[test]
fn huge_deep_and_empty_documents_are_refused_in_one_error() {
    use scenario::Scenario;
    let head = "schema_version = 1\nname = \"x\"\n";
    let deep = format!("{head}controller = {}1{}", "{ a = ".repeat(10_000), " }".repeat(10_000));
    let long = format!("{head}description = \"{}\"", "x".repeat(50_000_000));
    for text in [String::new(), deep, long, format!("{head}duration_s = nan")] {
        let error = Scenario::parse("hostile.toml", &text).expect_err("it is hostile").to_string();
        assert!(error.len() < 2000 && error.contains("hostile.toml"), "{} bytes", error.len());
    }
}
