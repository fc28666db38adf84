//! Drives among vehicles that change lanes or stand beside the lane.

use std::fmt::Write;

use super::Draws;
use super::vehicles::{actor, head, led};

/// Lane width, m.
const LANE_M: f64 = 3.5;

/// A vehicle that comes in from a neighbouring lane: its speed, the gap at its entry, and its motion after it.
fn comes_in(draws: &mut Draws, speed_mps: f64, other_mps: f64, gap_m: f64, brakes: bool) -> String {
    let (begins_s, takes_s) = (draws.between(3.0, 15.0), draws.between(1.5, 6.0));
    let in_s = begins_s + takes_s;
    let start_m = (gap_m + (speed_mps - other_mps) * in_s).max(0.0);
    let mut keys = format!(
        "initial_speed_mps = {other_mps:.2}\nlateral_offset_m = {:.2}\n\
         lateral = [{{ time_s = {begins_s:.2}, to_m = 0, duration_s = {takes_s:.2} }}]",
        draws.side() * LANE_M
    );
    if brakes {
        write!(
            keys,
            "\nprofile.steps = [{{ time_s = {:.2}, speed_mps = {:.2}, acceleration_mps2 = {:.2} }}]",
            in_s + draws.between(0.0, 3.0),
            other_mps * draws.between(0.0, 0.7),
            draws.between(0.5, 3.0)
        )
        .expect("a string takes all");
    }
    let mut text = head(draws, in_s + 25.0, speed_mps, speed_mps + 1.0);
    actor(&mut text, "other", start_m, &keys);
    text
}

pub fn cut_in(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 34.0);
    let other_mps = (speed_mps - draws.between(-2.0, 6.0)).max(3.0);
    let gap_m = 3.0 + draws.between(0.8, 2.5) * speed_mps;
    let brakes = draws.chance(0.4);
    comes_in(draws, speed_mps, other_mps, gap_m, brakes)
}

pub fn pulls_away(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 30.0);
    let other_mps = speed_mps + draws.between(2.0, 8.0);
    let gap_m = draws.between(6.0, 25.0) + 0.3 * speed_mps;
    // A faster vehicle comes from behind: it appears beside the ego, so its gap grows from the start.
    let (appears_s, takes_s) = (draws.between(2.0, 12.0), draws.between(1.5, 4.0));
    let keys = format!(
        "initial_speed_mps = {other_mps:.2}\nlateral_offset_m = {:.2}\nappears_at_s = {appears_s:.2}\n\
         lateral = [{{ time_s = {:.2}, to_m = 0, duration_s = {takes_s:.2} }}]",
        draws.side() * LANE_M,
        appears_s + 1.0
    );
    let mut text = head(draws, appears_s + 25.0, speed_mps, speed_mps + 2.0);
    actor(&mut text, "other", gap_m, &keys);
    text
}

pub fn cut_out(draws: &mut Draws) -> String {
    let speed_mps = draws.between(10.0, 30.0);
    let gap_m = 4.0 + 1.8 * speed_mps;
    let (begins_s, takes_s) = (draws.between(10.0, 20.0), draws.between(1.5, 4.0));
    let keys = format!(
        "initial_speed_mps = {speed_mps:.2}\n\
         lateral = [{{ time_s = {begins_s:.2}, to_m = {:.2}, duration_s = {takes_s:.2} }}]",
        draws.side() * LANE_M
    );
    let slow_mps = if draws.chance(0.4) { 0.0 } else { draws.between(0.0, 0.7) * speed_mps };
    // The slow vehicle is this far ahead of the lead when the lead has left.
    let ahead_m = draws.between(2.0, 5.0) * speed_mps;
    let slow_m = gap_m + 5.0 + ahead_m + (speed_mps - slow_mps) * (begins_s + takes_s);
    let mut text = head(draws, begins_s + 30.0, speed_mps, speed_mps + 2.0);
    actor(&mut text, "lead", gap_m, &keys);
    actor(&mut text, "slow", slow_m, &format!("initial_speed_mps = {slow_mps:.2}"));
    text
}

pub fn slow_ahead(draws: &mut Draws) -> String {
    let speed_mps = draws.between(12.0, 34.0);
    let slow_mps = (speed_mps - draws.between(2.0, 20.0)).max(0.0);
    let gap_m = draws.between(100.0, 400.0);
    let mut text = head(draws, 50.0, speed_mps, speed_mps);
    actor(&mut text, "slow", gap_m, &format!("initial_speed_mps = {slow_mps:.2}"));
    text
}

pub fn queue_beside(draws: &mut Draws) -> String {
    let speed_mps = draws.between(5.0, 25.0);
    let crawl_mps = draws.one(&[0.0, 0.5, 1.5, 3.0, 5.0]);
    let mut text = head(draws, 40.0, speed_mps, speed_mps);
    let (mut place_m, side) = (draws.between(30.0, 120.0), draws.side());
    let is_double = draws.chance(0.3);
    // A scenario takes eight actors, and one may lead.
    for number in 0..7 {
        let side = if is_double && number % 2 == 1 { -side } else { side };
        let keys = format!(
            "initial_speed_mps = {crawl_mps}\nlateral_offset_m = {:.2}\nlength_m = {}",
            side * draws.between(3.1, 3.8),
            draws.one(&[4.5, 4.5, 4.5, 12.0])
        );
        actor(&mut text, &format!("queue-{number}"), place_m, &keys);
        place_m += 12.5 + draws.between(1.0, 8.0);
    }
    if draws.chance(0.4) {
        led(draws, &mut text, speed_mps, "");
    }
    text
}

pub fn passing(draws: &mut Draws) -> String {
    let speed_mps = draws.between(12.0, 34.0);
    let mut text = head(draws, 40.0, speed_mps, speed_mps);
    let mut place_m = draws.between(5.0, 30.0);
    for (number, side) in [1.0, -1.0, 1.0, -1.0, 1.0].into_iter().enumerate() {
        let other_mps = (speed_mps + draws.between(-12.0, 8.0)).max(1.0);
        let (lateral_m, near_m) = (side * draws.between(3.2, 3.8), side * draws.between(2.9, 3.5));
        let at_s = draws.between(1.0, 20.0);
        let keys = format!(
            "initial_speed_mps = {other_mps:.2}\nlateral_offset_m = {lateral_m:.2}\n\
             lateral = [{{ time_s = {at_s:.2}, to_m = {near_m:.2}, duration_s = 3 }}, \
             {{ time_s = {:.2}, to_m = {lateral_m:.2}, duration_s = 3 }}]",
            at_s + 4.0
        );
        actor(&mut text, &format!("lane-{number}"), place_m, &keys);
        place_m += draws.between(10.0, 50.0);
    }
    if draws.chance(0.5) {
        led(draws, &mut text, speed_mps, "");
    }
    text
}
