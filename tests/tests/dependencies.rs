//! Dependencies of the workspace: licences that permit redistribution, one registry, no repository, and a
//! checksum for each package. `deny.toml` has the rules; `cargo deny` reads it too and checks advisories.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Packages with their features in the build of `arguments`, development dependencies only where `edges` has them.
fn features(edges: &str, arguments: &[&str]) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--offline", "--prefix", "none"])
        .args(["--format", "{p} [{f}]", "--edges", edges])
        .args(arguments)
        .current_dir(root())
        .output()
        .expect("cargo runs tests, so it is there");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    lines.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

/// A development dependency that adds a feature to a package makes cargo compile again all that stands above it.
#[test]
fn the_tests_use_what_the_first_command_has_compiled() {
    let first = features("normal,build", &["-p", "timegap"]);
    let tests = features("normal,build,dev", &["--workspace"]);
    // The command itself gets its studies.
    let own = |package: &&String| package.starts_with("timegap v");
    let again: Vec<_> = first.difference(&tests).filter(|it| !own(it)).collect();
    assert!(first.len() > 100, "{first:?}");
    assert!(again.is_empty(), "compiled a second time by `cargo test --workspace`: {again:#?}");
}

/// The root of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests are a folder of the workspace")
}

/// The packages in a build for this machine.
fn packages() -> Vec<Value> {
    let version = Command::new("rustc").arg("-vV").output().expect("what compiled this test");
    let version = String::from_utf8_lossy(&version.stdout).into_owned();
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).expect("a host");
    // Packages of other platforms may be missing here.
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--offline", "--format-version", "1"])
        .args(["--filter-platform", host])
        .current_dir(root())
        .output()
        .expect("cargo runs tests, so it is there");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let mut metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    match metadata["packages"].take() {
        Value::Array(packages) => packages,
        other => panic!("packages are a list: {other}"),
    }
}

/// True if the allowed licences meet a licence expression: `OR`, `AND`, `WITH`, brackets, and the old `/` for `OR`.
fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let mut words = spaced.split_whitespace().peekable();
    let ok = any_of(&mut words, allowed);
    assert_eq!(words.next(), None, "{expression}");
    ok
}

type Words<'a> = std::iter::Peekable<std::str::SplitWhitespace<'a>>;

fn any_of(words: &mut Words<'_>, allowed: &BTreeSet<String>) -> bool {
    let mut ok = all_of(words, allowed);
    while words.next_if_eq(&"OR").is_some() {
        ok |= all_of(words, allowed);
    }
    ok
}

fn all_of(words: &mut Words<'_>, allowed: &BTreeSet<String>) -> bool {
    let mut ok = one(words, allowed);
    while words.next_if_eq(&"AND").is_some() {
        ok &= one(words, allowed);
    }
    ok
}

fn one(words: &mut Words<'_>, allowed: &BTreeSet<String>) -> bool {
    let word = words.next().expect("a licence");
    if word == "(" {
        let ok = any_of(words, allowed);
        assert_eq!(words.next(), Some(")"));
        return ok;
    }
    // A licence with an exception counts as a licence of its own.
    match words.next_if_eq(&"WITH") {
        Some(_) => {
            let exception = words.next().expect("an exception");
            allowed.contains(&format!("{word} WITH {exception}"))
        }
        None => allowed.contains(word),
    }
}

#[test]
fn a_licence_expression_is_met_or_not() {
    let allowed: BTreeSet<String> = ["MIT", "ISC"].map(String::from).into();
    for (expression, ok) in [
        ("MIT", true),
        ("GPL-3.0", false),
        ("GPL-3.0/MIT", true),
        ("MIT AND GPL-3.0", false),
        ("GPL-3.0 OR MIT AND ISC", true),
        ("(GPL-3.0 OR MIT) AND BSD-2-Clause", false),
        ("ISC WITH an-exception", false),
    ] {
        assert_eq!(is_allowed(expression, &allowed), ok, "{expression}");
    }
}

#[test]
fn every_package_has_an_allowed_licence_and_comes_from_the_one_registry() {
    let rules = std::fs::read_to_string(root().join("deny.toml")).expect("it is there");
    let rules: toml::Table = toml::from_str(&rules).expect("TOML");
    let allowed: BTreeSet<String> = (rules["licenses"]["allow"].as_array().expect("a list").iter())
        .filter_map(|licence| licence.as_str().map(ToOwned::to_owned))
        .collect();
    let lock = std::fs::read_to_string(root().join("Cargo.lock")).expect("it is there");
    let lock: toml::Table = toml::from_str(&lock).expect("TOML");
    let with_checksum: BTreeSet<(&str, &str)> =
        (lock["package"].as_array().expect("a list").iter())
            .filter(|package| package.get("checksum").is_some())
            .filter_map(|package| Some((package["name"].as_str()?, package["version"].as_str()?)))
            .collect();
    let packages = packages();
    assert!(packages.len() > 100, "{}", packages.len());
    let (mut used, mut registries) = (BTreeSet::new(), BTreeSet::new());
    for package in &packages {
        let text = |key: &str| package[key].as_str();
        let (name, version) = (text("name").expect("a name"), text("version").expect("a version"));
        let licence = text("license").unwrap_or("none");
        assert!(is_allowed(licence, &allowed), "{name} {version}: {licence}");
        used.extend(allowed.iter().filter(|allowed| licence.contains(allowed.as_str())));
        // Packages of the workspace have no source.
        if let Some(source) = text("source") {
            assert!(source.starts_with("registry+"), "{name} {version}: {source}");
            assert!(with_checksum.contains(&(name, version)), "{name} {version} has no checksum");
            registries.insert(source);
        }
    }
    assert_eq!(registries.len(), 1, "{registries:?}");
    let unused: Vec<_> = allowed.iter().filter(|licence| !used.contains(licence)).collect();
    assert!(unused.is_empty(), "allowed and not needed: {unused:?}");
}
