//! A sweep gives the same bytes each time, on any number of cores. It refuses a bad key before any run.

use rustix::process::{Pid, Signal, kill_process};
use system_tests::{Corner, csv, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// Jitter and misses of two seeds over a grid.
const GRID: [&str; 13] = [
    "sweep",
    "cut-in",
    "--duration",
    "12",
    "--vary",
    "runtime.extra_delay_ms=0..300/150",
    "--vary",
    "runtime.miss_probability=0,0.3",
    "--seeds",
    "1,2",
    "--set",
    "runtime.extra_jitter_ms=100",
    "--out",
];

fn sweep(corner: &Corner, out: &str, more: &[&str]) -> [String; 3] {
    let arguments: Vec<_> = GRID.iter().chain(&[out]).chain(more).copied().collect();
    let output = corner.run(&arguments);
    assert!(output.status.success(), "{}", text(&output));
    ["runs.csv", "sweep.json", "report.html"].map(|name| {
        std::fs::read_to_string(corner.path().join(out).join(name)).expect("a sweep writes it")
    })
}

#[test]
fn a_curve_repeats_byte_for_byte() {
    let corner = Corner::new(PROGRAM);
    let first = sweep(&corner, "a", &[]);
    assert_eq!(first, sweep(&corner, "b", &["--jobs", "1"]));
    let rows = csv_rows(&first[0]);
    assert_eq!(rows.len(), 12, "3 delays, 2 probabilities, 2 seeds");
    let mean = |keep: &dyn Fn(&[f64]) -> bool, column: usize| {
        let kept: Vec<_> = rows.iter().filter(|row| keep(row)).map(|row| row[column]).collect();
        kept.iter().sum::<f64>() / kept.len() as f64
    };
    let late = mean(&|row| row[0] == 300.0, 4);
    let prompt = mean(&|row| row[0] == 0.0, 4);
    assert!(late > prompt, "a late command costs gap error: {prompt} m, {late} m");
    assert_eq!(mean(&|row| row[1] == 0.0, 3), 0.0, "nothing is missed without misses");
    assert!(mean(&|row| row[1] == 0.3, 3) > 20.0, "0.3 of 121 commands are missed");
    corner.expect_nothing_left(&[]);
}

fn csv_rows(text: &str) -> Vec<Vec<f64>> {
    csv(
        text,
        &[
            "runtime.extra_delay_ms",
            "runtime.miss_probability",
            "seed",
            "undelivered_commands",
            "rms_gap_error_m",
        ],
    )
}

#[test]
fn bad_keys_are_refused_before_anything_runs() {
    let corner = Corner::new(PROGRAM);
    for (param, words) in [
        ("runtime.extra_delay_ms=0..200", ["no step", "KEY=A..B/STEP"]),
        ("seed=1..3/1", ["--vary seed=1..3/1", "--seeds"]),
        ("runtime.extra_delay=0..200/20", ["extra_delay", "^"]),
        ("controller.period_ms=100..125/25", ["--vary controller.period_ms=125", "multiple"]),
        ("plant.period_ms=10..-10/5", ["after its end", "KEY=A..B/STEP"]),
    ] {
        let output = corner.run(&["sweep", "cacc-a", "--vary", param]);
        assert_eq!(output.status.code(), Some(2), "{param}: {}", text(&output));
        let said = text(&output);
        assert!(words.iter().all(|word| said.contains(word)), "{param}: {said}");
    }
    assert!(!corner.path().join("runs").exists(), "nothing was begun");
}

#[test]
fn an_interrupted_sweep_keeps_what_it_has() {
    let corner = Corner::new(PROGRAM);
    let grid = ["--vary", "runtime.extra_delay_ms=0", "--seeds", "1..2000"];
    let arguments = ["sweep", "cacc-a", "--jobs", "1", "--out", "out"];
    let arguments: Vec<_> = arguments.into_iter().chain(grid).collect();
    let child = corner.start(&arguments);
    let journal = corner.path().join("out/runs.jsonl");
    let runs = || std::fs::read_to_string(&journal).unwrap_or_default().lines().count();
    assert!(wait_for(|| runs() >= 1), "no run ended");
    let pid = Pid::from_raw(i32::try_from(child.id()).expect("fits")).expect("a process id");
    kill_process(pid, Signal::INT).expect("our own child");
    let output = child.wait_with_output().expect("our own child");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output));
    let kept = std::fs::read_to_string(corner.path().join("out/runs.csv")).expect("it is kept");
    assert!((2..2000).contains(&kept.lines().count()), "{kept}");
    corner.expect_nothing_left(&[]);
}
