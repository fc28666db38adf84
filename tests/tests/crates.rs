//! Rules that hold in the whole workspace: dependence points one way between its crates, and errors are
//! types.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Layers, lowest first: a crate depends on crates of lower layers alone, and the command at the top is
/// imported by none.
const LAYERS: [&[&str]; 7] = [
    &["messages", "mpc-solver", "truck-model"],
    &["scenario"],
    &["radio"],
    &["runtime"],
    &["services/"],
    &["group", "report"],
    &["tools/"],
];

/// Crates that stand in one layer and depend on each other in this order.
const WITHIN: [(&str, &str); 3] =
    [("report", "group"), ("campaign", "regulation"), ("openscenario", "random")];

fn layer(name: &str, path: &str) -> usize {
    let of = |entry: &&str| match entry.strip_suffix('/') {
        Some(folder) => path.contains(&format!("/{folder}/")),
        None => *entry == name,
    };
    let found = LAYERS.iter().position(|layer| layer.iter().any(&of));
    // A library that only services and tools use stands with the lowest ones.
    found.or(path.contains("/shared/").then_some(0)).unwrap_or(LAYERS.len())
}

#[test]
fn a_crate_depends_on_lower_layers_alone() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs tests, so it is there");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    let layers: BTreeMap<String, usize> = packages
        .iter()
        .map(|package| {
            let (name, path) = (text(&package["name"]), text(&package["manifest_path"]));
            let layer = layer(&name, &path);
            (name, layer)
        })
        .collect();
    assert!(layers.len() > 10, "{layers:?}");
    for package in packages {
        let name = text(&package["name"]);
        for dependency in package["dependencies"].as_array().expect("a list") {
            // What tests alone use does not reach the program.
            let other = text(&dependency["name"]);
            let Some(lower) = layers.get(&other).filter(|_| dependency["kind"].is_null()) else {
                continue;
            };
            assert_ne!(other, "timegap", "{name} imports the command");
            let ordered = *lower < layers[&name]
                || WITHIN.contains(&(name.as_str(), other.as_str()))
                || name == "timegap"
                || name == "system-tests";
            assert!(ordered, "{name} depends on {other}, which does not stand below it");
        }
    }
}

/// Files of Rust in the folders `src` below `folder`.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the workspace") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs")
            && path.components().any(|part| part.as_os_str() == "src")
        {
            found.push(path);
        }
    }
}

#[test]
fn no_public_function_has_a_text_for_an_error() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let mut files = Vec::new();
    for folder in ["services", "shared", "tools"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 300, "{} files", files.len());
    for path in files {
        let text = std::fs::read_to_string(&path).expect("a file of the workspace");
        for signature in text.split("pub").skip(1).filter_map(|rest| rest.split(['{', ';']).next())
        {
            let returns = signature.split_once("->").map_or("", |(_, returns)| returns);
            let is_text = returns.contains("Result<")
                && returns.trim().trim_end_matches('>').ends_with(", String");
            assert!(!is_text, "{}: pub{signature}", path.display());
        }
    }
}
