//! Empty roads: nothing is there but objects beside the road, so every track in the path is wrong.

use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::tracking::numbers::Numbers;
use perception_sim::tracking::sources::Sources;
use road::Axis;
use road::random::{Recipe, pieces};
use scenario::Scenario;
use std::sync::Arc;

use super::ego;

/// Smallest and largest radius, m. The speed keeps 2 m/s² on the smallest one.
const RADII_M: [(f64, f64); 5] =
    [(30.0, 60.0), (60.0, 125.0), (125.0, 250.0), (250.0, 500.0), (500.0, 2000.0)];
/// Shortest and longest spiral as a share of the smallest radius: tight curves begin at once.
const SPIRAL: [f64; 2] = [0.3, 0.8];
const LATERAL_MPS2: f64 = 2.0;
const FASTEST_MPS: f64 = 30.0;
/// End of a road that is not driven, m.
const END_M: f64 = 200.0;

/// Counts over some way.
#[derive(Default)]
struct Wrong {
    scans: u32,
    with_a_track: u32,
    times: u32,
    km: f64,
}

/// Prints the share of the time with a track in the path, by radius.
pub fn print(
    count: u64,
    kilometres: f64,
    numbers: &Numbers,
    rows: &[(&str, Sources)],
    detections: &mut [Detection; MAX_DETECTIONS],
) {
    println!("\n{count} empty roads of {kilometres} km\n");
    println!("| sources | radii, m | speed, m/s | a track in the path, % | per km |");
    println!("| --- | --- | --- | --- | --- |");
    for (name, sources) in rows {
        for (min_radius_m, max_radius_m) in RADII_M {
            let speed_mps = (LATERAL_MPS2 * min_radius_m).sqrt().min(FASTEST_MPS);
            let spiral_m = SPIRAL.map(|share| share * min_radius_m);
            let recipe =
                Recipe { length_m: 1e3 * kilometres, min_radius_m, max_radius_m, spiral_m };
            let mut wrong = Wrong::default();
            for seed in 0..count {
                drive(&recipe, *sources, numbers, (seed, speed_mps), detections, &mut wrong);
            }
            println!(
                "| {name:10} | {min_radius_m} to {max_radius_m} | {speed_mps:.1} | {:.2} | {:.2} |",
                100.0 * f64::from(wrong.with_a_track) / f64::from(wrong.scans),
                f64::from(wrong.times) / wrong.km,
            );
        }
    }
}

/// Drives one road.
fn drive(
    recipe: &Recipe,
    sources: Sources,
    numbers: &Numbers,
    (seed, speed_mps): (u64, f64),
    detections: &mut [Detection; MAX_DETECTIONS],
    wrong: &mut Wrong,
) {
    let road = Arc::new(Axis::new(&pieces(recipe, seed)).expect("a road"));
    let text = format!(
        "schema_version = 1\nname = \"empty\"\nseed = {seed}\n\
         [plant]\ninitial_speed_mps = {speed_mps}\n"
    );
    let scenario = Scenario::parse("empty", &text).unwrap_or_else(|error| panic!("{error}"));
    let mut perception = Perception::with(&scenario, numbers).on_road(Arc::clone(&road), sources);
    let (mut was_wrong, mut way_m) = (false, 0.0);
    ego::drive(&mut perception, &road, (seed, speed_mps), &[], detections, |scan| {
        let is_wrong = scan.tracks.tracks().iter().any(|track| track.in_path);
        wrong.scans += 1;
        wrong.with_a_track += u32::from(is_wrong);
        wrong.times += u32::from(is_wrong && !was_wrong);
        (was_wrong, way_m) = (is_wrong, scan.position_m);
        way_m < road.length_m() - END_M
    });
    wrong.km += 1e-3 * way_m;
}
