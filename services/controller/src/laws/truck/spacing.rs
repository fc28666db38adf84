//! The gap that is kept behind a target, and which of the three modes is on: equations (14) to (16).

use super::settings::GapKeys;
use super::target_filter::Estimate;

/// Decision of the radar layer.
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
    /// Gaps at ego speed `speed_mps`, target speed `target_mps` and `grade`. `grade` is the mean from the lead on; 0 if
    /// it is not known.
    #[must_use]
    pub fn new(keys: &GapKeys, speed_mps: f64, target_mps: f64, grade: f64) -> Self {
        let standstill_m = keys.standstill_distance_m;
        let slope_m = keys.uphill_m * grade.max(0.0) + keys.downhill_m * grade.min(0.0);
        let headway_m = keys.stop_headway_s * speed_mps;
        let desired_m = (keys.time_headway_s * target_mps + standstill_m + keys.offset_m - slope_m)
            .max(headway_m + standstill_m);
        let min_m = (desired_m - keys.below_m).max(keys.least_headway_s * speed_mps + standstill_m);
        let closing = (speed_mps * speed_mps - target_mps * target_mps).max(0.0);
        let stop_m = standstill_m + headway_m + closing / (2.0 * keys.stopping_mps2);
        Self { desired_m, max_m: desired_m + keys.above_m, min_m, stop_m: min_m.min(stop_m) }
    }

    /// Mode (16) after `before`.
    #[must_use]
    pub fn mode(&self, keys: &GapKeys, target: &Estimate, before: Mode) -> Mode {
        let relative_mps = target.relative_speed_mps;
        let room_m = (target.gap_m - self.desired_m).max(0.1);
        let risk =
            relative_mps < 0.0 && relative_mps * relative_mps / (2.0 * keys.drag_mps2) > room_m;
        if target.gap_m < self.stop_m {
            Mode::Warn
        } else if target.gap_m > self.max_m + keys.hysteresis_m && !risk {
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
        let keys = &GapKeys::default();
        let flat = Spacing::new(keys, 20.0, 20.0, 0.0);
        assert_eq!(flat.desired_m, 51.0);
        assert_eq!(Spacing::new(keys, 20.0, 20.0, 0.02).desired_m, 46.0);
        assert_eq!(Spacing::new(keys, 20.0, 20.0, -0.02).desired_m, 61.0);
        assert_eq!((flat.max_m, flat.min_m, flat.stop_m), (66.0, 39.0, 25.0));
        assert_eq!(Spacing::new(keys, 20.0, 0.0, 0.0).desired_m, 25.0);
    }

    #[test]
    fn modes_follow_the_gap_with_hysteresis() {
        let keys = &GapKeys::default();
        let spacing = Spacing::new(keys, 20.0, 20.0, 0.0);
        let at = |gap_m, relative_speed_mps| Estimate {
            gap_m,
            relative_speed_mps,
            acceleration_mps2: 0.0,
        };
        assert_eq!(spacing.mode(keys, &at(24.0, 0.0), Mode::Follow), Mode::Warn);
        assert_eq!(spacing.mode(keys, &at(67.0, 0.0), Mode::Follow), Mode::Follow);
        assert_eq!(spacing.mode(keys, &at(67.0, 0.0), Mode::Predictive), Mode::Predictive);
        assert_eq!(spacing.mode(keys, &at(70.0, 0.0), Mode::Follow), Mode::Predictive);
        assert_eq!(spacing.mode(keys, &at(100.0, -4.0), Mode::Predictive), Mode::Follow);
        assert_eq!(spacing.mode(keys, &at(27.0, 0.0), Mode::Warn), Mode::Follow);
    }
}
