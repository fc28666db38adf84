//! A first-order filter on the target's gap and speed.

use law::{Ego, Target};

/// Filters the gap and the target's own speed, which are uncertain. The ego's speed is known, so the ego's braking
/// passes without delay.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TargetFilter {
    track: Option<u32>,
    gap_m: f64,
    speed_mps: f64,
}

impl TargetFilter {
    pub(super) fn clear(&mut self) {
        self.track = None;
    }

    /// Takes one sample and returns the filtered gap, m, and relative speed, m/s. A new track
    /// starts from its own sample (trap 9). `time_constant` in s, 0 for no filter.
    pub(super) fn update(
        &mut self,
        target: &Target,
        ego: &Ego,
        period: f64,
        time_constant: f64,
    ) -> (f64, f64) {
        let speed = ego.speed_mps + target.relative_speed_mps;
        if self.track == Some(target.track_id) {
            let share = period / (time_constant + period);
            self.speed_mps += share * (speed - self.speed_mps);
            let predicted = self.gap_m + period * (self.speed_mps - ego.speed_mps);
            self.gap_m = predicted + share * (target.gap_m - predicted);
        } else {
            *self = Self { track: Some(target.track_id), gap_m: target.gap_m, speed_mps: speed };
        }
        (self.gap_m, self.speed_mps - ego.speed_mps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(track_id: u32, gap_m: f64, relative_speed_mps: f64) -> Target {
        Target { track_id, gap_m, relative_speed_mps, ..Target::default() }
    }

    #[test]
    fn constant_closing_leaves_no_lag() {
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let mut f = TargetFilter::default();
        for k in 0..50 {
            let gap = 100.0 - 0.5 * f64::from(k);
            let (g, v) = f.update(&target(1, gap, -5.0), &ego, 0.1, 0.3);
            assert!((g - gap).abs() < 1e-9 && (v + 5.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_new_track_starts_afresh() {
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let mut f = TargetFilter::default();
        let _ = f.update(&target(1, 100.0, -5.0), &ego, 0.1, 0.3);
        assert_eq!(f.update(&target(2, 20.0, 1.0), &ego, 0.1, 0.3), (20.0, 1.0));
    }

    #[test]
    fn zero_time_constant_passes_the_sample() {
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let mut f = TargetFilter::default();
        let _ = f.update(&target(1, 100.0, -5.0), &ego, 0.1, 0.0);
        assert_eq!(f.update(&target(1, 90.0, -3.0), &ego, 0.1, 0.0), (90.0, -3.0));
    }
}
