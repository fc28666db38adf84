//! Throughput of a search against the loop of its runs alone, in one invocation.
//!
//! `cargo bench -p timegap --features studies --bench search [-- RUNS...]`. Searches of 100, 300 and 1,000 runs, with their start, their
//! repeated runs in process groups and their results. The floor is the loop of such runs in lockstep, without what a
//! search adds: points, scenarios, summaries, requirements, records. Both are judged by processor time, since wall time
//! depends on the machine's other work. A missed goal is printed as missed and is not a failure.

use std::process::Command;
use std::time::Instant;

use frame::Command as Study;
use search::SearchArguments;
use search::problem::Problem;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap");
/// Cut-in in five dimensions, runs of 20 s.
const PROBLEM: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../studies/search/problems/cut-in-5.toml");
/// Runs of a search.
const BUDGETS: [usize; 3] = [100, 300, 1000];
/// Runs of the floor.
const FLOOR_RUNS: usize = 100;
/// Goal on two cores, runs a second.
const GOAL: f64 = 150.0;

/// Processor time of this process, and of its ended children, s.
fn processor_s() -> [f64; 2] {
    /// Clock ticks of the kernel per second.
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    // Fields 14 to 17 of proc(5) after the name in parentheses: utime, stime, cutime, cstime.
    let (_, fields) = stat.rsplit_once(')').expect("a name");
    let fields: Vec<&str> = fields.split_whitespace().collect();
    let ticks = |index: usize| fields[index].parse::<f64>().expect("a number");
    [(ticks(11) + ticks(12)) / TICKS, (ticks(13) + ticks(14)) / TICKS]
}

/// A search, and its processor time and wall time for each run, ms.
fn search(method: &str, budget: usize) -> [f64; 2] {
    let directory = std::env::temp_dir().join(format!("timegap-bench-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&directory);
    let (begun, before) = (Instant::now(), processor_s()[1]);
    let output = Command::new(PROGRAM)
        .args(["search", PROBLEM, "--method", method, "--cases", "0", "--json"])
        .args(["--budget", &budget.to_string(), "--out"])
        .arg(&directory)
        .output()
        .expect("the command starts");
    let (wall_s, processor_s) = (begun.elapsed().as_secs_f64(), processor_s()[1] - before);
    let _ = std::fs::remove_dir_all(&directory);
    assert!(!output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    [processor_s, wall_s].map(|time_s| time_s * 1e3 / budget as f64)
}

/// Processor time of the loop of a run, ms: scenes spread evenly over the box.
fn floor() -> f64 {
    let Study { study, options } =
        Study::<SearchArguments>::read(&[PROBLEM]).expect("good arguments");
    let problem = Problem::open(&study, &options.group).expect("a published problem");
    let sobol = search::method::Sobol::new(problem.dimensions(), Some(1));
    let scene = |k: usize| {
        let values = problem.values(&sobol.point(k as u64));
        problem.scenario(&values, k as u64).expect("a scene of the box")
    };
    let scenes: Vec<_> = (0..FLOOR_RUNS).map(scene).collect();
    let before = processor_s()[0];
    for scene in &scenes {
        supervise::in_process::run_watched(
            scene,
            runtime::Sealing::Unsealed,
            &|| false,
            &mut |_| {},
        )
        .expect("it runs");
    }
    (processor_s()[0] - before) * 1e3 / FLOOR_RUNS as f64
}

fn main() {
    let named: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let budgets = if named.is_empty() { BUDGETS.to_vec() } else { named };
    println!("cut-in-5, runs of 20 s; ms of processor time a run, runs a second on two cores");
    let _ = floor();
    for method in ["random", "gp"] {
        for &budget in &budgets {
            let floor_ms = floor();
            let [processor_ms, wall_ms] = search(method, budget);
            let rate = 2e3 / processor_ms;
            let met = if rate >= GOAL { "met" } else { "MISSED" };
            println!(
                "  {method:<6} {budget:>5} runs: {processor_ms:>6.2} ms, the loop alone {floor_ms:>6.2}: \
                 {:>3.0} % of its speed; {rate:>4.0} a second by processor time, goal {GOAL}: {met}; {:.0} by wall time",
                100.0 * floor_ms / processor_ms,
                1e3 / wall_ms,
            );
        }
    }
}
