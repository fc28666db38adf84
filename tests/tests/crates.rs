//! Rules for the whole workspace. Dependence points one way between its crates and between the files of each, and
//! errors are types.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Layers, lowest first. A crate depends on crates of lower layers only; only the tests import the
/// command at the top.
const LAYERS: [&[&str]; 11] = [
    &["bags", "fmi", "messages", "mpc-solver", "sumo", "truck-model"],
    &["scenario"],
    &["law", "radio"],
    &["laws", "runtime"],
    &["services/"],
    &["drive"],
    &["supervise", "report"],
    // Tools that run one group do not depend on studies.
    &["tools/"],
    // So do links to other people's tools.
    &["links/"],
    // Mathematics that studies alone use stands beside their frame.
    &["frame", "gaussian-process", "rare-events"],
    &["studies/"],
];

/// Crates of one layer that depend on each other in this order.
const WITHIN: [(&str, &str); 11] = [
    ("fmi", "messages"),
    ("fmi", "openscenario"),
    ("report", "supervise"),
    ("openscenario", "random"),
    ("openscenario", "road"),
    ("road", "random"),
    ("bench", "doctor"),
    ("sumo", "messages"),
    ("sumo", "openscenario"),
    ("sumo", "road"),
    // The simulated vehicles have the ego's on-board unit.
    ("v2x-sim", "obu"),
];

/// Layer of a crate. `path` is that of its manifest below the workspace's folder.
fn layer(name: &str, path: &str) -> usize {
    let of = |entry: &&str| match entry.strip_suffix('/') {
        Some(folder) => path.starts_with(&format!("/{folder}/")),
        None => *entry == name,
    };
    let found = LAYERS.iter().position(|layer| layer.iter().any(&of));
    // A library for services and tools belongs to the lowest layer.
    found.or(path.starts_with("/shared/").then_some(0)).unwrap_or(LAYERS.len())
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
    let root = text(&metadata["workspace_root"]);
    let layers: BTreeMap<String, usize> = packages
        .iter()
        .map(|package| {
            let (name, path) = (text(&package["name"]), text(&package["manifest_path"]));
            let layer = layer(&name, path.strip_prefix(&root).expect("it is below"));
            (name, layer)
        })
        .collect();
    assert!(layers.len() > 10, "{layers:?}");
    for package in packages {
        let name = text(&package["name"]);
        for dependency in package["dependencies"].as_array().expect("a list") {
            // Dev-dependencies do not reach the program.
            let other = text(&dependency["name"]);
            let Some(lower) = layers.get(&other).filter(|_| dependency["kind"].is_null()) else {
                continue;
            };
            let is_test = name == "system-tests";
            assert!(other != "timegap" || is_test, "{name} imports the command");
            let ordered = *lower < layers[&name]
                || WITHIN.contains(&(name.as_str(), other.as_str()))
                || name == "timegap"
                || is_test;
            assert!(ordered, "{name} depends on {other}, which does not stand below it");
        }
    }
}

/// Rust files in the folders `src` below `folder`.
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
    for folder in ["links", "python", "services", "shared", "studies", "tests", "timegap", "tools"]
    {
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

/// Modules of a crate by path, with the imports of each: a name and its path.
type Modules = BTreeMap<Vec<String>, Vec<(String, Vec<String>)>>;

/// The module of a file below `src`: `a/b.rs` and `a/b/mod.rs` are `[a, b]`.
fn module(file: &Path) -> Vec<String> {
    let mut path: Vec<String> =
        file.iter().map(|part| part.to_string_lossy().trim_end_matches(".rs").to_owned()).collect();
    if path.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
        path.pop();
    }
    path
}

/// The paths of a `use` tree such as `a::{b, c::{d, e as f}}`, each with its local name.
fn flat(tree: &str, before: &[String], paths: &mut Vec<(String, Vec<String>)>) {
    let (mut depth, mut begin) = (0, 0);
    for (place, letter) in tree.char_indices().chain([(tree.len(), ',')]) {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let part = tree[begin..place].trim();
                begin = place + 1;
                let (head, inner) = part.split_once('{').unwrap_or((part, ""));
                let (head, name) = head.split_once(" as ").unwrap_or((head, ""));
                let mut path = before.to_vec();
                path.extend(
                    head.split("::").map(str::trim).filter(|s| !s.is_empty()).map(Into::into),
                );
                if let Some(inner) = inner.strip_suffix('}') {
                    flat(inner, &path, paths);
                } else if let Some(last) = path.last().cloned() {
                    let name = if name.is_empty() { last } else { name.trim().to_owned() };
                    paths.push((name, path));
                }
            }
            _ => {}
        }
    }
}

