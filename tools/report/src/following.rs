//! Time gaps of a drive: gap over ego speed.

use group::DriveStep;
use serde::{Deserialize, Serialize};

/// Slowest speed with a defined time gap, m/s. Below it the quotient grows and no longer describes following.
const SLOWEST_MPS: f64 = 1.0;

/// Time gap at a sample, s; 0 in a contact, `None` below 1 m/s.
pub fn time_gap_s(step: &DriveStep) -> Option<f64> {
    let moves = step.speed_mps >= SLOWEST_MPS;
    step.gap_m.filter(|_| moves).map(|gap_m| gap_m.max(0.0) / step.speed_mps)
}

/// Time gaps behind a vehicle, s; null without one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Following {
    /// Shortest time gap, s; 0 in a contact.
    pub min_time_gap_s: Option<f64>,
    /// Median over the samples of the drive, s.
    pub median_time_gap_s: Option<f64>,
}

impl Following {
    /// Evaluates the samples with a gap at 1 m/s or faster.
    pub fn of(steps: &[DriveStep]) -> Self {
        let mut gaps_s: Vec<f64> = steps.iter().filter_map(time_gap_s).collect();
        gaps_s.sort_by(f64::total_cmp);
        let median = match gaps_s.len() {
            0 => None,
            n => Some((gaps_s[(n - 1) / 2] + gaps_s[n / 2]) / 2.0),
        };
        Self { min_time_gap_s: gaps_s.first().copied(), median_time_gap_s: median }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_gap_is_the_gap_over_the_speed_and_a_standing_vehicle_has_none() {
        let step = |gap_m, speed_mps| DriveStep { gap_m, speed_mps, ..DriveStep::default() };
        let steps = [
            step(Some(20.0), 10.0),
            step(Some(30.0), 10.0),
            step(Some(15.0), 10.0),
            step(None, 10.0),
            step(Some(3.0), 0.0),
        ];
        let following = Following::of(&steps);
        assert_eq!(following.min_time_gap_s, Some(1.5));
        assert_eq!(following.median_time_gap_s, Some(2.0));
        assert_eq!(Following::of(&steps[3..]), Following::default());
        assert_eq!(Following::of(&[step(Some(-1.4), 10.0)]).min_time_gap_s, Some(0.0));
    }
}
