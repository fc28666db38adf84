//! Lockstep runs in one process against the same runs in process groups, in one invocation.
//!
//! `cargo bench -p timegap --bench lockstep`. Both kinds of run alternate, so that both see the same
//! machine; figures are medians. A goal that is missed is printed as missed, and is no failure.

use serde_json::Value;
use std::process::Command;
use std::time::Instant;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap");
/// Pairs of runs.
const PAIRS: usize = 9;
/// Simulated time of each, s.
const DURATION_S: &str = "300";
/// Runs of the shorter and the longer part of the campaign `messages`.
const PARTS: [usize; 2] = [60, 460];

fn timegap(arguments: &[&str]) -> (Value, f64) {
    let directory = std::env::temp_dir().join(format!("timegap-bench-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&directory);
    let begun = Instant::now();
    let output = Command::new(PROGRAM)
        .args(arguments)
        .args(["--json", "--out"])
        .arg(&directory)
        .output()
        .expect("the command starts");
    let wall_s = begun.elapsed().as_secs_f64();
    let _ = std::fs::remove_dir_all(&directory);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{said}"));
    (json, wall_s)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn verdict(met: bool) -> &'static str {
    if met { "met" } else { "MISSED" }
}

fn main() {
    let run = ["run", "cacc-a", "--mode", "lockstep", "--no-record", "--duration", DURATION_S];
    let speed = |more: &[&str]| {
        let (summary, _) = timegap(&[&run[..], more].concat());
        summary["simulated_per_wall"].as_f64().expect("a lockstep run has a speed")
    };
    let (mut memory, mut processes, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..PAIRS {
        let pair = (speed(&["--in-process"]), speed(&[]));
        memory.push(pair.0);
        processes.push(pair.1);
        ratios.push(pair.0 / pair.1);
    }
    let (memory, processes) = (median(&mut memory), median(&mut processes));
    let met = verdict(memory >= 1500.0);
    println!("cacc-a, {DURATION_S} s, {PAIRS} pairs, medians");
    println!("  one process     {memory:>8.0} simulated s per s    goal 1500: {met}");
    println!("  process group   {processes:>8.0} simulated s per s");
    println!("  ratio           {:>8.1}", median(&mut ratios));

    // The same sample of process groups is in both parts: what differs is runs in one process.
    let part = |jobs: &str, runs: usize| {
        let runs = runs.to_string();
        timegap(&["campaign", "messages", "--sample", &runs, "--jobs", jobs]).1
    };
    let [short, long] = PARTS;
    let each = |jobs: &str| {
        let mut times: Vec<f64> = (0..3)
            .map(|_| (part(jobs, long) - part(jobs, short)) / (long - short) as f64)
            .collect();
        median(&mut times)
    };
    let (one, two) = (each("1"), each("2"));
    let (all_s, gain) = (two * 10_000.0, one / two);
    println!("campaign messages, {} runs, medians of 3", long - short);
    println!("  one worker      {:>8.2} ms per run", one * 1e3);
    println!("  two workers     {:>8.2} ms per run", two * 1e3);
    println!("  10,000 runs     {all_s:>8.0} s on two    goal 120: {}", verdict(all_s <= 120.0));
    println!("  two over one    {gain:>8.2}    goal 1.8: {}", verdict(gain >= 1.8));

    // What a run costs beside its simulated time: runs of 2 s and of 4 s.
    let runs = |duration: &str| {
        let set = format!("duration_s={duration}");
        let seeds = ["sweep", "cacc-a", "--param", "controller.name=acc-mpc", "--set", &set];
        timegap(&[&seeds[..], &["--seeds", "1..400", "--jobs", "1"]].concat()).1 / 400.0
    };
    let mut between: Vec<f64> = (0..3).map(|_| 2.0 * runs("2") - runs("4")).collect();
    let between_ms = median(&mut between) * 1e3;
    let met = verdict(between_ms <= 1.0);
    println!("from one run to the next\n  {between_ms:>8.2} ms    goal 1: {met}");
}
