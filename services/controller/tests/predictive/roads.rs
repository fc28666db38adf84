//! The roads of these tests.

use controller::laws::truck::route::Road;
use scenario::grade::{Alignment, GradeProfile, HILLS_60KM, Point, generate};

/// Set speed, m/s.
pub(crate) const SET_MPS: f64 = 75.0 / 3.6;

/// The given road of 60 km.
pub(crate) fn given() -> Road {
    let numbers = |line: &str| -> Vec<f64> { line.split(',').flat_map(str::parse).collect() };
    let rows = HILLS_60KM.lines().map(numbers).filter(|row| row.len() == 2);
    let points = rows.map(|row| Point { distance_m: row[0], height_m: row[1] }).collect();
    Road::from_profile(&GradeProfile::new(points).expect("the road that is shipped is sound"))
}

/// A hilly road.
pub(crate) fn generated(length_m: f64, seed: u64) -> Road {
    let alignment = Alignment {
        length_m,
        grade_sigma: 0.0138,
        max_grade: 0.03,
        tangent_m: [300.0, 1500.0],
        curve_m: 300.0,
        closed: true,
    };
    Road::from_profile(&generate(&alignment, seed))
}
