//! ASAM's scenarios for UN R157, which are not part of this repository. The test runs if `OPENSCENARIO_FILES`
//! names folders with them, separated by `:`, at any depth.

use openscenario::variation::Variation;
use openscenario::{Choices, Disk, ReadError, World, read};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use system_tests::cases::{self, Needed, needing};
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const STEP_NS: u64 = 10_000_000;
const LONGEST_STEPS: u64 = 60_000;

fn folders() -> Needed {
    match std::env::var("OPENSCENARIO_FILES") {
        Ok(_) => Ok(()),
        Err(_) => Err("OPENSCENARIO_FILES names no folder with OpenSCENARIO files".into()),
    }
}

/// Files with `element`: at least one.
fn files(element: &str) -> Vec<PathBuf> {
    let folders = std::env::var("OPENSCENARIO_FILES").expect("it was looked for");
    let mut open: Vec<PathBuf> = folders.split(':').map(PathBuf::from).collect();
    let mut files = Vec::new();
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(&path).expect("OPENSCENARIO_FILES names readable folders") {
            let path = entry.expect("it is readable").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "xosc") {
                files.push(path);
            }
        }
    }
    files.retain(|path| std::fs::read_to_string(path).expect("it is readable").contains(element));
    files.sort();
    assert!(!files.is_empty(), "no .xosc file with {element} in {folders}");
    files
}

/// Reads and moves one scenario; returns its end, s.
fn end_of(path: &Path) -> Option<f64> {
    let read =
        read::scenario(path, &Disk, &Choices::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(read.script).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let ego = world.script().ego;
    let mut motion = world.motion(ego);
    assert!(motion.present);
    (0..LONGEST_STEPS).find_map(|step| {
        world.observe(ego, motion);
        world.step(step * STEP_NS);
        motion.s_m += motion.speed_mps * 0.01;
        world.is_stopped().then_some(step as f64 * 0.01)
    })
}

fn alks_scenarios_end() {
    for path in files("<Storyboard>") {
        let end = end_of(&path).unwrap_or_else(|| panic!("{}: no end in 600 s", path.display()));
        println!("{}: {end} s", path.display());
    }
}

fn alks_variations_make_scenarios() {
    for path in files("<ParameterValueDistribution>") {
        let variation = Variation::open(&path, &Disk).unwrap_or_else(|error| panic!("{error}"));
        let (mut right, mut left_out) = (0, 0);
        for index in (0..variation.len()).step_by((variation.len() / 50).max(1) | 1) {
            let choices = Choices { assigned: variation.get(index), ..Choices::default() };
            match read::scenario(&variation.scenario, &Disk, &choices) {
                Ok(read) => {
                    World::new(read.script).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                    right += 1;
                }
                Err(ReadError::Constraint { .. }) => left_out += 1,
                Err(error) => panic!("{error}"),
            }
        }
        println!(
            "{}: {} combinations; of a sample {right} right, {left_out} left out",
            path.display(),
            variation.len()
        );
        assert!(right > 0);
    }
}

fn alks_scenarios_are_driven() {
    let corner = Corner::new(PROGRAM);
    for path in files("<Storyboard>") {
        let output = corner.run(&["run", &path.to_string_lossy(), "--mode", "lockstep", "--json"]);
        if text(&output).contains(": the story of ") {
            assert_eq!(output.status.code(), Some(1));
            println!("{}: {}", path.display(), text(&output));
            continue;
        }
        let summary: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| panic!("{}: {}", path.display(), text(&output)));
        println!("{}: {} after {} s", path.display(), summary["outcome"], summary["duration_s"]);
    }
}

fn main() -> ExitCode {
    cases::run(&[
        needing(folders, "alks_scenarios_end", alks_scenarios_end),
        needing(folders, "alks_variations_make_scenarios", alks_variations_make_scenarios),
        needing(folders, "alks_scenarios_are_driven", alks_scenarios_are_driven),
    ])
}
