//! `timegap bench`: the form of its output, and that it leaves nothing behind. No test asserts a speed.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::collections::BTreeMap;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

fn rows<'a>(report: &'a Value, name: &str) -> &'a Vec<Value> {
    report[name].as_array().unwrap_or_else(|| panic!("no rows of {name}"))
}

/// Percentiles in order, or null as a whole.
fn assert_percentiles(value: &Value, what: &str) {
    if value.is_null() {
        return;
    }
    let order = ["p50", "p90", "p99", "p999", "p9999"].map(|p| value[p].as_f64().expect(what));
    assert!(order.windows(2).all(|pair| pair[0] <= pair[1]), "{what}: {value}");
    assert!(
        value["max"].as_f64().is_some() && value["count"].as_u64() > Some(0),
        "{what}: {value}"
    );
}

/// One slow run serves to check schema, form and saving.
#[test]
fn a_quick_bench_prints_all_its_figures() {
    let corner = Corner::new(PROGRAM);
    let quick = ["bench", "--quick", "--seconds", "0.1", "--save", "base.json", "--out", "out"];
    // A busy machine may miss a goal, with status 1.
    let output = corner.run(&[&quick[..], &["--json"]].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let missed = rows(&report, "goals").iter().any(|goal| goal["verdict"] == "missed");
    assert_eq!(output.status.code(), Some(i32::from(missed)), "a missed goal is status 1");
    assert_eq!(report["schema_version"], 1);
    assert_eq!(system_tests::schema::check(&corner.schemas()["bench"], &report), [""; 0]);
    let cores = report["host"]["cpus"].as_u64().expect("counted");
    let refused = !rows(&report, "refused").is_empty();

    let floor = &report["floor"];
    for name in ["futex_us", "eventfd_us", "iceoryx2_event_us"] {
        for placement in ["same_core", "two_cores"] {
            let figure = &floor[name][placement];
            assert_percentiles(figure, name);
            let missing = figure.is_null();
            assert!(!missing || refused || (cores < 2 && placement == "two_cores"), "{name}");
        }
    }
    assert_percentiles(&floor["sleep_jitter_us"], "sleep_jitter_us");

    for row in rows(&report, "transport_us") {
        assert_percentiles(&row["us"], "transport");
        assert!(row["bytes"].as_u64() > Some(0) && row["period_us"].as_u64() > Some(0), "{row}");
        let conditions = ["placement", "scheduling", "load"].map(|key| row[key].as_str());
        assert!(conditions.iter().all(Option::is_some), "{row}");
    }
    let here = |passing: &'static str| {
        let rows = rows(&report, "transport_us").iter();
        rows.filter(move |row| row["passing"] == passing && row["placement"] == "same_core")
    };
    let loaned: Vec<_> = here("bare").map(|row| row["bytes"].as_u64().expect("a size")).collect();
    assert_eq!((loaned.first(), loaned.last()), (Some(&64), Some(&(4 << 20))));
    assert!(here("bare").all(|row| row["copied_bytes"] == 0.0), "borrowed");
    // A small message is copied once, before its check.
    assert!(here("message").all(|row| row["copied_bytes"].as_f64() == row["bytes"].as_f64()));

    // Chains and deadlines come from the same runs.
    let (chains, deadlines) = (rows(&report, "chain"), rows(&report, "deadlines"));
    assert_eq!(chains.len(), deadlines.len());
    for period_ms in [100, 10, 1] {
        let here = deadlines.iter().any(|row| row["period_us"] == period_ms * 1000);
        assert!(here, "no deadlines at {period_ms} ms");
    }
    for (chain, deadline) in chains.iter().zip(deadlines) {
        assert_eq!(chain["period_us"], deadline["period_us"]);
        if let Some(cycles) = deadline["cycles"].as_u64() {
            assert!(deadline["misses"].as_u64().expect("counted") <= cycles, "{deadline}");
            let floor_cycles = deadline["floor_cycles"].as_u64().expect("counted");
            assert!(deadline["floor_misses"].as_u64().expect("counted") <= floor_cycles);
        }
        let count = &chain["reaction_time_us"]["count"];
        for figure in ["designed_wait_us", "net_reaction_us"] {
            assert_eq!(&chain[figure]["count"], count, "{chain}");
        }
        for (hop, percentiles) in chain["hops_us"].as_object().expect("hops") {
            assert_percentiles(percentiles, hop);
            assert_eq!(&percentiles["count"], count, "{hop}");
        }
    }
    for goal in rows(&report, "goals") {
        let limit = goal["limit"].as_f64().expect("a number");
        let [low, high] = [0, 1].map(|end| goal["ci95"][end].as_f64().unwrap_or(f64::INFINITY));
        assert!(low <= high, "{goal}");
        let none_missed = goal["ours"] == 0.0;
        let expected = match () {
            () if high <= limit || none_missed => "met",
            () if low > limit => "missed",
            () => "undecided",
        };
        assert_eq!(goal["verdict"], expected, "{goal}");
        assert!(goal["n"].as_u64() > Some(0) && goal["caveats"].is_array(), "{goal}");
        let name = goal["name"].as_str().expect("a name");
        assert!(!name.ends_with("p99"), "a quick run judges no 99th percentile: {name}");
    }
    let itself = rows(&report, "goals").iter().filter(|goal| {
        goal["name"].as_str().is_some_and(|name| name.starts_with("control: futex"))
    });
    for goal in itself.clone() {
        assert_ne!(goal["verdict"], "missed", "no difference where there is none: {goal}");
    }
    assert!(itself.count() >= 1, "the floor against itself is always a row");

    // Each measured figure has a histogram, in a file that other tools read.
    let log = std::fs::read_to_string(corner.path().join("out/histograms.hlog")).expect("written");
    let lines: Vec<_> = log.lines().filter(|line| line.starts_with("Tag=")).collect();
    assert!(lines.len() > loaned.len() && lines.iter().all(|line| line.contains(",HISTFAAA")));

    let saved: Value = serde_json::from_slice(
        &std::fs::read(corner.path().join("base.json")).expect("--save wrote it"),
    )
    .expect("one JSON object");
    assert_eq!(saved, report);
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_file_that_is_not_a_baseline_is_refused_before_anything_runs() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("base.json"), "{\"floor\": 1}").expect("our own corner");
    for file in ["base.json", "missing.json"] {
        let output = corner.run(&["bench", "--quick", "--against", file]);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(file), "{}", text(&output));
        assert!(!corner.path().join("runs").exists(), "nothing ran");
    }
}

