//! `docs/limits.md`: each file that it lists still has the verdict that it states.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Time with another target than the lead, s.
fn lost_s(summary: &Value) -> f64 {
    let places = summary["targets"].as_array().expect("a road with a plan");
    places.iter().map(|place| place["lost_s"].as_f64().expect("a time")).sum()
}

#[test]
fn every_listed_file_has_its_verdict() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let page = std::fs::read_to_string(docs.join("limits.md")).expect("the page");
    let corner = Corner::new(PROGRAM);
    let mut listed = BTreeSet::new();
    for row in page.lines().filter(|line| line.starts_with("| [")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let (_, link) = cells[1].split_once("](").expect("a link");
        let file = link.trim_end_matches(')');
        let path = docs.join(file).to_string_lossy().into_owned();
        let output = corner.run(&["run", &path, "--mode", "lockstep", "--in-process", "--json"]);
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        if cells[2] == "lead lost" {
            assert!(lost_s(&summary) > 1.0, "{file}: {}", summary["targets"]);
        } else {
            assert_eq!(summary["outcome"], cells[2], "{file}");
            assert_eq!(output.status.code(), Some(1), "{file}: {}", text(&output));
        }
        listed.insert(file.trim_start_matches("limits/").to_owned());
    }
    let files = std::fs::read_dir(docs.join("limits")).expect("the folder");
    let files: BTreeSet<String> = files
        .map(|file| file.expect("a file").file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(listed, files);
}
