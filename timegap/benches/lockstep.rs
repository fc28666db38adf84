//! Lockstep runs in one process against the same runs in process groups, in one invocation.
//!
//! `cargo bench -p timegap --features studies --bench lockstep`. Both kinds of run alternate, so that both meet the same machine;
//! figures are medians. A missed goal is printed as missed and is not a failure.
//!
//! The rows of curves are the same on a straight road and on a random road of curves. Both have the radar's detections
//! and 2, 8 or 64 other vehicles. They show the cost of curves and vehicles.
//!
//! A goal per core is judged by processor time of whole commands with their start and their results. On a
//! shared machine, wall time depends on the share that a run gets.

use serde_json::Value;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap");
/// Pairs of runs.
const PAIRS: usize = 9;
/// Simulated time of each, s.
const DURATION_S: &str = "300";
/// Seeds of a command with few and with many runs; three are repeated in process groups in each.
const SEEDS: [usize; 2] = [100, 500];
/// Runs of the shorter and the longer part of the campaign `messages`.
const PARTS: [usize; 2] = [60, 460];
/// Measurements of each number of workers, in turns.
const ROUNDS: usize = 5;

/// Time of a command.
#[derive(Clone, Copy)]
struct Time {
    wall_s: f64,
    processor_s: f64,
}

/// Processor time of all ended child processes, s.
fn processor_s() -> f64 {
    /// Clock ticks of the kernel per second.
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    // Fields 16 and 17 of proc(5) after the name in parentheses, cutime and cstime.
    let (_, fields) = stat.rsplit_once(')').expect("a name");
    let fields: Vec<&str> = fields.split_whitespace().collect();
    let ticks = |index: usize| fields[index].parse::<f64>().expect("a number");
    (ticks(13) + ticks(14)) / TICKS
}

fn timegap(arguments: &[&str]) -> (Value, Time) {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let name = format!("timegap-bench-{}-{number}", std::process::id());
    let directory = std::env::temp_dir().join(name);
    let _ = std::fs::remove_dir_all(&directory);
    let (begun, processor_before_s) = (Instant::now(), processor_s());
    let output = Command::new(PROGRAM)
        .args(arguments)
        .args(["--json", "--out"])
        .arg(&directory)
        .output()
        .expect("the command starts");
    let wall_s = begun.elapsed().as_secs_f64();
    let time = Time { wall_s, processor_s: processor_s() - processor_before_s };
    let _ = std::fs::remove_dir_all(&directory);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{said}"));
    (json, time)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn verdict(met: bool) -> &'static str {
    if met { "met" } else { "MISSED" }
}

/// The other vehicles of the rows of curves.
const OTHERS: [usize; 3] = [2, 8, 64];
/// Simulated seconds per second of the loop on a road of curves with two other vehicles.
const CURVED_GOAL: f64 = 2000.0;

/// A drive of 300 s behind a lead, with further vehicles beside and behind it, before a radar with detections.
fn scene(others: usize, road: &str) -> String {
    let mut text = format!(
        "schema_version = 1\nname = \"row\"\nduration_s = {DURATION_S}\nset_speed_mps = 24\n\
         plant.initial_speed_mps = 22\nperception.radar.model = \"detections\"\n{road}"
    );
    for place in 0..others {
        let (gap_m, lateral_m) = match place {
            0 => (45.0, 0.0),
            _ => (12.0 * (place / 2) as f64, if place % 2 == 0 { -3.5 } else { 3.5 }),
        };
        text += &format!(
            "[[actors]]\nname = \"a{place}\"\ngap_m = {gap_m:?}\ninitial_speed_mps = 22\n\
             lateral_offset_m = {lateral_m:?}\n"
        );
    }
    text
}

/// The rows of curves: median speed of the loop and of the whole command.
fn curves() {
    const ROAD: &str = "[road.plan]\ngenerated = { seed = 1, length_km = 10, min_radius_m = 250, max_radius_m = 2000 }\n";
    let file = std::env::temp_dir().join(format!("timegap-bench-{}.toml", std::process::id()));
    println!("detection radar, {DURATION_S} s, medians of {ROUNDS}; simulated s per s");
    println!("                  wall, the loop   processor, all");
    let duration_s: f64 = DURATION_S.parse().expect("a number");
    for (road, name) in [("", "straight"), (ROAD, "curves")] {
        for others in OTHERS {
            std::fs::write(&file, scene(others, road)).expect("a file of our own");
            let path = file.to_str().expect("a plain name");
            let run = ["run", path, "--mode", "lockstep", "--no-record", "--in-process"];
            let (mut wall, mut processor) = (vec![], vec![]);
            for _ in 0..ROUNDS {
                let (summary, time) = timegap(&run);
                wall.push(summary["simulated_per_wall"].as_f64().expect("a speed"));
                processor.push(duration_s / time.processor_s.max(1e-3));
            }
            let (wall, processor) = (median(&mut wall), median(&mut processor));
            let row = format!("{name}, {others} others");
            let goal = match (name, others) {
                ("curves", 2) => {
                    format!("    goal {CURVED_GOAL}: {}", verdict(wall >= CURVED_GOAL))
                }
                _ => String::new(),
            };
            println!("  {row:<19}{wall:>10.0}   {processor:>14.0}{goal}");
        }
    }
    let _ = std::fs::remove_file(&file);
}

