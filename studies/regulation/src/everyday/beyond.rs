//! Scenes with something beyond a lead: what it leaves the lane for, and queues beside the lane that it drives past.

use super::{Draws, SETTLE_S, Scene, actor, queue_of};

/// Length of a lead, m.
const LEAD_LENGTH_M: f64 = 4.5;

/// A lead that leaves for the next lane, in time, before a vehicle that stands or is slow.
pub(super) fn cut_out(draws: &mut Draws) -> Scene {
    let speed_mps = draws.between(10.0, 36.0);
    let stands = draws.between(0.0, 1.0) < 0.5;
    let other_mps = if stands { 0.0 } else { draws.between(0.1, 0.5) * speed_mps };
    let leaves_in_s = draws.between(2.5, 4.5);
    let left_s = draws.between(1.0, 3.0);
    let to_m = 3.5 * draws.side();
    let first_gap_m = 2.0 * speed_mps + 6.0;
    let end_s = SETTLE_S + leaves_in_s;
    let front_m = first_gap_m + LEAD_LENGTH_M + speed_mps * end_s;
    let gap_m = front_m + left_s * (speed_mps - other_mps) - other_mps * end_s;
    let keys = format!(
        "initial_speed_mps = {speed_mps}\nlength_m = {LEAD_LENGTH_M}\n\
         lateral = [{{ time_s = {SETTLE_S}, to_m = {to_m}, duration_s = {leaves_in_s} }}]"
    );
    let mut actors = String::new();
    actor(&mut actors, "lead", first_gap_m, &keys);
    actor(&mut actors, "other", gap_m, &format!("initial_speed_mps = {other_mps}"));
    (speed_mps, speed_mps, end_s + left_s + 15.0, actors)
}

/// Queues beside the lane, behind a lead that drives past them.
pub(super) fn led_queue(draws: &mut Draws) -> Scene {
    let (speed_mps, set_mps, duration_s, mut actors) = queue_of(draws, 7);
    let gap_m = draws.between(1.5, 2.5) * speed_mps + 5.0;
    actor(&mut actors, "lead", gap_m, &format!("initial_speed_mps = {speed_mps}"));
    (speed_mps, set_mps, duration_s, actors)
}
