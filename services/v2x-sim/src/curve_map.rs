//! The map of the road's curves, with the faults of the scenario.

use messages::MAX_CURVE_CELLS;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use road::Axis;
use scenario::Scenario;

use crate::numbers::NUMBERS;

/// Length of a cell, m.
pub const CELL_M: f64 = NUMBERS.curve_cell_m;
/// Sets the errors of the curvatures apart from those of the grades.
const STREAM: u64 = 0xc0_97e5;

/// The known part of the road ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// Begin of the first cell, m.
    pub first_cell_m: f64,
    /// Cells with known curvatures.
    pub count: usize,
}

/// The map of a road with a plan.
///
/// It has the faults of the map of grades (`[v2x.preview]`): it is shifted along the road, a cell's curvature has an
/// error in proportion to it, and it ends.
#[derive(Clone, Debug)]
pub struct CurveMap {
    axis: Axis,
    shift_m: f64,
    noise: f64,
    ends_at_m: f64,
    seed: u64,
}

impl CurveMap {
    /// The map of a scenario's road; `None` without a plan.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let faults = scenario.v2x.preview;
        Some(Self {
            axis: scenario.road.plan()?.axis().clone(),
            shift_m: faults.shift_m.value(),
            noise: faults.noise_percent.value() / 100.0,
            ends_at_m: faults.ends_at_m.map_or(f64::INFINITY, |end| end.value()),
            seed: scenario.seed.value(),
        })
    }

    /// The road from the ego's cell on; writes the mean curvatures of the known cells.
    pub fn ahead(&self, ego_m: f64, curvatures: &mut [f64; MAX_CURVE_CELLS]) -> Ahead {
        let first = (ego_m / CELL_M).floor();
        let mut count = 0;
        for (index, curvature) in curvatures.iter_mut().enumerate() {
            let cell = first + index as f64;
            if (cell + 1.0) * CELL_M > self.ends_at_m {
                break;
            }
            *curvature = self.curvature_perm(cell);
            count += 1;
        }
        Ahead { first_cell_m: first * CELL_M, count }
    }

    fn curvature_perm(&self, cell: f64) -> f64 {
        let from_m = cell * CELL_M - self.shift_m;
        // A mean curvature is the change of the heading.
        let begin = self.axis.pose(from_m).heading_rad;
        let turn = self.axis.pose(from_m + CELL_M).heading_rad - begin;
        let exact = libm::remainder(turn, std::f64::consts::TAU) / CELL_M;
        if self.noise == 0.0 { exact } else { exact * (1.0 + self.noise * self.error(cell)) }
    }

    /// A standard normal number for each cell, always the same for one seed.
    fn error(&self, cell: f64) -> f64 {
        let stream = (cell as i64).unsigned_abs().wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ STREAM;
        random::normal(&mut Pcg64::seed_from_u64(self.seed.wrapping_add(stream)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 300 m straight, 80 m to a radius of 500 m, 400 m of that to the left.
    fn map(keys: &str) -> CurveMap {
        let text = format!(
            "schema_version = 1\nname = \"bend\"\n{keys}\n[road.plan]\npieces = [{{ line_m = 300 }}, \
             {{ spiral_m = 80 }}, {{ arc_m = 400, radius_m = 500, turn = \"left\" }}, {{ spiral_m = 80 }}, \
             {{ line_m = 2000 }}]\n"
        );
        let scenario = Scenario::parse("bend", &text).unwrap_or_else(|error| panic!("{error}"));
        CurveMap::new(&scenario).expect("it has a plan")
    }

    fn ahead(map: &CurveMap, ego_m: f64) -> (Ahead, [f64; MAX_CURVE_CELLS]) {
        let mut curvatures = [0.0; MAX_CURVE_CELLS];
        let ahead = map.ahead(ego_m, &mut curvatures);
        (ahead, curvatures)
    }

    #[test]
    fn two_kilometres_of_curvatures_are_known() {
        let map = map("");
        let (known, curvatures) = ahead(&map, 137.5);
        assert_eq!(known, Ahead { first_cell_m: 125.0, count: MAX_CURVE_CELLS });
        let at = |place_m: f64| curvatures[((place_m - 125.0) / CELL_M) as usize];
        assert_eq!(at(200.0), 0.0);
        // The spiral gets to 1/500 over 80 m: the middle of its second cell is 37.5 m along it.
        assert!((at(330.0) - 37.5 / 80.0 / 500.0).abs() < 1e-9, "{}", at(330.0));
        assert!((at(500.0) - 0.002).abs() < 1e-9 && at(900.0) == 0.0);
    }

    #[test]
    fn a_shift_moves_noise_scales_and_the_end_ends() {
        let (exact, shifted) = (map(""), map("v2x.preview.shift_m = 50"));
        assert_eq!(ahead(&exact, 250.0).1[..40], ahead(&shifted, 300.0).1[..40]);
        let noisy = map("v2x.preview.noise_percent = 10");
        let (right, wrong) = (ahead(&exact, 400.0).1, ahead(&noisy, 400.0).1);
        assert!(right.iter().zip(&wrong).all(|(a, b)| (a == &0.0) == (b == &0.0)));
        let errors: Vec<f64> = (0..14).map(|cell| wrong[cell] / right[cell] - 1.0).collect();
        assert!(errors.iter().all(|error| error.abs() < 0.5), "{errors:?}");
        assert!(errors.iter().any(|error| error.abs() > 0.03), "{errors:?}");
        assert_eq!(ahead(&noisy, 425.0).1[..13], wrong[1..14], "an error stays in its cell");
        let ended = map("v2x.preview.ends_at_m = 510");
        assert_eq!([0.0, 480.0, 505.0].map(|ego_m| ahead(&ended, ego_m).0.count), [20, 1, 0]);
    }

    #[test]
    fn a_road_that_turns_around_has_the_curvature_of_its_circle() {
        let text = "schema_version = 1\nname = \"circle\"\n[road.plan]\npieces = [{ line_m = 100 }, \
            { spiral_m = 50 }, { arc_m = 600, radius_m = 125, turn = \"right\" }, { spiral_m = 50 }, \
            { line_m = 300 }]\n";
        let scenario = Scenario::parse("circle", text).unwrap_or_else(|error| panic!("{error}"));
        let map = CurveMap::new(&scenario).expect("it has a plan");
        let (_, curvatures) = ahead(&map, 150.0);
        assert!(curvatures[..24].iter().all(|k| (k + 0.008).abs() < 1e-9), "{curvatures:?}");
    }

    #[test]
    fn a_road_without_a_plan_has_no_map_of_curves() {
        let text = "schema_version = 1\nname = \"straight\"\n";
        assert!(CurveMap::new(&Scenario::parse("straight", text).expect("a scenario")).is_none());
    }
}
