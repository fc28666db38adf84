//! The gap that is kept behind a target, and which of the three modes is on: equations (14) to (16).

use super::target_filter::Estimate;

/// Standstill distance, m, and what the paper adds to it.
const STANDSTILL_M: f64 = 5.0;
const EXTRA_M: f64 = 10.0;
/// Time headway, s.
const HEADWAY_S: f64 = 1.8;
/// How much the gap shrinks uphill and grows downhill, m per grade.
const UPHILL_M: f64 = 250.0;
const DOWNHILL_M: f64 = 500.0;
/// Width of the band above and below the desired gap, m.
const ABOVE_M: f64 = 15.0;
const BELOW_M: f64 = 12.0;
/// Deceleration that the stopping distance counts on, m/s²; twice it stands in (15).
const STOPPING_MPS2: f64 = 4.0;
/// Deceleration that drag alone gives, m/s²: half of what (16) divides by.
const DRAG_MPS2: f64 = 0.08;
/// A target is let go this far beyond the band, m.
const HYSTERESIS_M: f64 = 3.0;

/// What the radar layer has decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// 1: the plan drives.
    #[default]
    Predictive,
    /// 2: the target's speed and gap are followed.
    Follow,
    /// 3: too close; the driver is warned, and brakes may be used.
    Warn,
}

/// Gaps at one moment, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// d_des (14).
    pub desired_m: f64,
    /// d_max, d_min and d_stop (15).
    pub max_m: f64,
    /// Lower end of the band.
    pub min_m: f64,
    /// Below it the driver is warned.
    pub stop_m: f64,
}

impl Spacing {
    /// Gaps at ego speed `speed_mps`, target speed `target_mps` and `grade`, the mean over 300 m from the
    /// lead on; 0 when that is not known.
    #[must_use]
    pub fn new(speed_mps: f64, target_mps: f64, grade: f64) -> Self {
        let slope_m = UPHILL_M * grade.max(0.0) + DOWNHILL_M * grade.min(0.0);
        let desired_m = (HEADWAY_S * target_mps + STANDSTILL_M + EXTRA_M - slope_m)
            .max(speed_mps + STANDSTILL_M);
        let min_m = (desired_m - BELOW_M).max(0.8 * speed_mps + STANDSTILL_M);
        let closing = (speed_mps * speed_mps - target_mps * target_mps).max(0.0);
        let stop_m = STANDSTILL_M + speed_mps + closing / (2.0 * STOPPING_MPS2);
        Self { desired_m, max_m: desired_m + ABOVE_M, min_m, stop_m: min_m.min(stop_m) }
    }

    /// Mode (16) after `before`.
    #[must_use]
    pub fn mode(&self, target: &Estimate, before: Mode) -> Mode {
        let relative_mps = target.relative_speed_mps;
        let room_m = (target.gap_m - self.desired_m).max(0.1);
        let risk = relative_mps < 0.0 && relative_mps * relative_mps / (2.0 * DRAG_MPS2) > room_m;
        if target.gap_m < self.stop_m {
            Mode::Warn
        } else if target.gap_m > self.max_m + HYSTERESIS_M && !risk {
            Mode::Predictive
        } else if target.gap_m < self.max_m || risk || before == Mode::Warn {
            Mode::Follow
        } else {
            before
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_smaller_uphill_and_larger_downhill() {
        let flat = Spacing::new(20.0, 20.0, 0.0);
        assert_eq!(flat.desired_m, 51.0);
        assert_eq!(Spacing::new(20.0, 20.0, 0.02).desired_m, 46.0);
        assert_eq!(Spacing::new(20.0, 20.0, -0.02).desired_m, 61.0);
        assert_eq!((flat.max_m, flat.min_m, flat.stop_m), (66.0, 39.0, 25.0));
        assert_eq!(Spacing::new(20.0, 0.0, 0.0).desired_m, 25.0);
    }

    #[test]
    fn modes_follow_the_gap_with_hysteresis() {
        let spacing = Spacing::new(20.0, 20.0, 0.0);
        let at = |gap_m, relative_speed_mps| Estimate {
            gap_m,
            relative_speed_mps,
            acceleration_mps2: 0.0,
        };
        assert_eq!(spacing.mode(&at(24.0, 0.0), Mode::Follow), Mode::Warn);
        assert_eq!(spacing.mode(&at(67.0, 0.0), Mode::Follow), Mode::Follow);
        assert_eq!(spacing.mode(&at(67.0, 0.0), Mode::Predictive), Mode::Predictive);
        assert_eq!(spacing.mode(&at(70.0, 0.0), Mode::Follow), Mode::Predictive);
        assert_eq!(spacing.mode(&at(100.0, -4.0), Mode::Predictive), Mode::Follow);
        assert_eq!(spacing.mode(&at(27.0, 0.0), Mode::Warn), Mode::Follow);
    }
}
