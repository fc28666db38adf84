//! The size of the project: lines of source against the ceilings of `size.toml`.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde::Deserialize;

/// `size.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ceilings {
    /// Ceiling of each file of source.
    file: usize,
    /// Ceilings of each crate, and of sums and other text by the names that `.ci/lines` prints.
    lines: BTreeMap<String, usize>,
    /// Files that may be longer than `file`.
    long_files: BTreeMap<String, usize>,
}

fn ceilings() -> Ceilings {
    toml::from_str(include_str!("../size.toml")).expect("`size.toml` has the keys of `Ceilings`")
}

/// What `.ci/lines` prints: a name and its lines.
fn counted(words: &[&str]) -> BTreeMap<String, usize> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../.ci/lines");
    let output = Command::new(script).args(words).output().expect("bash and awk are there");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names of files are UTF-8");
    let row = |line: &str| {
        let (name, lines) = line.rsplit_once(' ').expect("a name and a number");
        (name.to_owned(), lines.parse().expect("a number"))
    };
    text.lines().map(row).collect()
}

#[test]
fn no_crate_is_longer_than_its_ceiling() {
    let (ceilings, counted) = (ceilings().lines, counted(&[]));
    assert!(counted.len() > 20, "the script counts: {counted:?}");
    for (name, lines) in &counted {
        let ceiling = ceilings.get(name);
        let ceiling = ceiling
            .unwrap_or_else(|| panic!("`{name}` has no ceiling in tests/size.toml: {lines} lines"));
        assert!(
            lines <= ceiling,
            "`{name}` has {lines} lines, its ceiling in tests/size.toml is {ceiling}"
        );
    }
    let gone: Vec<&String> = ceilings.keys().filter(|name| !counted.contains_key(*name)).collect();
    assert!(gone.is_empty(), "tests/size.toml has ceilings of what there is not: {gone:?}");
}

#[test]
fn no_file_is_longer_than_its_ceiling() {
    let ceilings = ceilings();
    for (name, lines) in counted(&["files"]) {
        let ceiling = *ceilings.long_files.get(&name).unwrap_or(&ceilings.file);
        assert!(lines <= ceiling, "{name} has {lines} lines of source, its ceiling is {ceiling}");
    }
}
