//! Queues where a curve begins or ends.
//!
//! | drawn | from | to |
//! | --- | --- | --- |
//! | radius, m, uniform in its logarithm | 125 | 1,000 |
//! | speed over that of 2 m/s² in the curve, at most 33 m/s | 0.7 | 1.0 |
//! | clothoid, m: in one of two curves | 30 | 100 |
//! | last vehicle of the queue behind the start of the bend, or behind its end, m | -30 | 80 |
//!
//! The queue has seven cars, 2 to 6 m apart. It stands left or right of the lane, or in it.

use super::Draws;
use super::scene::{Actor, CAR_LENGTH_M, Scene};

/// Width of a lane, m.
const LANE_M: f64 = 3.5;
/// Lateral acceleration and speed that limit the ego, m/s² and m/s.
const COMFORT_MPS2: f64 = 2.0;
const FASTEST_MPS: f64 = 33.0;
/// Way before the queue, m: beyond the radar's range.
const APPROACH_M: f64 = 220.0;
/// Bounds of the arc's length, m; it is as long as the radius within them.
const ARC_M: (f64, f64) = (180.0, 400.0);
/// Straight road behind the curve, m.
const BEHIND_M: f64 = 600.0;

/// A queue beside the ego's lane, or in it.
pub(super) fn queue(draws: &mut Draws, is_in_lane: bool) -> Scene {
    let radius_m = 125.0 * libm::pow(8.0, draws.between(0.0, 1.0));
    let speed_mps = draws.between(0.7, 1.0) * libm::sqrt(COMFORT_MPS2 * radius_m).min(FASTEST_MPS);
    let turn = if draws.side() > 0.0 { "left" } else { "right" };
    let has_spirals = draws.between(0.0, 1.0) < 0.5;
    let spiral_m = if has_spirals { draws.between(30.0, 100.0) } else { 0.0 };
    let arc_m = radius_m.clamp(ARC_M.0, ARC_M.1);
    let is_entry = draws.between(0.0, 1.0) < 0.5;
    let behind_m = draws.between(-30.0, 80.0);
    let into_m = behind_m + if is_entry { 0.0 } else { 2.0 * spiral_m + arc_m };
    let line_m = (APPROACH_M - into_m).max(60.0);
    let lane_m = if is_in_lane { 0.0 } else { LANE_M * draws.side() };
    let mut gap_m = line_m + into_m;
    let mut scene = Scene::new(speed_mps, speed_mps, 0.0);
    for number in 0..7 {
        let car = Actor::car(format!("queue-{number}"), gap_m, 0.0);
        scene.actors.push(Actor { lateral_m: lane_m + draws.between(-0.3, 0.3), ..car });
        gap_m += CAR_LENGTH_M + draws.between(2.0, 6.0);
    }
    scene.duration_s = gap_m / speed_mps + if is_in_lane { 15.0 } else { 2.0 };
    let spiral = if has_spirals { format!("{{ spiral_m = {spiral_m} }}, ") } else { String::new() };
    scene.road = format!(
        "[road.plan]\npieces = [{{ line_m = {line_m} }}, {spiral}{{ arc_m = {arc_m}, radius_m = {radius_m}, \
         turn = \"{turn}\" }}, {spiral}{{ line_m = {BEHIND_M} }}]\n"
    );
    scene
}
