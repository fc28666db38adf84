//! Entries and exits of curves with a queue that stands beside the ego's lane, or in it.
//!
//! Odd numbers are entries, even ones exits.
//!
//! | drawn | from | to |
//! | --- | --- | --- |
//! | radius, m, uniform in its logarithm | 125 | 1,000 |
//! | speed over that of 2.0 m/s² in the curve, at most 33 m/s | 0.7 | 1.0 |
//! | clothoid, m: in one of two curves | 30 | 100 |
//! | entry: end of the queue behind the start of the arc, m | 5 | 100 |
//! | exit: end of the queue behind the end of the arc, m | -30 | 60 |
//!
//! The queue has six vehicles, 2 to 4 m apart. It stands left or right of the lane, or in it.

use std::fmt::Write;

use super::draw::{Draws, Ego, LANE_M};

/// Selects the draws.
const STREAM: u64 = 0x0c04_e9ee_0e5a_11d5;
/// Lateral acceleration that limits the speed, m/s².
const COMFORT_MPS2: f64 = 2.0;
/// Highest speed, m/s.
const FASTEST_MPS: f64 = 33.0;
/// Vehicles in the queue.
const VEHICLES: usize = 6;
/// Way before the queue, m: beyond the radar's range.
const APPROACH_M: f64 = 220.0;
/// Length of the arc over its radius, and its bounds, m.
const ARC: (f64, f64, f64) = (1.0, 180.0, 400.0);
/// Straight road behind the curve, m.
const BEHIND_M: f64 = 500.0;
/// Time for a stop behind the queue, s.
const STOPS_S: f64 = 20.0;

/// A curve with a queue.
#[derive(Clone, Debug, PartialEq)]
pub struct Queue {
    speed_mps: f64,
    radius_m: f64,
    turn: f64,
    spiral_m: Option<f64>,
    arc_m: f64,
    line_m: f64,
    /// Rear of the last vehicle of the queue.
    end_m: f64,
    side: f64,
    /// Length, width, gap to the next one, offset in the lane, m.
    vehicles: Vec<(f64, f64, f64, f64)>,
}

impl Queue {
    /// Queue `number`.
    pub fn new(number: u64) -> Self {
        let mut draws = Draws::new(number, STREAM);
        let radius_m = draws.log_between(125.0, 1_000.0);
        let fastest_mps = libm::sqrt(COMFORT_MPS2 * radius_m).min(FASTEST_MPS);
        let speed_mps = draws.between(0.7, 1.0) * fastest_mps;
        let turn = draws.side();
        let spiral_m = draws.chance(0.5).then(|| draws.between(30.0, 100.0));
        let arc_m = (ARC.0 * radius_m).clamp(ARC.1, ARC.2);
        let (into_m, behind_m) = (draws.between(5.0, 100.0), draws.between(-30.0, 60.0));
        let bend_m = spiral_m.unwrap_or(0.0);
        let before_m =
            if Self::is_entry(number) { bend_m + into_m } else { bend_m + arc_m + behind_m };
        let line_m = (APPROACH_M - before_m).max(60.0);
        let side = draws.side();
        let vehicles = (0..VEHICLES).map(|_| {
            let (length_m, width_m) = draws.size_m();
            (length_m, width_m, draws.between(2.0, 4.0), draws.between(-0.3, 0.3))
        });
        let vehicles = vehicles.collect();
        let end_m = line_m + before_m;
        Self { speed_mps, radius_m, turn, spiral_m, arc_m, line_m, end_m, side, vehicles }
    }

    /// As a scenario file, with the queue in the ego's lane or beside it.
    pub fn text(&self, number: u64, is_in_lane: bool, sources: &str, law: &str) -> String {
        let Self { speed_mps, radius_m, arc_m, line_m, .. } = self;
        let turn = if self.turn > 0.0 { "left" } else { "right" };
        let spiral = self
            .spiral_m
            .map_or_else(String::new, |spiral_m| format!("{{ spiral_m = {spiral_m:.2} }}, "));
        let plan = format!(
            "pieces = [{{ line_m = {line_m:.2} }}, {spiral}\
             {{ arc_m = {arc_m:.2}, radius_m = {radius_m:.2}, turn = \"{turn}\" }}, {spiral}\
             {{ line_m = {BEHIND_M} }}]"
        );
        let length_m: f64 = self.vehicles.iter().map(|(length, _, gap, _)| length + gap).sum();
        let way_m = if is_in_lane { self.end_m } else { self.end_m + length_m + 20.0 };
        let rest_s = if is_in_lane { STOPS_S } else { 0.0 };
        let place = if is_in_lane { "in-lane" } else { "beside" };
        let ego = Ego {
            name: format!("curves-{place}-{number}"),
            seed: number,
            duration_s: way_m / speed_mps + rest_s,
            speed_mps: *speed_mps,
            plan: &plan,
            sources,
            law,
        };
        let mut text = ego.text();
        let lane_m = if is_in_lane { 0.0 } else { self.side * LANE_M };
        let mut rear_m = self.end_m;
        for (index, (length_m, width_m, gap_m, offset_m)) in self.vehicles.iter().enumerate() {
            write!(
                text,
                "[[actors]]\nname = \"queue-{index}\"\ngap_m = {rear_m:.2}\n\
                 initial_speed_mps = 0\nlateral_offset_m = {:.3}\n\
                 length_m = {length_m}\nwidth_m = {width_m}\n",
                lane_m + offset_m,
            )
            .expect("a string takes all");
            rear_m += length_m + gap_m;
        }
        text
    }

    /// True if the queue stands at the start of the curve.
    pub fn is_entry(number: u64) -> bool {
        number % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queues_are_as_the_table_says() {
        assert_eq!(Queue::new(7), Queue::new(7));
        let all: Vec<Queue> = (1..=400).map(Queue::new).collect();
        for queue in &all {
            assert!((125.0..1_000.0).contains(&queue.radius_m));
            assert!(queue.speed_mps.powi(2) / queue.radius_m <= COMFORT_MPS2 + 1e-9);
            assert!(queue.end_m >= APPROACH_M - 1e-9, "it is out of sight at first: {queue:?}");
            assert!(queue.arc_m / queue.radius_m < 1.5, "no road crosses itself: {queue:?}");
        }
        let with = all.iter().filter(|queue| queue.spiral_m.is_some()).count();
        assert!((160..240).contains(&with), "{with} with clothoids");
        let left = all.iter().filter(|queue| queue.turn > 0.0).count();
        assert!((160..240).contains(&left), "{left} to the left");
    }
}
