//! Dependence points one way between the crates of this workspace.

use serde_json::Value;
use std::collections::BTreeMap;
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
