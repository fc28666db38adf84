//! ASAM's own scenarios, which are not part of this repository: run where `OPENSCENARIO_FILES` names
//! folders (separated by `:`) that hold them, at any depth.

use std::path::{Path, PathBuf};

use openscenario::variation::Variation;
use openscenario::{Disk, World, read};

/// The files to be read, or none with a word about it.
fn files() -> Vec<PathBuf> {
    let Ok(folders) = std::env::var("OPENSCENARIO_FILES") else {
        // Straight to standard error, which the test harness does not hold back.
        use std::io::Write;
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: OPENSCENARIO_FILES names no folder with OpenSCENARIO files"
        );
        return Vec::new();
    };
    let mut open: Vec<PathBuf> = folders.split(':').map(PathBuf::from).collect();
    let mut files = Vec::new();
    while let Some(path) = open.pop() {
        let entries = std::fs::read_dir(&path).expect("OPENSCENARIO_FILES names readable folders");
        for entry in entries {
            let path = entry.expect("it is readable").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "xosc") {
                files.push(path);
            }
        }
    }
    files.sort();
    assert!(!files.is_empty(), "no .xosc file in {folders}");
    files
}

fn holds(path: &Path, element: &str) -> bool {
    std::fs::read_to_string(path).expect("it is readable").contains(element)
}

#[test]
fn every_scenario_runs_to_its_end() {
    for path in files().iter().filter(|path| holds(path, "<Storyboard>")) {
        let read = read::scenario(path, &Disk, &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut world =
            World::new(read.script).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let ego = world.script().ego;
        let mut motion = world.motion(ego);
        assert!(motion.present);
        let mut ended = None;
        for step in 0..60_000u64 {
            world.observe(ego, motion);
            world.step(step * 10_000_000);
            if world.is_stopped() {
                ended = Some(step as f64 * 0.01);
                break;
            }
            motion.s_m += motion.speed_mps * 0.01;
        }
        let ended = ended.unwrap_or_else(|| panic!("{}: no end in 600 s", path.display()));
        println!("{}: {ended} s, {} entities", path.display(), world.script().entities.len());
    }
}

#[test]
fn every_variation_makes_scenarios_or_breaks_a_constraint() {
    for path in files().iter().filter(|path| holds(path, "<ParameterValueDistribution>")) {
        let variation = Variation::open(path, &Disk).unwrap_or_else(|error| panic!("{error}"));
        let (mut right, mut left_out) = (0, 0);
        for index in (0..variation.len()).step_by((variation.len() / 50).max(1) | 1) {
            match read::scenario(&variation.scenario, &Disk, &variation.get(index)) {
                Ok(read) => {
                    World::new(read.script).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                    right += 1;
                }
                Err(openscenario::ReadError::Constraint { .. }) => left_out += 1,
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