#[test]
fn nothing_outlives_a_bench_that_is_killed_or_interrupted() {
    for (signal, status) in [(Signal::KILL, None), (Signal::INT, Some(130))] {
        let corner = Corner::new(PROGRAM);
        let child = corner.start(&["bench", "--quick", "--seconds", "5", "--out", "out"]);
        let _ = corner.wait_for_process("timegap-bench");
        let roots = corner.roots();
        let pid = Pid::from_raw(i32::try_from(child.id()).expect("fits")).expect("a process id");
        kill_process(pid, signal).expect("our own process, not yet waited for");
        let output = child.wait_with_output().expect("our own child");
        assert_eq!(output.status.code(), status, "{}", text(&output));
        assert!(wait_for(|| corner.processes().is_empty()), "{:?}", corner.processes());
        corner.expect_nothing_left(&roots);
    }
}

/// Compiles one file repeatedly until it is stopped, like other work on a developer's machine.
fn compile(directory: &std::path::Path, stop: &AtomicBool) -> u32 {
    let file = directory.join("busy.rs");
    let functions: String = (0..400)
        .map(|k| format!("pub fn f{k}(v: &[f64]) -> f64 {{ v.iter().map(|x| x * {k}.5).sum() }}\n"))
        .collect();
    std::fs::write(&file, functions).expect("our own corner");
    let mut compiled = 0;
    while !stop.load(Ordering::Relaxed) {
        let status = Command::new("rustc")
            .args(["--crate-type=rlib", "-O", "-o", "busy.rlib", "busy.rs"])
            .current_dir(directory)
            .status();
        assert!(status.expect("rustc is there").success());
        compiled += 1;
    }
    compiled
}

#[test]
#[ignore = "ten minutes: run it with --ignored"]
fn ten_runs_beside_a_compile_job_contradict_each_other_in_no_goal() {
    let corner = Corner::new(PROGRAM);
    let stop = AtomicBool::new(false);
    let mut verdicts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    std::thread::scope(|scope| {
        let load = scope.spawn(|| compile(corner.path(), &stop));
        for run in 0..10 {
            let out = format!("out-{run}");
            let output = corner.run(&["bench", "--quick", "--json", "--out", &out]);
            let report: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
            for goal in rows(&report, "goals") {
                let text = |key: &str| goal[key].as_str().expect("a word").to_owned();
                let name = format!("{}, {}", text("name"), text("placement"));
                verdicts.entry(name).or_default().push(text("verdict"));
            }
        }
        stop.store(true, Ordering::Relaxed);
        assert!(load.join().expect("no panic") > 0, "nothing was compiled meanwhile");
    });
    for (goal, found) in &verdicts {
        println!("{goal}: {}", found.join(" "));
    }
    for (goal, found) in verdicts {
        let has = |verdict: &str| found.iter().any(|found| found == verdict);
        assert!(!(has("met") && has("missed")), "{goal}: {found:?}");
        assert!(!goal.starts_with("control: futex") || !has("missed"), "{goal}: {found:?}");
    }
}