fn main() {
    let run = ["run", "cacc-a", "--mode", "lockstep", "--no-record", "--duration", DURATION_S];
    let duration_s: f64 = DURATION_S.parse().expect("a number");
    // Simulated seconds per second: of the loop by wall time, and of the command by processor time.
    let speeds = |more: &[&str]| {
        let (summary, time) = timegap(&[&run[..], more].concat());
        let by_wall = summary["simulated_per_wall"].as_f64().expect("a lockstep run has a speed");
        [by_wall, duration_s / time.processor_s.max(1e-3)]
    };
    let (mut memory, mut processes, mut ratios) =
        ([vec![], vec![]], [vec![], vec![]], [vec![], vec![]]);
    for _ in 0..PAIRS {
        let pair = (speeds(&["--in-process"]), speeds(&[]));
        for kind in 0..2 {
            memory[kind].push(pair.0[kind]);
            processes[kind].push(pair.1[kind]);
            ratios[kind].push(pair.0[kind] / pair.1[kind]);
        }
    }
    let [memory, processes, ratios] =
        [memory, processes, ratios].map(|kinds| kinds.map(|mut values| median(&mut values)));
    let met = verdict(memory[1] >= 1500.0);
    println!("cacc-a, {DURATION_S} s, {PAIRS} pairs, medians; simulated s per s");
    println!("                  wall, the loop   processor, all");
    println!("  one process     {:>14.0}   {:>14.0}    goal 1500: {met}", memory[0], memory[1]);
    println!("  process group   {:>14.0}   {:>14.0}", processes[0], processes[1]);
    println!("  ratio           {:>14.1}   {:>14.1}", ratios[0], ratios[1]);

    curves();

    // Cost of a run beside its simulated time, from runs of 2 s and 4 s. Each command repeats three runs in process
    // groups, whose start costs hundreds of times more. So the difference is due to runs in one process.
    let runs = |duration: &str, count: usize| {
        let set = format!("duration_s={duration}");
        let seeds = format!("1..{count}");
        let sweep = ["sweep", "cacc-a", "--vary", "controller.name=acc-mpc", "--set", &set];
        timegap(&[&sweep[..], &["--seeds", &seeds, "--jobs", "1"]].concat()).1.processor_s
    };
    let [few, many] = SEEDS;
    let each = |duration: &str| (runs(duration, many) - runs(duration, few)) / (many - few) as f64;
    let mut between: Vec<f64> = (0..5).map(|_| 2.0 * each("2") - each("4")).collect();
    let between_ms = median(&mut between) * 1e3;
    let met = verdict(between_ms <= 1.0);
    println!(
        "from one run to the next, processor time, median of 5\n  {between_ms:>8.2} ms    goal 1: {met}"
    );

    // Both parts have the same sample of process groups: the difference is due to runs in one process.
    let part = |jobs: &str, runs: usize| {
        let runs = runs.to_string();
        timegap(&["campaign", "messages", "--sample", &runs, "--jobs", jobs]).1
    };
    // Two commands of one worker each share only the machine: their gain is the machine's.
    let both = |runs: usize| {
        let begun = Instant::now();
        std::thread::scope(|scope| {
            scope.spawn(|| part("1", runs));
            part("1", runs);
        });
        begun.elapsed().as_secs_f64()
    };
    let [short, long] = PARTS;
    let each = |jobs: &str| {
        let (all, few) = (part(jobs, long), part(jobs, short));
        let runs = (long - short) as f64;
        [(all.wall_s - few.wall_s) / runs, (all.processor_s - few.processor_s) / runs]
    };
    // In turns, so that all meet the same machine.
    let (mut one, mut two, mut apart) = (vec![], vec![], vec![]);
    for _ in 0..ROUNDS {
        one.push(each("1"));
        two.push(each("2"));
        apart.push((both(long) - both(short)) / (2 * (long - short)) as f64);
    }
    let middle = |times: &[[f64; 2]]| {
        [0, 1].map(|kind| median(&mut times.iter().map(|time| time[kind]).collect::<Vec<f64>>()))
    };
    let (one, two, apart_s) = (middle(&one), middle(&two), median(&mut apart));
    let machine = one[0] / apart_s;
    let (all_s, gain) = (two[0] * 10_000.0, one[0] / two[0]);
    println!("campaign messages, {} runs, medians of {ROUNDS}, ms per run", long - short);
    println!("                      wall   processor");
    println!("  one worker      {:>8.2}    {:>8.2}", one[0] * 1e3, one[1] * 1e3);
    println!("  two workers     {:>8.2}    {:>8.2}", two[0] * 1e3, two[1] * 1e3);
    println!("  two commands    {:>8.2}", apart_s * 1e3);
    println!("  10,000 runs     {all_s:>8.0} s on two    goal 120: {}", verdict(all_s <= 120.0));
    println!("  commands over one {machine:>6.2}    the machine's own");
    let goal = machine.min(1.8);
    println!("  two over one    {gain:>8.2}    goal {goal:.2}: {}", verdict(gain >= goal));
}
