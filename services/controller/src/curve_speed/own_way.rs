//! Curvature of the ego's own way: yaw rate by speed.

/// Time constant of its low-pass, s. Chosen: half of the time after which a curve that ended holds nothing back.
const LAG_S: f64 = 0.5;
/// A yaw rate within this counts as zero, rad/s. Chosen: three standard deviations of the sensor's offset and noise,
/// 0.14 °/s.
const NONE_RADPS: f64 = 0.0075;
/// Speed below which a yaw rate does not show a curvature, m/s.
const SLOWEST_MPS: f64 = 3.0;

/// The curvature of the ego's own way, as far as its yaw rate surely shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnWay {
    curvature_perm: Option<f64>,
}

impl OwnWay {
    /// Takes a yaw rate at a speed, `period_s` after the last one; returns the curvature, 1/m. Below 3 m/s it stays.
    pub fn take(&mut self, yaw_rate_radps: f64, speed_mps: f64, period_s: f64) -> Option<f64> {
        if speed_mps >= SLOWEST_MPS && yaw_rate_radps.is_finite() {
            let surely_radps = (yaw_rate_radps.abs() - NONE_RADPS).max(0.0);
            let now_perm = surely_radps.copysign(yaw_rate_radps) / speed_mps;
            let before_perm = self.curvature_perm.unwrap_or(now_perm);
            let gain = 1.0 - libm::exp(-period_s / LAG_S);
            self.curvature_perm = Some(before_perm + gain * (now_perm - before_perm));
        }
        self.curvature_perm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_road_is_straight_whatever_the_sensor_says() {
        let mut own = OwnWay::default();
        for yaw_rate_radps in [0.004, -0.007, 0.0, f64::NAN] {
            own.take(yaw_rate_radps, 5.0, 0.1);
        }
        assert_eq!(own.take(0.0, 5.0, 0.1), Some(0.0));
    }

    #[test]
    fn a_curve_shows_after_the_lag_and_stays_when_the_ego_stops() {
        let mut own = OwnWay::default();
        assert_eq!(own.take(0.1, 1.0, 0.1), None);
        own.take(0.0, 20.0, 0.1);
        for _ in 0..50 {
            own.take(-0.08, 20.0, 0.1);
        }
        let curvature_perm = own.take(-9.0, 1.0, 0.1).expect("known");
        assert!((curvature_perm + 0.0725 / 20.0).abs() < 1e-6, "{curvature_perm}");
    }
}
