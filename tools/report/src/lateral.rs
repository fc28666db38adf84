//! Motion across a road with a plan: series over run time, and their charts.

use crate::chart::{Curve, Plot, Tone};
use crate::over_time::marks;
use crate::picture::RunPicture;
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
    let mut earlier = points.iter().peekable();
    let mut from: Option<&(f64, f64)> = None;
    let slopes = points.iter().filter_map(|(time_s, value)| {
        while let Some(next) = earlier.next_if(|(then_s, _)| *then_s <= time_s - JERK_S + 1e-9) {
            from = Some(next);
        }
        let (then_s, before) = from?;
        Some((*time_s, (value - before) / (time_s - then_s)))
    });
    slopes.collect()
}

/// Height of a chart, px.
const HEIGHT: f64 = 120.0;

/// Curvature of the road, lateral acceleration and lateral jerk; empty where the road has no plan.
pub fn plots(run: &RunPicture) -> Vec<Plot> {
    let lateral = &run.lateral;
    if lateral.curvature_perkm.is_empty() {
        return Vec::new();
    }
    let plot = |title: &str, unit: &str, tone: Tone, points: &[(f64, f64)]| {
        let curve = Curve::new(title, tone, points.to_vec());
        let plot = Plot::over_time(title, run.duration_s, unit, vec![curve]);
        Plot { height: HEIGHT, ..plot }.marked(&marks(run))
    };
    let ego = Tone::Series(0);
    vec![
        plot("Curvature of the road, left positive", "1/km", Tone::Muted, &lateral.curvature_perkm),
        plot("Lateral acceleration", "m/s²", ego, &lateral.acceleration_mps2),
        plot("Lateral jerk, mean over 0.5 s", "m/s³", ego, &lateral.jerk_mps3),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lateral::LateralSeries;

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

    #[test]
    fn a_road_with_a_plan_shows_its_curves() {
        assert!(plots(&RunPicture::default()).is_empty());
        let curvature_perkm = vec![(0.0, 0.0), (5.0, -2.0)];
        let lateral = LateralSeries { curvature_perkm, ..LateralSeries::default() };
        let run = RunPicture { duration_s: 5.0, lateral, ..RunPicture::default() };
        let titles: Vec<_> = plots(&run).into_iter().map(|plot| plot.title).collect();
        assert_eq!(titles.len(), 3);
        assert!(titles[2].contains("0.5 s"), "{titles:?}");
    }
}