/// The paths from the crate's root that `module` imports from its own crate.
fn imports(text: &str, module: &[String], known: &Modules) -> Vec<(String, Vec<String>)> {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let mut paths = Vec::new();
    for statement in code.split(';') {
        let statement = statement.trim_start();
        let line =
            statement.rfind("\nuse ").or(statement.rfind("\npub use ")).map_or(0, |at| at + 1);
        if let Some((head, tree)) = statement[line..].split_once("use ")
            && (head.is_empty() || head.starts_with("pub"))
        {
            flat(&tree.replace('\n', " "), &[], &mut paths);
        }
    }
    let own = |(name, path): (String, Vec<String>)| {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let mut from_root = match path[0].as_str() {
            "crate" => Vec::new(),
            "self" | "super" => module[..module.len().checked_sub(supers)?].to_vec(),
            first => {
                let child = [module, &[first.to_owned()]].concat();
                known.contains_key(&child).then_some(module.to_vec())?
            }
        };
        let skipped = if path[0] == "crate" || path[0] == "self" { 1 } else { supers };
        from_root.extend_from_slice(&path[skipped..]);
        Some((name, from_root))
    };
    paths.into_iter().filter_map(own).collect()
}

/// The module that defines the item at `path`, through re-exports.
fn defined_in(path: &[String], known: &Modules, hops: usize) -> Option<Vec<String>> {
    let length = (0..=path.len()).rev().find(|length| known.contains_key(&path[..*length]))?;
    let module = path[..length].to_vec();
    let handed_on = path.get(length).and_then(|name| {
        known[&module].iter().find(|(given, _)| given == name).map(|(_, from)| from)
    });
    match handed_on {
        Some(from) if hops > 0 && from != path => {
            let rest = [from, &path[length + 1..]].concat();
            defined_in(&rest, known, hops - 1)
        }
        _ => Some(module),
    }
}

#[test]
fn no_modules_side_by_side_import_each_other_in_a_circle() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let (mut arrows, mut circles) = (0, Vec::new());
    for folder in ["links", "services", "shared", "studies", "tools"] {
        for entry in std::fs::read_dir(root.join(folder)).expect("a folder of the workspace") {
            let source = entry.expect("an entry").path().join("src");
            let mut files = Vec::new();
            sources(&source, &mut files);
            // A program beside a library only calls it.
            let is_library = source.join("lib.rs").exists();
            files.retain(|file| !is_library || *file != source.join("main.rs"));
            let texts: BTreeMap<Vec<String>, String> = files
                .iter()
                .map(|file| {
                    let below = file.strip_prefix(&source).expect("it is below");
                    (module(below), std::fs::read_to_string(file).expect("a file of the workspace"))
                })
                .collect();
            let names: Modules = texts.keys().map(|module| (module.clone(), Vec::new())).collect();
            let known: Modules = texts
                .iter()
                .map(|(module, text)| (module.clone(), imports(text, module, &names)))
                .collect();
            let of = |module: &Vec<String>| -> Vec<Vec<String>> {
                let own = texts[module].split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
                let used =
                    |(name, _): &&(String, Vec<String>)| own.matches(name.as_str()).count() > 1;
                let paths = known[module].iter().filter(used);
                let found = paths.filter_map(|(_, path)| defined_in(path, &known, 5));
                // A module and its submodules count as one.
                let is_elsewhere =
                    |other: &Vec<String>| !module.starts_with(other) && !other.starts_with(module);
                found.filter(is_elsewhere).collect()
            };
            let mut graph: BTreeMap<_, _> = texts.keys().map(|m| (m.clone(), of(m))).collect();
            arrows += graph.values().map(Vec::len).sum::<usize>();
            // Modules without remaining imports are in no cycle.
            loop {
                let free: Vec<_> =
                    graph.iter().filter(|(_, to)| to.is_empty()).map(|(m, _)| m.clone()).collect();
                if free.is_empty() {
                    break;
                }
                for module in &free {
                    graph.remove(module);
                }
                for to in graph.values_mut() {
                    to.retain(|other| !free.contains(other));
                }
            }
            if !graph.is_empty() {
                circles.push(format!("{}: {graph:?}", source.display()));
            }
        }
    }
    assert!(arrows > 500, "{arrows} imports were seen");
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}
