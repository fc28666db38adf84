//! The road beyond the horizon, as far as it is worth guessing.
//!
//! The value of speed at the horizon depends on the road after it. On a descent that continues, energy is braked away.
//! A slope does not end with the map. The guess is that it fades with the length of slopes:
//!
//! ```text
//! g(s) = g_last e^(-s/l)
//! ```

use crate::law::Preview;

/// Length of a step, m.
pub(crate) const STEP_M: f64 = 400.0;
/// Number of steps: another horizon.
pub(crate) const STEPS: usize = 5;
/// l, m: between the tangents of hills (300 to 1500 m) and those of motorways (1500 to 5000 m).
const FADING_M: f64 = 2000.0;
/// The last grade is a mean over this length, m: two steps of a plan.
const LAST_M: f64 = 200.0;

/// The road after the horizon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beyond<'a> {
    preview: &'a Preview,
    horizon_m: f64,
    last_grade: f64,
}

impl<'a> Beyond<'a> {
    /// Road beyond the horizon of a plan that begins at `start_m`.
    pub(crate) fn new(preview: &'a Preview, start_m: f64, horizon_m: f64) -> Self {
        let from_m = start_m.max(horizon_m - LAST_M);
        let last_grade = preview.mean_grade(from_m, horizon_m).unwrap_or(0.0);
        Self { preview, horizon_m, last_grade }
    }

    /// Mean grade of a step, counted from 0: the map's where it is known, else the guess.
    pub(crate) fn grade(&self, step: usize) -> f64 {
        let (from_m, to_m) = (STEP_M * step as f64, STEP_M * (step + 1) as f64);
        let known = self.preview.mean_grade(self.horizon_m + from_m, self.horizon_m + to_m);
        known.unwrap_or_else(|| {
            let left = |distance_m: f64| libm::exp(-distance_m / FADING_M);
            self.last_grade * FADING_M / STEP_M * (left(from_m) - left(to_m))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_slope_fades_where_the_map_ends() {
        let mut preview = Preview { count: 48, ..Preview::default() };
        preview.grades[36..40].fill(-0.03);
        preview.grades[40..48].fill(-0.01);
        let beyond = Beyond::new(&preview, 0.0, 2000.0);
        assert!((beyond.grade(0) + 0.01).abs() < 1e-12, "known: {}", beyond.grade(0));
        for step in 1..STEPS {
            let middle_m = STEP_M * (step as f64 + 0.5);
            let expected = -0.03 * libm::exp(-middle_m / FADING_M);
            assert!((beyond.grade(step) / expected - 1.0).abs() < 5e-3, "{step}");
        }
    }
}
