//! Recorded leads: the examples, a run behind one, and bad files.

use serde_json::Value;
use std::path::Path;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const COLUMNS: [&str; 2] = ["--columns", "t=stamp_ms:ms, v=speed_kmh:km/h"];

fn example(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/lead");
    folder.join(name).display().to_string()
}

fn lead(corner: &Corner, file: &str, more: &[&str]) -> Value {
    let arguments = [&["recording", "lead", file, "--json"], more].concat();
    let output = corner.run(&arguments);
    assert!(output.status.success(), "{}", text(&output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn the_filter_takes_the_noise_and_keeps_the_stops() {
    let corner = Corner::new(PROGRAM);
    let raw = lead(&corner, &example("drive.csv"), &[&COLUMNS[..], &["--offset-s", "0"]].concat());
    let hardest = raw["hardest_recorded"]["acceleration_mps2"].as_f64().expect("a number");
    assert!(hardest.abs() > 6.0 && raw["notes"][0].as_str().expect("a note").contains("smooth_s"));
    let smooth = ["--offset-s", "0", "--smooth-s", "1", "--page", "lead.html"];
    let smooth = lead(&corner, &example("drive.csv"), &[&COLUMNS[..], &smooth].concat());
    let hardest = smooth["hardest_read"]["acceleration_mps2"].as_f64().expect("a number");
    assert!(hardest.abs() < 4.0, "{smooth}");
    assert_eq!(smooth["notes"], serde_json::json!([]));
    assert_eq!(smooth["stops"].as_array().map(Vec::len), Some(3), "{smooth}");
    let driven = |of: &Value| of["distance_m"].as_f64().expect("a number");
    assert!((driven(&raw) - driven(&smooth)).abs() < 0.02 * driven(&raw), "{raw} {smooth}");
    let page = std::fs::read_to_string(corner.path().join("lead.html")).expect("a page");
    assert!(page.contains("as recorded"));
}

#[test]
fn a_bag_gives_the_same_drive_as_the_table() {
    let corner = Corner::new(PROGRAM);
    let list = lead(&corner, &example("drive.mcap"), &[]);
    assert_eq!(list["topics"][0]["name"], "/gps/velocity");
    let fields = list["topics"][0]["fields"].as_array().expect("fields");
    assert!(fields.iter().any(|field| field == "twist.linear.x"), "{list}");
    let topic = ["--topic", "/gps/velocity", "--columns", "t=header.stamp, v=twist.linear.x"];
    let bag = lead(&corner, &example("drive.mcap"), &topic);
    let table = [&COLUMNS[..], &["--offset-s", "0"]].concat();
    let table = lead(&corner, &example("drive.csv"), &table);
    let driven = |of: &Value| of["distance_m"].as_f64().expect("a number");
    assert!((driven(&bag) - driven(&table)).abs() < 0.01 * driven(&table), "{bag} {table}");
    let step_s = bag["median_step_s"].as_f64().expect("a number");
    assert!((step_s - 0.2).abs() < 1e-6, "{bag}");
}

#[test]
fn a_car_drives_behind_the_record() {
    let corner = Corner::new(PROGRAM);
    let scenario = example("drive.toml");
    let summary = corner.json(&["run", &scenario, "--mode", "lockstep", "--in-process"]);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    assert!(summary["control"]["min_gap_m"].as_f64().expect("a gap") > 1.0, "{summary}");
    // Two vehicles of one file.
    let two = format!("{{csv={{file=\"{}\",rows=\"car=second\"}}}}", example("two-cars.csv"));
    let set = format!("actors[0].profile={two}");
    let arguments = ["run", &scenario, "--mode", "lockstep", "--in-process", "--set", &set];
    assert_eq!(corner.json(&arguments)["outcome"], "completed");
}

#[test]
fn bad_files_and_options_end_with_status_2_and_one_error() {
    let corner = Corner::new(PROGRAM);
    let write = |name: &str, text: &str| {
        std::fs::write(corner.path().join(name), text).expect("the corner is writable");
    };
    write("names.csv", "t,v\n0,1\n");
    write("back.csv", "time_s,speed_mps\n0,1\n1,1\n0.5,1\n");
    write("nan.csv", "time_s,speed_mps\n0,1\n1,nan\n");
    write("cut.mcap", "\u{89}MCAP0\r\n");
    let mcap = example("drive.mcap");
    let cases: [(&[&str], &str); 9] = [
        (&["names.csv"], "--columns: names.csv has no columns `time_s,speed_mps`"),
        (&["names.csv", "--columns", "t=t, v=v:kmh"], "did you mean `km/h`?"),
        (&["back.csv"], "back.csv:4:1: times must increase"),
        (&["nan.csv"], "nan.csv:3:3: NaN is out of range"),
        (&["absent.csv"], "absent.csv: cannot be opened"),
        (&["cut.mcap", "--topic", "/a", "--columns", "v=b"], "cut.mcap"),
        (&[&mcap, "--topic", "/gps", "--columns", "v=b"], "expected one of `/gps/velocity`"),
        (&[&mcap, "--topic", "/gps/velocity", "--columns", "v=fast"], "`twist.linear.x`"),
        (&["names.csv", "--smooth-s", "-1"], "a time constant from 0.001 to 100 s"),
    ];
    for (arguments, expected) in cases {
        let output = corner.run(&[&["recording", "lead"][..], arguments].concat());
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert_eq!(said.matches("error:").count(), 1, "{said}");
    }
    // In a scenario the option or the line is shown.
    let scenario = example("drive.toml");
    for (set, expected) in [
        ("actors[0].profile.csv.columns=\"t=stamp_ms:h, v=speed_kmh\"", "unknown unit `h`"),
        ("actors[0].profile.csv.offset_s=90", "the record ends 30.1 s before the run begins"),
        ("actors[0].profile.csv.max_gap_s=0.01", "drive.csv:3:1: a gap of 0.10 s"),
        ("actors[0].profile.csv.rows=\"car=first\"", "no column `car`"),
    ] {
        let output = corner.run(&["run", &scenario, "--set", set]);
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{set}: {said}");
        assert!(said.contains(expected), "{set}: {said}");
    }
}
