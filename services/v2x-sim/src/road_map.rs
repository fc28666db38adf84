//! The map of the road ahead, with the faults of the scenario.

use messages::MAX_PREVIEW_CELLS;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::Problem;
use scenario::Scenario;
use scenario::grade::GradeProfile;

use crate::numbers::NUMBERS;

/// Length of a cell, m.
pub const CELL_M: f64 = NUMBERS.cell_m;

/// The known part of the road ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// Begin of the first cell, m.
    pub first_cell_m: f64,
    /// Cells with known grades.
    pub count: usize,
}

/// The map.
#[derive(Clone, Debug)]
pub struct RoadMap {
    road: GradeProfile,
    shift_m: f64,
    noise: f64,
    ends_at_m: f64,
    seed: u64,
}

impl RoadMap {
    /// The map of a scenario's road.
    ///
    /// # Errors
    /// A [`Problem`] if the scenario's road is not valid.
    pub fn new(scenario: &Scenario) -> Result<Self, Problem> {
        let faults = scenario.v2x.preview;
        Ok(Self {
            road: scenario.road.profile()?,
            shift_m: faults.shift_m.value(),
            noise: faults.noise_percent.value() / 100.0,
            ends_at_m: faults.ends_at_m.map_or(f64::INFINITY, |end| end.value()),
            seed: scenario.seed.value(),
        })
    }

    /// The road from the ego's cell on; writes the mean grades of the known cells.
    pub fn ahead(&self, ego_m: f64, grades: &mut [f64; MAX_PREVIEW_CELLS]) -> Ahead {
        let first = (ego_m / CELL_M).floor();
        let mut count = 0;
        for (index, grade) in grades.iter_mut().enumerate() {
            let cell = first + index as f64;
            if (cell + 1.0) * CELL_M > self.ends_at_m {
                break;
            }
            *grade = self.grade(cell);
            count += 1;
        }
        Ahead { first_cell_m: first * CELL_M, count }
    }

    fn grade(&self, cell: f64) -> f64 {
        let from_m = cell * CELL_M - self.shift_m;
        let exact = self.road.mean_grade(from_m, from_m + CELL_M);
        if self.noise == 0.0 { exact } else { exact + self.noise * error(self.seed, cell) }
    }
}

/// A standard normal number for each cell, always the same for one seed (Box and Muller 1958).
fn error(seed: u64, cell: f64) -> f64 {
    let stream = (cell as i64).unsigned_abs().wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut generator = Pcg64::seed_from_u64(seed.wrapping_add(stream));
    random::normal(&mut generator)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ahead(map: &RoadMap, ego_m: f64) -> (Ahead, [f64; MAX_PREVIEW_CELLS]) {
        let mut grades = [0.0; MAX_PREVIEW_CELLS];
        let ahead = map.ahead(ego_m, &mut grades);
        (ahead, grades)
    }

    fn grades(map: &RoadMap, ego_m: f64) -> [f64; MAX_PREVIEW_CELLS] {
        ahead(map, ego_m).1
    }

    fn map(keys: &str) -> RoadMap {
        let text = format!(
            "schema_version = 1\nname = \"hills\"\nplant.vehicle = \"jh6-49t\"\n\
             road.builtin = \"hills-60km\"\n{keys}\n"
        );
        RoadMap::new(&Scenario::parse("hills", &text).expect("a right scenario")).expect("a road")
    }

    #[test]
    fn two_kilometres_ahead_are_known_from_anywhere_in_a_cell() {
        let map = map("");
        for ego_m in [0.0, 49.9, 1234.5] {
            let (ahead, grades) = ahead(&map, ego_m);
            assert!(ahead.first_cell_m <= ego_m && ego_m < ahead.first_cell_m + CELL_M);
            assert!(ahead.first_cell_m + ahead.count as f64 * CELL_M >= ego_m + 2000.0);
            let middle_m = ahead.first_cell_m + 10.5 * CELL_M;
            assert!((grades[10] - map.road.grade(middle_m)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_map_ends_in_whole_cells() {
        let map = map("v2x.preview.ends_at_m = 1020");
        assert_eq!([0.0, 960.0, 1010.0, 5000.0].map(|x| ahead(&map, x).0.count), [20, 1, 0, 0]);
    }

    #[test]
    fn a_shift_moves_and_noise_stays_where_it_is() {
        let (exact, shifted) = (map(""), map("v2x.preview.shift_m = 100"));
        assert_eq!(grades(&exact, 1000.0)[..40], grades(&shifted, 1100.0)[..40]);
        let noisy = map("v2x.preview.noise_percent = 0.25");
        assert_eq!(grades(&noisy, 1000.0)[2..40], grades(&noisy, 1100.0)[..38]);
        let errors: Vec<f64> = (0..1000)
            .map(|cell| noisy.grade(f64::from(cell)) - exact.grade(f64::from(cell)))
            .collect();
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        assert!((variance.sqrt() / 0.0025 - 1.0).abs() < 0.1, "{}", variance.sqrt());
    }
}
