//! The search for failures. It finds minimal cases that repeat, continues in the same way after an interruption, and
//! makes a table of faults.

use serde_json::Value;
use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Without the emergency brake the nominal scene keeps 3.7 m. With misses of up to 60 % others keep less.
const PROBLEM: [&str; 15] = [
    "search",
    "tight-brake",
    "--set",
    "aebs.enabled=false",
    "--set",
    "duration_s=10",
    "--vary",
    "actors.0.gap_m=24..60",
    "--vary",
    "actors.0.profile.steps.0.acceleration_mps2=3..7",
    "--vary",
    "runtime.miss_probability=0..0.6",
    "--require",
    "min-gap:3.5",
    "--budget",
];

fn file(corner: &Corner, path: &str) -> String {
    std::fs::read_to_string(corner.path().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The result without the places of its files.
fn comparable(mut result: Value) -> Value {
    for failure in result["failures"].as_array_mut().into_iter().flatten() {
        failure["repeat"] = Value::Null;
    }
    result
}

#[test]
fn a_minimal_case_repeats_and_an_interrupted_search_goes_on_the_same_way() {
    let corner = Corner::new(PROGRAM);
    let search = |more: &[&str]| {
        let output = corner.run(&[&PROBLEM[..], &["40", "--cases", "1", "--json"], more].concat());
        assert_eq!(output.status.code(), Some(1), "{}", system_tests::text(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("one JSON object")
    };
    let whole = search(&["--out", "a"]);
    let failure = &whole["failures"][0];
    assert_eq!(failure["file"], "failure-1.toml");
    assert!(failure["robustness"].as_f64().is_some_and(|value| value < 0.0), "{failure}");
    let run = ["run", "a/failure-1.toml", "--mode", "lockstep", "--in-process", "--out", "r"];
    assert_eq!(corner.run(&run).status.code(), Some(1), "the case repeats");
    assert_eq!(file(&corner, "a/runs.csv").lines().count(), 41);
    // A journal that ends after 25 runs, in the middle of a half batch.
    let kept = search(&["--resume", "b"]);
    assert_eq!(comparable(kept), comparable(whole.clone()));
    let journal = file(&corner, "b/runs.jsonl");
    let begun: String = journal
        .lines()
        .filter(|line| {
            (0..40).any(|run| run < 25 && line.starts_with(&format!("{{\"run\":{run},")))
        })
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(begun.lines().count(), 25);
    std::fs::write(corner.path().join("b/runs.jsonl"), begun).expect("our own directory");
    assert_eq!(comparable(search(&["--resume", "b"])), comparable(whole));
    corner.expect_nothing_left(&[]);
}

#[test]
fn faults_are_ranked_by_what_they_break() {
    let corner = Corner::new(PROGRAM);
    let words =
        ["search", "tight-brake", "--faults", "all", "--budget", "140", "--trials", "3", "--json"];
    let output = corner.run(&words);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", system_tests::text(&output));
    let result: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let rows = result["faults"].as_array().expect("a table");
    assert!(rows.len() > 40, "{} faults", rows.len());
    let broken: Vec<bool> =
        rows.iter().map(|row| row["broken"].as_u64().is_some_and(|runs| runs > 0)).collect();
    assert!(broken.is_sorted_by(|a, b| a >= b), "what breaks comes first");
    corner.expect_nothing_left(&[]);
}

#[test]
fn trajectories_are_kept_with_the_variables() {
    let corner = Corner::new(PROGRAM);
    let output =
        corner.run(&[&PROBLEM[..], &["6", "--cases", "0", "--keep", "all", "--out", "a"]].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", system_tests::text(&output));
    let kept = std::fs::read(corner.path().join("a/trajectories.parquet")).expect("a file");
    let names = |name: &[u8]| kept.windows(name.len()).any(|bytes| bytes == name);
    assert!(kept.ends_with(b"PAR1") && names(b"actors.0.gap_m") && names(b"speed_mps"));
    let runs = file(&corner, "a/runs.csv");
    let head = runs.lines().next().expect("names");
    assert!(head.contains(",actors.0.gap_m,"), "{head}");
    let place = head.split(',').position(|name| name == "actors.0.gap_m").expect("a column");
    for line in runs.lines().skip(1) {
        let gap_m: f64 = line.split(',').nth(place).and_then(|x| x.parse().ok()).expect(line);
        assert!((24.0..=60.0).contains(&gap_m), "{line}");
    }
    assert_eq!(runs.lines().count(), 7);
}

/// No driver avoids a lead that stands a metre ahead.
#[test]
fn a_search_without_a_run_has_an_error_and_no_result() {
    let corner = Corner::new(PROGRAM);
    let words =
        ["search", "tight-brake", "--vary", "actors.0.gap_m=1..2", "--budget", "5", "--json"];
    let standing = ["--set", "actors.0.initial_speed_mps=0", "--out", "a"];
    let output = corner.run(&[&words[..], &standing].concat());
    assert_eq!(output.status.code(), Some(2), "{}", system_tests::text(&output));
    assert!(output.stdout.is_empty(), "{}", system_tests::text(&output));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("none of 10000 points"), "{said}");
    assert!(!corner.path().join("a").exists());
}

#[test]
fn a_part_of_one_process_is_refused() {
    let corner = Corner::new(PROGRAM);
    let output = corner.run(&[&PROBLEM[..], &["10", "--shard", "1/2", "--out", "a"]].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(
        system_tests::text(&output).contains("expected --replicas 2"),
        "{}",
        system_tests::text(&output)
    );
}
