//! Cost of the radar's imperfections for the tracker, and its speed behind a lead that brakes: `cargo bench -p
//! perception-sim --bench radar [-- SCENES]`.
//!
//! Every figure is of seeded scenes and the same on every machine. A scene is 10 s on a motorway: a lead, a vehicle on
//! the left and one on the right. In every second scene the right one moves into the ego's lane. GOSPA and the other
//! figures are those of `perception_sim::quality`, over the scans of all scenes.

use bytemuck::Zeroable;
use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::radar::scene::Ego;
use perception_sim::report::PerceptionReport;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use scenario::Scenario;

const SCENES: u64 = 1_000;
/// Scenes of each braking.
const STEP_SCENES: u64 = 100;
const PERIOD_NS: u64 = 50_000_000;
const SCANS: u64 = 200;
const SPEED_MPS: f64 = 25.0;

/// An imperfection and the keys that take it away.
const IMPERFECTIONS: [(&str, &[&str]); 6] = [
    ("clutter", &["false_alarms_per_scan=0", "standing_objects_per_km=0"]),
    ("ghosts", &["under_body_probability=0", "guard_rail_share=0"]),
    ("occlusion", &["hidden_loss_db=0"]),
    ("merging", &["merge=false"]),
    ("fluctuation", &["swerling=0"]),
    (
        "noise",
        &[
            "snr_at_100_m_db=60",
            "edge_loss_db=0",
            "range_floor_m=0",
            "range_rate_floor_mps=0",
            "azimuth_floor_deg=0",
        ],
    ),
];

