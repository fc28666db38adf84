//! Maps of the road ahead in cells of one length: grades and curvatures, with the faults of the scenario.
//!
//! Both maps have the faults of `[v2x.preview]`. They are shifted along the road, they end, and each cell has an error
//! of its own.

use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use road::Axis;
use scenario::grade::GradeProfile;
use scenario::{Problem, Scenario};

use crate::numbers::NUMBERS;

/// A quantity along the road that a map has as means over its cells.
#[derive(Clone, Debug)]
enum Quantity {
    Grade(GradeProfile),
    Curvature(Axis),
}

impl Quantity {
    fn mean(&self, from_m: f64, length_m: f64) -> f64 {
        match self {
            Self::Grade(road) => road.mean_grade(from_m, from_m + length_m),
            // A mean curvature is the change of the heading.
            Self::Curvature(road) => {
                let turn = road.heading_rad(from_m + length_m) - road.heading_rad(from_m);
                libm::remainder(turn, std::f64::consts::TAU) / length_m
            }
        }
    }

    /// A mean with an error, which is added to a grade, and in proportion to a curvature.
    fn falsified(&self, exact: f64, error: f64) -> f64 {
        match self {
            Self::Grade(_) => exact + error,
            Self::Curvature(_) => exact * (1.0 + error),
        }
    }

    /// Sets the errors of one quantity apart from those of the other.
    fn stream(&self) -> u64 {
        match self {
            Self::Grade(_) => 0,
            Self::Curvature(_) => 0xc0_97e5,
        }
    }
}

#[derive(Clone, Debug)]
pub struct CellMap {
    quantity: Quantity,
    pub cell_m: f64,
    shift_m: f64,
    noise: f64,
    ends_at_m: f64,
    seed: u64,
}

impl CellMap {
    /// The map of the grades of a scenario's road.
    ///
    /// # Errors
    /// A [`Problem`] if the scenario's road is not valid.
    pub fn of_grades(scenario: &Scenario) -> Result<Self, Problem> {
        Ok(Self::of(Quantity::Grade(scenario.road.profile()?), NUMBERS.cell_m, scenario))
    }

    /// The map of the curves of a scenario's road; `None` without a plan.
    pub fn of_curves(scenario: &Scenario) -> Option<Self> {
        let axis = scenario.road.plan()?.axis().clone();
        Some(Self::of(Quantity::Curvature(axis), NUMBERS.curve_cell_m, scenario))
    }

    fn of(quantity: Quantity, cell_m: f64, scenario: &Scenario) -> Self {
        let faults = scenario.v2x.preview;
        Self {
            quantity,
            cell_m,
            shift_m: faults.shift_m.value(),
            noise: faults.noise_percent.value() / 100.0,
            ends_at_m: faults.ends_at_m.map_or(f64::INFINITY, |end| end.value()),
            seed: scenario.seed.value(),
        }
    }

    /// Writes the means of the known cells from the ego's on; their number, and the beginning of the first one, m.
    pub fn ahead(&self, ego_m: f64, means: &mut [f64]) -> (u64, f64) {
        let first = (ego_m / self.cell_m).floor();
        let mut count = 0;
        for (index, mean) in means.iter_mut().enumerate() {
            let cell = first + index as f64;
            if (cell + 1.0) * self.cell_m > self.ends_at_m {
                break;
            }
            *mean = self.mean(cell);
            count += 1;
        }
        (count, first * self.cell_m)
    }

    fn mean(&self, cell: f64) -> f64 {
        let exact = self.quantity.mean(cell * self.cell_m - self.shift_m, self.cell_m);
        match self.noise {
            0.0 => exact,
            noise => self.quantity.falsified(exact, noise * self.error(cell)),
        }
    }

