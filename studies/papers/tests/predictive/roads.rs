//! The roads of these tests.

use papers::trips::Road;
use scenario::grade::{Alignment, GradeProfile, Point, generate};
use scenario::road::HILLS_60KM;

/// Set speed, m/s.
pub(crate) const SET_MPS: f64 = 75.0 / 3.6;

/// The given road of 60 km.
pub(crate) fn given() -> Road {
    let numbers = |line: &str| -> Vec<f64> { line.split(',').flat_map(str::parse).collect() };
    let rows = HILLS_60KM.lines().map(numbers).filter(|row| row.len() == 2);
    let points = rows.map(|row| Point { distance_m: row[0], height_m: row[1] }).collect();
    Road::from_profile(&GradeProfile::new(points).expect("the road that is shipped is sound"))
}

pub(crate) use papers::trips::generated;

/// Short hills on waves of 4 to 15 km.
pub(crate) fn on_long_waves(length_m: f64, seed: u64) -> Road {
    let hills = alone(length_m, seed, 0.015, [250.0, 900.0], 300.0);
    let waves = alone(length_m, seed + 1000, 0.009, [4000.0, 15_000.0], 2000.0);
    let pairs = hills.grades().iter().zip(waves.grades());
    Road::new(hills.cell_m(), pairs.map(|(hill, wave)| hill + wave).collect())
}

fn alone(length_m: f64, seed: u64, grade_sigma: f64, tangent_m: [f64; 2], curve_m: f64) -> Road {
    let max_grade = 0.03;
    let alignment =
        Alignment { length_m, grade_sigma, max_grade, tangent_m, curve_m, closed: true };
    Road::from_profile(&generate(&alignment, seed))
}
