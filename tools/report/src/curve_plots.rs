//! Charts of the motion across a road with a plan.

use crate::chart::{Curve, Plot, Tone};
use crate::over_time::marks;
use crate::picture::RunPicture;

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
