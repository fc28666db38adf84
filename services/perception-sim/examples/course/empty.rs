//! Empty roads: nothing is there but objects beside the road, so every track in the path is wrong.

use messages::{Detection, MAX_DETECTIONS};
use perception_sim::perception::Perception;
use perception_sim::tracking::course_filter::Sources;
use perception_sim::tracking::course_numbers::CourseNumbers;
use perception_sim::tracking::numbers::Numbers;
use road::Axis;
use road::random::{Recipe, pieces};
use scenario::Scenario;
use std::sync::Arc;

use super::ego::Driven;

/// Smallest and largest radius, m. The speed keeps 2 m/s² on the smallest one.
const RADII_M: [(f64, f64); 5] =
    [(30.0, 60.0), (60.0, 125.0), (125.0, 250.0), (250.0, 500.0), (500.0, 2000.0)];
/// Shortest and longest spiral as a share of the smallest radius: tight curves begin at once.
const SPIRAL: [f64; 2] = [0.3, 0.8];
const LATERAL_MPS2: f64 = 2.0;
const FASTEST_MPS: f64 = 30.0;

/// Prints the share of the time with a track in the path, by radius.
pub fn print(
    count: u64,
    kilometres: f64,
    (course, tracker): (&CourseNumbers, &Numbers),
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
            let (mut scans, mut wrong, mut times, mut km) = (0, 0, 0, 0.0);
            for seed in 0..count {
                let road = Arc::new(Axis::new(&pieces(&recipe, seed)).expect("a road"));
                let scenario = Scenario::parse(
                    "empty",
                    &format!(
                        "schema_version = 1\nname = \"empty\"\nseed = {seed}\n\
                         [plant]\ninitial_speed_mps = {speed_mps}\n"
                    ),
                )
                .unwrap_or_else(|error| panic!("{error}"));
                let mut perception = Perception::with(&scenario, tracker).on_road(
                    Arc::clone(&road),
                    *sources,
                    course,
                );
                let mut ego = Driven::new(seed, speed_mps);
                let (mut was_wrong, mut here_m) = (false, 0.0);
                while here_m < road.length_m() - 200.0 {
                    let (here, in_plane) = ego.now(&road);
                    here_m = here.position_m;
                    let list = *perception.step_in_plane(
                        ego.time_ns(),
                        &here,
                        Some(here),
                        Some(in_plane),
                        None,
                        detections,
                    );
                    ego.advance(&road);
                    let is_wrong = list.tracks().iter().any(|track| track.in_path);
                    scans += 1;
                    wrong += u32::from(is_wrong);
                    times += u32::from(is_wrong && !was_wrong);
                    was_wrong = is_wrong;
                }
                km += 1e-3 * here_m;
            }
            println!(
                "| {name:10} | {min_radius_m} to {max_radius_m} | {speed_mps:.1} | {:.2} | {:.2} |",
                100.0 * f64::from(wrong) / f64::from(scans),
                f64::from(times) / km,
            );
        }
    }
}