    /// A standard normal number for each cell, always the same for one seed.
    fn error(&self, cell: f64) -> f64 {
        let place = (cell as i64).unsigned_abs().wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let stream = place ^ self.quantity.stream();
        random::normal(&mut Pcg64::seed_from_u64(self.seed.wrapping_add(stream)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{MAX_CURVE_CELLS, MAX_PREVIEW_CELLS};

    mod grades {
        use super::*;

        fn ahead(map: &CellMap, ego_m: f64) -> ((u64, f64), [f64; MAX_PREVIEW_CELLS]) {
            let mut grades = [0.0; MAX_PREVIEW_CELLS];
            let ahead = map.ahead(ego_m, &mut grades);
            (ahead, grades)
        }

        fn grades(map: &CellMap, ego_m: f64) -> [f64; MAX_PREVIEW_CELLS] {
            ahead(map, ego_m).1
        }

        fn map(keys: &str) -> CellMap {
            let text = format!(
                "schema_version = 1\nname = \"hills\"\nplant.vehicle = \"jh6-49t\"\n\
                 road.builtin = \"hills-60km\"\n{keys}\n"
            );
            CellMap::of_grades(&Scenario::parse("hills", &text).expect("a right scenario"))
                .expect("a road")
        }

        #[test]
        fn two_kilometres_ahead_are_known_from_anywhere_in_a_cell() {
            let map = map("");
            let Quantity::Grade(road) = &map.quantity else { panic!("a map of grades") };
            for ego_m in [0.0, 49.9, 1234.5] {
                let ((count, first_m), grades) = ahead(&map, ego_m);
                assert!(first_m <= ego_m && ego_m < first_m + map.cell_m);
                assert!(first_m + count as f64 * map.cell_m >= ego_m + 2000.0);
                let middle_m = first_m + 10.5 * map.cell_m;
                assert!((grades[10] - road.grade(middle_m)).abs() < 1e-12);
            }
        }

        #[test]
        fn a_map_ends_in_whole_cells() {
            let map = map("v2x.preview.ends_at_m = 1020");
            assert_eq!([0.0, 960.0, 1010.0, 5000.0].map(|x| ahead(&map, x).0.0), [20, 1, 0, 0]);
        }

        #[test]
        fn a_shift_moves_and_noise_stays_where_it_is() {
            let (exact, shifted) = (map(""), map("v2x.preview.shift_m = 100"));
            assert_eq!(grades(&exact, 1000.0)[..40], grades(&shifted, 1100.0)[..40]);
            let noisy = map("v2x.preview.noise_percent = 0.25");
            assert_eq!(grades(&noisy, 1000.0)[2..40], grades(&noisy, 1100.0)[..38]);
            let errors: Vec<f64> = (0..1000)
                .map(|cell| noisy.mean(f64::from(cell)) - exact.mean(f64::from(cell)))
                .collect();
            let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            assert!((variance.sqrt() / 0.0025 - 1.0).abs() < 0.1, "{}", variance.sqrt());
        }
    }

    mod curves {
        use super::*;

        /// 300 m straight, 80 m to a radius of 500 m, 400 m of that to the left.
        fn map(keys: &str) -> CellMap {
            let text = format!(
                "schema_version = 1\nname = \"bend\"\n{keys}\n[road.plan]\npieces = [{{ line_m = 300 }}, \
                 {{ spiral_m = 80 }}, {{ arc_m = 400, radius_m = 500, turn = \"left\" }}, {{ spiral_m = 80 }}, \
                 {{ line_m = 2000 }}]\n"
            );
            let scenario = Scenario::parse("bend", &text).unwrap_or_else(|error| panic!("{error}"));
            CellMap::of_curves(&scenario).expect("it has a plan")
        }

        fn ahead(map: &CellMap, ego_m: f64) -> ((u64, f64), [f64; MAX_CURVE_CELLS]) {
            let mut curvatures = [0.0; MAX_CURVE_CELLS];
            let ahead = map.ahead(ego_m, &mut curvatures);
            (ahead, curvatures)
        }

        #[test]
        fn two_kilometres_of_curvatures_are_known() {
            let map = map("");
            let (known, curvatures) = ahead(&map, 137.5);
            assert_eq!(known, (MAX_CURVE_CELLS as u64, 125.0));
            let at = |place_m: f64| curvatures[((place_m - 125.0) / map.cell_m) as usize];
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
            assert_eq!([0.0, 480.0, 505.0].map(|ego_m| ahead(&ended, ego_m).0.0), [20, 1, 0]);
        }

        #[test]
        fn a_road_that_turns_around_has_the_curvature_of_its_circle() {
            let text = "schema_version = 1\nname = \"circle\"\n[road.plan]\npieces = [{ line_m = 100 }, \
                { spiral_m = 50 }, { arc_m = 600, radius_m = 125, turn = \"right\" }, { spiral_m = 50 }, \
                { line_m = 300 }]\n";
            let scenario =
                Scenario::parse("circle", text).unwrap_or_else(|error| panic!("{error}"));
            let map = CellMap::of_curves(&scenario).expect("it has a plan");
            let (_, curvatures) = ahead(&map, 150.0);
            assert!(curvatures[..24].iter().all(|k| (k + 0.008).abs() < 1e-9), "{curvatures:?}");
        }

        #[test]
        fn a_road_without_a_plan_has_no_map_of_curves() {
            let text = "schema_version = 1\nname = \"straight\"\n";
            assert!(
                CellMap::of_curves(&Scenario::parse("straight", text).expect("a scenario"))
                    .is_none()
            );
        }
    }
}