/// The scenario of `text` with some imperfections taken away.
fn scenario(text: &str, without: impl Fn(&str) -> bool) -> Scenario {
    let mut keys = String::new();
    for (name, settings) in IMPERFECTIONS {
        if without(name) {
            let settings =
                settings.iter().map(|key| format!("perception.radar.detections.{key}\n"));
            keys.extend(settings);
        }
    }
    // Keys of a table must come before the first `[[actors]]`.
    let text = text.replacen("# keys\n", &keys, 1);
    Scenario::parse("radar bench", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// The text of a seeded scene.
fn scene(seed: u64) -> String {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| {
        let unit = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + unit * (high - low)
    };
    let mut text = format!("schema_version = 1\nname = \"scene\"\nseed = {seed}\n# keys\n");
    let mut add = |name: &str, gap_m: f64, over_mps: f64, lateral_m: f64, more: &str| {
        let speed_mps = SPEED_MPS + over_mps;
        text += &format!(
            "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m:.2}\ninitial_speed_mps = {speed_mps:.3}\n\
             lateral_offset_m = {lateral_m}\n{more}"
        );
    };
    let lorry = if between(0.0, 1.0) < 0.3 { "length_m = 16.5\n" } else { "" };
    add("lead", between(40.0, 110.0), between(-2.0, 2.0), 0.0, lorry);
    add("left", between(10.0, 100.0), between(0.0, 4.0), 3.5, "");
    let at_s = between(1.0, 6.0);
    let cut_in = format!("lateral = [{{ time_s = {at_s:.2}, to_m = 0.0, duration_s = 3.0 }}]\n");
    let moves = if seed.is_multiple_of(2) { cut_in.as_str() } else { "" };
    add("right", between(15.0, 35.0), between(-0.5, 1.0), -3.5, moves);
    text
}

/// A lead that brakes from 5 s on for 2 s.
fn braking(seed: u64, mps2: f64) -> String {
    format!(
        "schema_version = 1\nname = \"step\"\nseed = {seed}\n# keys\n[[actors]]\nname = \"lead\"\n\
         gap_m = 60\ninitial_speed_mps = {SPEED_MPS}\nprofile.piecewise = [\
         {{ time_s = 5, acceleration_mps2 = {mps2} }}, {{ time_s = 7, acceleration_mps2 = 0 }}]\n"
    )
}

fn drive(
    scenario: &Scenario,
    detections: &mut [Detection; MAX_DETECTIONS],
    mut each: impl FnMut(u64, &Perception, Option<&perception_sim::tracking::Track>),
) -> PerceptionReport {
    let mut perception = Perception::new(scenario);
    for scan in 0..SCANS {
        let time_ns = scan * PERIOD_NS;
        let position_m = SPEED_MPS * time_ns as f64 * 1e-9;
        let ego = Ego { position_m, speed_mps: SPEED_MPS, acceleration_mps2: 0.0 };
        let list = *perception.step(time_ns, &ego, detections);
        each(time_ns, &perception, list.target.map(|target| &list.tracks[target]));
    }
    perception.report()
}

/// Sums over the scenes.
#[derive(Default)]
struct Sums {
    scans: f64,
    squares: [f64; 4],
    cut_ins: u64,
    delay_s: f64,
    worst_s: f64,
    unconfirmed: u64,
    false_targets: u64,
    detections: u64,
}

impl Sums {
    fn add(&mut self, report: &PerceptionReport) {
        let scans = report.scans as f64;
        self.scans += scans;
        let parts = [report.gospa_m, report.localisation_m, report.missed_m, report.false_m];
        for (sum, part) in self.squares.iter_mut().zip(parts) {
            *sum += scans * part * part;
        }
        self.cut_ins += report.cut_ins;
        self.delay_s += report.cut_in_mean_s.unwrap_or(0.0) * report.cut_ins as f64;
        self.worst_s = self.worst_s.max(report.cut_in_worst_s.unwrap_or(f64::NEG_INFINITY));
        self.unconfirmed += report.cut_ins_unconfirmed;
        self.false_targets += report.false_targets;
        self.detections += report.detections.unwrap_or(0);
    }

    fn print(&self, name: &str) {
        let [gospa, localisation, missed, false_] =
            self.squares.map(|sum| (sum / self.scans).sqrt());
        let hours = self.scans * PERIOD_NS as f64 / 3.6e12;
        println!(
            "| {name} | {gospa:.2} | {localisation:.2} | {missed:.2} | {false_:.2} | {:.2} | {:.2} | {} of {} \
             | {:.1} | {:.0} |",
            self.delay_s / self.cut_ins.max(1) as f64,
            self.worst_s,
            self.unconfirmed,
            self.cut_ins + self.unconfirmed,
            self.false_targets as f64 / hours,
            self.detections as f64 / self.scans,
        );
    }
}

fn main() {
    let scenes = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(SCENES);
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    println!("{scenes} scenes of 10 s\n");
    println!(
        "| imperfections | GOSPA, m | localisation | missed | false | cut-in confirmed, mean s | worst \
         | not confirmed | false targets per h | detections per scan |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut row = |name: &str, without: &dyn Fn(&str) -> bool| {
        let mut sums = Sums::default();
        for seed in 0..scenes {
            let scenario = scenario(&scene(seed), without);
            sums.add(&drive(&scenario, &mut detections, |_, _, _| {}));
        }
        sums.print(name);
    };
    row("all", &|_| false);
    for (name, _) in IMPERFECTIONS {
        row(&format!("all but {name}"), &|other| other == name);
    }
    for (name, _) in IMPERFECTIONS {
        row(&format!("{name} alone"), &|other| other != name);
    }
    row("none", &|_| true);

    println!("\n{STEP_SCENES} scenes of a lead that brakes for 2 s, from 60 m and 25 m/s\n");
    println!(
        "| step, m/s² | half of it known after, mean s | worst | speed error, mean of the worst, m/s | worst \
         | gap error, mean of the worst, m | worst | target lost, scans |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for mps2 in [-3.0, -6.0, -9.0] {
        print_step(mps2, &mut detections);
    }
}

/// The tracker's answer to a braking lead.
fn print_step(mps2: f64, detections: &mut [Detection; MAX_DETECTIONS]) {
    let (mut delays, mut speeds, mut gaps, mut lost) = (Vec::new(), Vec::new(), Vec::new(), 0_u64);
    for seed in 0..STEP_SCENES {
        let scenario = scenario(&braking(seed, mps2), |_| false);
        let (mut known_s, mut speed, mut gap) = (None, 0.0_f64, 0.0_f64);
        drive(&scenario, detections, |time_ns, perception, target| {
            let time_s = time_ns as f64 * 1e-9;
            if !(5.0..8.0).contains(&time_s) {
                return;
            }
            let Some(target) = target else {
                lost += 1;
                return;
            };
            let lead = perception.vehicles()[0];
            speed = speed.max((target.relative_speed_mps - lead.speed_mps + SPEED_MPS).abs());
            gap = gap.max((target.gap_m - lead.rear_position_m + SPEED_MPS * time_s).abs());
            if known_s.is_none() && target.acceleration_mps2 <= 0.5 * mps2 {
                known_s = Some(time_s - 5.0);
            }
        });
        delays.push(known_s.unwrap_or(f64::INFINITY));
        speeds.push(speed);
        gaps.push(gap);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let worst = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    println!(
        "| {mps2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {lost} |",
        mean(&delays),
        worst(&delays),
        mean(&speeds),
        worst(&speeds),
        mean(&gaps),
        worst(&gaps),
    );
}
