//! Motion across a road with a plan: series over run time.

use supervise::{EgoPlace, PlaneScene};

/// Time over which the lateral jerk is a mean, s (UN R79, 5.6.2.1.3).
pub const JERK_S: f64 = 0.5;

/// Run time in s and value, at each scan of the radar.
pub type Points = Vec<(f64, f64)>;

/// Curvature and lateral motion; empty where the road has no plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LateralSeries {
    /// Curvature of the road at the ego, 1/km, positive to the left.
    pub curvature_perkm: Points,
    /// Lateral acceleration, m/s², positive to the left.
    pub acceleration_mps2: Points,
    /// Lateral jerk, its mean over the last [`JERK_S`], m/s³.
    pub jerk_mps3: Points,
}

impl LateralSeries {
    /// The series of a drive.
    pub fn of(scenes: &[PlaneScene]) -> Self {
        let series = |value: fn(&EgoPlace) -> f64| {
            scenes.iter().map(|scene| (scene.time_s, value(&scene.ego))).collect::<Points>()
        };
        let acceleration_mps2 = series(|ego| ego.lateral_acceleration_mps2);
        Self {
            curvature_perkm: series(|ego| 1e3 * ego.curvature_perm),
            jerk_mps3: mean_slope(&acceleration_mps2),
            acceleration_mps2,
        }
    }
}

/// Mean slope over the time before each point, if a point that long before it exists.
fn mean_slope(points: &[(f64, f64)]) -> Points {
    let slopes = points.iter().filter_map(|(time_s, value)| {
        let later = points.partition_point(|(then_s, _)| *then_s <= time_s - JERK_S + 1e-9);
        let (then_s, before) = points[..later].last()?;
        Some((*time_s, (value - before) / (time_s - then_s)))
    });
    slopes.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lateral_jerk_is_a_mean_over_half_a_second() {
        let scene = |tenth: u32| {
            let time_s = f64::from(tenth) / 10.0;
            let ego =
                EgoPlace { lateral_acceleration_mps2: time_s * time_s, ..EgoPlace::default() };
            PlaneScene { time_s, ego, ..PlaneScene::default() }
        };
        let scenes: Vec<_> = (0..=10).map(scene).collect();
        let jerk = LateralSeries::of(&scenes).jerk_mps3;
        // From 0.5 to 1.0 s: (1 - 0.25) / 0.5.
        assert!(jerk.len() == 6 && jerk[0].0 == 0.5);
        assert!((jerk[0].1 - 0.5).abs() < 1e-9 && (jerk[5].1 - 1.5).abs() < 1e-9, "{jerk:?}");
    }
}
