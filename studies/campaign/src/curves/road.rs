//! Random roads with a lead and two neighbours.
//!
//! | drawn | from | to |
//! | --- | --- | --- |
//! | radii, m | 250 | 2,000 |
//! | clothoids, m | 30 | 200 |
//! | speed of the ego and mean speed of the others, m/s | 16 | 22.4 |
//! | gap of the lead at the start, m | 30 | 100 |
//! | gap of each neighbour over the lead's | 0.5 | 1.3 |
//! | wave of the lead's speed, amplitude of its acceleration, m/s² | 0.1 | 0.3 |
//! | the same of the neighbours | 0.1 | 0.5 |
//! | period of these waves, s | 12 | 30 |
//!
//! The largest speed gives 2.0 m/s² on the smallest radius, so that no curve changes the gap.

use std::fmt::Write;

use super::draw::{Draws, Ego, LANE_M};

/// Length of a drive, m.
pub const LENGTH_M: f64 = 5_000.0;
/// Length of the road, km: it reaches beyond the drive as far as the radar sees.
const ROAD_KM: f64 = 5.5;
/// Selects the draws.
const STREAM: u64 = 0xc04e_5ead_0000_5e1d;

/// A vehicle ahead or beside.
#[derive(Clone, Debug, PartialEq)]
struct Other {
    name: &'static str,
    lane_m: f64,
    gap_m: f64,
    length_m: f64,
    width_m: f64,
    amplitude_mps2: f64,
    period_s: f64,
    wander: String,
}

/// A random road with its traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomRoad {
    speed_mps: f64,
    others: Vec<Other>,
}

impl RandomRoad {
    /// Road `number`.
    pub fn new(number: u64) -> Self {
        let mut draws = Draws::new(number, STREAM);
        let speed_mps = draws.between(16.0, 22.4);
        let lead_m = draws.between(30.0, 100.0);
        let kinds = [("lead", 0.0, 0.3), ("left", LANE_M, 0.5), ("right", -LANE_M, 0.5)];
        let others = kinds.into_iter().map(|(name, lane_m, waves_mps2)| {
            let share = if lane_m == 0.0 { 1.0 } else { draws.between(0.5, 1.3) };
            let (length_m, width_m) = draws.size_m();
            Other {
                name,
                lane_m,
                gap_m: share * lead_m,
                length_m,
                width_m,
                amplitude_mps2: draws.between(0.1, waves_mps2),
                period_s: draws.between(12.0, 30.0),
                wander: draws.wander(lane_m, LENGTH_M / speed_mps),
            }
        });
        Self { speed_mps, others: others.collect() }
    }

    /// As a scenario file.
    pub fn text(&self, number: u64, sources: &str, law: &str) -> String {
        let plan = format!(
            "generated = {{ seed = {number}, length_km = {ROAD_KM}, min_radius_m = 250, \
             max_radius_m = 2000, spiral_m = [30, 200] }}"
        );
        let speed_mps = self.speed_mps;
        let ego = Ego {
            name: format!("curves-road-{number}"),
            seed: number,
            duration_s: LENGTH_M / speed_mps,
            speed_mps,
            plan: &plan,
            sources,
            law,
        };
        let mut text = ego.text();
        for other in &self.others {
            let Other { name, lane_m, gap_m, length_m, width_m, .. } = other;
            let Other { amplitude_mps2, period_s, wander, .. } = other;
            // The acceleration a sin(2 pi t / T) adds a T / (2 pi) to the mean speed.
            let first_mps = speed_mps - amplitude_mps2 * period_s / std::f64::consts::TAU;
            write!(
                text,
                "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m:.2}\n\
                 initial_speed_mps = {first_mps:.3}\nlateral_offset_m = {lane_m}\n\
                 length_m = {length_m}\nwidth_m = {width_m}\n\
                 profile.sine = {{ amplitude_mps2 = {amplitude_mps2:.3}, period_s = {period_s:.2} }}\n\
                 {wander}"
            )
            .expect("a string takes all");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_makes_the_road() {
        assert_eq!(RandomRoad::new(7), RandomRoad::new(7));
        assert_ne!(RandomRoad::new(7), RandomRoad::new(8));
    }

    #[test]
    fn roads_are_as_the_table_says() {
        for road in (1..=300).map(RandomRoad::new) {
            assert!((16.0..22.4).contains(&road.speed_mps));
            assert!(road.speed_mps.powi(2) / 250.0 <= 2.01, "no curve slows it down");
            let [lead, left, right] = road.others.as_slice() else { panic!("{road:?}") };
            assert!((30.0..100.0).contains(&lead.gap_m));
            for beside in [left, right] {
                assert!((0.5..1.3).contains(&(beside.gap_m / lead.gap_m)));
            }
        }
    }
}
