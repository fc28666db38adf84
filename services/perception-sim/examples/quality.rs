//! Tracks against ground truth over many seeded scenes, with and without each imperfection.
//!
//! ```sh
//! cargo run --release -p perception-sim --example quality -- [SCENES]
//! ```
//!
//! `scenes` describes the scenes. The ego sees the truth, so that all rows have the same traffic.

use bytemuck::Zeroable;
use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::radar::scene::Ego;
use perception_sim::report::PerceptionReport;

mod scenes;

use scenes::{PERIOD_NS, SCANS, follow, scene};

/// A row of the table: its name, and the keys that differ from the defaults. They are in
/// `perception.radar.detections` if they do not say otherwise.
const ROWS: [(&str, &[&str]); 11] = [
    ("all", &[]),
    ("no fluctuation", &["swerling=0"]),
    ("no occlusion", &["hidden_loss_db=0"]),
    ("no false alarms", &["false_alarms_per_scan=0"]),
    ("no roadside", &["standing_objects_per_km=0"]),
    ("no under-body echo", &["under_body_probability=0"]),
    ("no guard rail", &["guard_rail_share=0"]),
    ("all echoes resolved", &["merge=false"]),
    (
        "no receiver noise",
        &["snr_at_100_m_db=60", "range_floor_m=0", "range_rate_floor_mps=0", "azimuth_floor_deg=0"],
    ),
    (
        "none of them",
        &[
            "swerling=0",
            "hidden_loss_db=0",
            "false_alarms_per_scan=0",
            "standing_objects_per_km=0",
            "under_body_probability=0",
            "guard_rail_share=0",
            "merge=false",
            "snr_at_100_m_db=60",
            "range_floor_m=0",
            "range_rate_floor_mps=0",
            "azimuth_floor_deg=0",
        ],
    ),
    ("object-list", &["/perception.radar.model=\"object-list\""]),
];

fn main() {
    let scenes = std::env::args().nth(1).map_or(1000, |argument| {
        argument.parse().unwrap_or_else(|_| panic!("`{argument}` is not a number of scenes"))
    });
    println!("{scenes} scenes of {} s; GOSPA with c = 10 m, p = 2", SCANS / 20);
    println!(
        "{:20} {:>7} {:>7} {:>7} {:>7} | {:>7} {:>7} {:>6} {:>6} | {:>8} {:>8} | {:>5} {:>7}",
        "",
        "GOSPA",
        "local.",
        "missed",
        "false",
        "cut-in",
        "worst",
        "n",
        "unconf",
        "false/h",
        "false s",
        "det.",
        "µs/scan"
    );
    println!(
        "{:20} {:>7} {:>7} {:>7} {:>7} | {:>7} {:>7} {:>6} {:>6} | {:>8} {:>8} | {:>5} {:>7}",
        "", "m", "m", "m", "m", "s", "s", "", "", "", "per h", "", ""
    );
    for (name, keys) in ROWS {
        let row = run(scenes, keys);
        let report = &row.sum;
        let n = f64::from(scenes);
        let hours = n * SCANS as f64 * 0.05 / 3600.0;
        let rms = |sum: f64| (sum / n).sqrt();
        println!(
            "{name:20} {:7.2} {:7.2} {:7.2} {:7.2} | {:+7.2} {:+7.2} {:6} {:6} | {:8.1} {:8.1} | {:5.1} {:7.2}",
            rms(report.gospa_m),
            rms(report.localisation_m),
            rms(report.missed_m),
            rms(report.false_m),
            report.cut_in_mean_s.unwrap_or(f64::NAN) / report.cut_ins.max(1) as f64,
            report.cut_in_worst_s.unwrap_or(f64::NAN),
            report.cut_ins,
            report.cut_ins_unconfirmed,
            report.false_targets as f64 / hours,
            report.false_target_s / hours,
            report.detections.unwrap_or(0) as f64 / (n * SCANS as f64),
            row.scan_us,
        );
    }
}

/// Processor time of this process so far, s, to a hundredth.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("the kernel shows it");
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    // utime and stime, in ticks of USER_HZ = 100.
    fields[11..13].iter().map(|ticks| ticks.parse::<f64>().expect("a number") / 100.0).sum()
}

struct Row {
    /// Sums over the scenes; of squares for the four lengths.
    sum: PerceptionReport,
    scan_us: f64,
}

fn run(scenes: u32, keys: &[&str]) -> Row {
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    let mut sum = PerceptionReport::default();
    let mut spent_s = 0.0;
    for seed in 1..=scenes {
        let scenario = scene(seed, keys);
        let mut perception = Perception::new(&scenario);
        let mut ego = Ego { speed_mps: scenario.plant.initial_speed_mps.value(), ..Ego::default() };
        let began_s = processor_s();
        for k in 0..SCANS {
            perception.step(k * PERIOD_NS, &ego, &mut detections);
            ego = follow(ego, scenario.set_speed_mps.value(), perception.vehicles());
        }
        spent_s += processor_s() - began_s;
        add(&mut sum, &perception.report());
    }
    Row { sum, scan_us: 1e6 * spent_s / (f64::from(scenes) * SCANS as f64) }
}

fn add(sum: &mut PerceptionReport, one: &PerceptionReport) {
    sum.gospa_m += one.gospa_m * one.gospa_m;
    sum.localisation_m += one.localisation_m * one.localisation_m;
    sum.missed_m += one.missed_m * one.missed_m;
    sum.false_m += one.false_m * one.false_m;
    sum.cut_ins += one.cut_ins;
    sum.cut_ins_unconfirmed += one.cut_ins_unconfirmed;
    let total_s = one.cut_in_mean_s.map_or(0.0, |mean_s| mean_s * one.cut_ins as f64);
    *sum.cut_in_mean_s.get_or_insert(0.0) += total_s;
    if let Some(worst_s) = one.cut_in_worst_s {
        let so_far_s = sum.cut_in_worst_s.unwrap_or(f64::NEG_INFINITY);
        sum.cut_in_worst_s = Some(so_far_s.max(worst_s));
    }
    sum.false_targets += one.false_targets;
    sum.false_target_s += one.false_target_s;
    *sum.detections.get_or_insert(0) += one.detections.unwrap_or(0);
}
