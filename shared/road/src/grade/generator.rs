//! Seeded hilly highways, made the way highways are: tangents of constant grade joined by vertical
//! curves.
//!
//! Take the mean over a window of length `R` of a grade that is constant by pieces. It is continuous and changes by at
//! most `2 g_max / R` per metre. The window is the length of the vertical curves, so the curvature is bounded.

use super::{GradeProfile, Point};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;

/// Distance between two points of a generated road, m.
const SPACING_M: f64 = 50.0;
/// Step in which the grades are averaged, m.
const FINE_M: f64 = 5.0;

/// Recipe of a generated road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    pub length_m: f64,
    /// Standard deviation of the tangents' grades.
    pub grade_sigma: f64,
    pub max_grade: f64,
    /// Shortest and longest tangent, m.
    pub tangent_m: [f64; 2],
    /// Length of the vertical curves, m.
    pub curve_m: f64,
    /// True if the road ends as high as it began.
    pub closed: bool,
}

/// The road of a seed: the same on every machine.
pub fn generate(alignment: &Alignment, seed: u64) -> GradeProfile {
    let mut random = Pcg64::seed_from_u64(seed);
    let count = (alignment.length_m / FINE_M).round() as usize;
    let raw = tangents(alignment, count, &mut random);
    let mut grades = smoothed(&raw, (alignment.curve_m / FINE_M).round() as usize | 1);
    if alignment.closed {
        close(&mut grades, alignment.max_grade);
    }
    let per_point = (SPACING_M / FINE_M) as usize;
    let mut points = vec![Point { distance_m: 0.0, height_m: 0.0 }];
    let mut height_m = 0.0;
    for (index, piece) in grades.chunks(per_point).enumerate() {
        height_m += FINE_M * piece.iter().sum::<f64>();
        let distance_m = index as f64 * SPACING_M + piece.len() as f64 * FINE_M;
        points.push(Point { distance_m, height_m });
    }
    GradeProfile::new(points).expect("distances increase and grades are bounded")
}

/// Grades constant by pieces.
fn tangents(alignment: &Alignment, count: usize, random: &mut Pcg64) -> Vec<f64> {
    let [shortest, longest] = alignment.tangent_m;
    let mut grades = Vec::with_capacity(count);
    while grades.len() < count {
        let length_m = shortest + (longest - shortest) * random::uniform(random);
        let grade = alignment.grade_sigma * random::normal(random);
        let grade = grade.clamp(-alignment.max_grade, alignment.max_grade);
        let steps = ((length_m / FINE_M).round() as usize).clamp(1, count - grades.len());
        grades.extend(std::iter::repeat_n(grade, steps));
    }
    grades
}

/// Means over a window of an odd number of steps; the ends continue as they are.
fn smoothed(raw: &[f64], window: usize) -> Vec<f64> {
    let at = |index: isize| raw[index.clamp(0, raw.len() as isize - 1) as usize];
    let half = (window / 2) as isize;
    let mean = |centre: isize| {
        (centre - half..=centre + half).map(at).sum::<f64>() / (2 * half + 1) as f64
    };
    (0..raw.len() as isize).map(mean).collect()
}

/// Takes the mean grade off, and scales what then exceeds the bound: the mean stays zero.
fn close(grades: &mut [f64], max_grade: f64) {
    let mean = grades.iter().sum::<f64>() / grades.len() as f64;
    let steepest = grades.iter().fold(0.0_f64, |most, grade| most.max((grade - mean).abs()));
    let scale = if steepest > max_grade { max_grade / steepest } else { 1.0 };
    for grade in grades {
        *grade = (*grade - mean) * scale;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HILLY: Alignment = Alignment {
        length_m: 60e3,
        grade_sigma: 0.0138,
        max_grade: 0.03,
        tangent_m: [300.0, 1500.0],
        curve_m: 300.0,
        closed: true,
    };

    #[test]
    fn a_seed_is_a_road() {
        assert_eq!(generate(&HILLY, 7), generate(&HILLY, 7));
        assert_ne!(generate(&HILLY, 7), generate(&HILLY, 8));
    }

    proptest! {
        #[test]
        fn grades_and_curvature_are_bounded_and_closed_roads_close(
            seed: u64, closed: bool, length_m in 1000.0..30e3f64, max_grade in 0.005..0.08f64,
        ) {
            let alignment = Alignment { length_m, max_grade, closed, ..HILLY };
            let road = generate(&alignment, seed);
            let grades: Vec<f64> =
                road.points().windows(2).map(|pair| road.grade(pair[0].distance_m)).collect();
            prop_assert!(grades.iter().all(|grade| grade.abs() <= max_grade + 1e-9));
            // Means over points, of a grade that changes by at most 2 g_max over a curve. A last
            // piece that is shorter than the spacing changes no faster.
            let steepest_change = 2.0 * max_grade / HILLY.curve_m * SPACING_M;
            prop_assert!(grades.windows(2).all(|g| (g[1] - g[0]).abs() <= 1.1 * steepest_change));
            prop_assert!((road.end_m() - length_m).abs() <= FINE_M);
            if closed {
                prop_assert!(road.height_m(road.end_m()).abs() < 1e-6);
            }
        }
    }
}
