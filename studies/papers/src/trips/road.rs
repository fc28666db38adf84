//! The road that a trip is driven on.

use controller::law::{MAX_CELLS, Preview};
use scenario::grade::{Alignment, GradeProfile, generate};

/// Length of a cell of a profile, m.
const CELL_M: f64 = 50.0;

/// Grades of a road in cells of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct Road {
    cell_m: f64,
    grades: Vec<f64>,
}

impl Road {
    /// A road of cells of `cell_m`, each with a grade (rise over run).
    ///
    /// # Panics
    /// If there is no cell or cells have no length.
    pub fn new(cell_m: f64, grades: Vec<f64>) -> Self {
        assert!(cell_m > 0.0 && !grades.is_empty(), "a road has cells of positive length");
        Self { cell_m, grades }
    }

    /// A profile in cells of 50 m; what does not fill a cell at its end is left out.
    ///
    /// # Panics
    /// If the profile is shorter than a cell.
    pub fn from_profile(profile: &GradeProfile) -> Self {
        let count = (profile.end_m() / CELL_M + 1e-9) as usize;
        let cell = |index: usize| {
            let from_m = index as f64 * CELL_M;
            profile.mean_grade(from_m, from_m + CELL_M)
        };
        Self::new(CELL_M, (0..count).map(cell).collect())
    }

    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    pub fn grades(&self) -> &[f64] {
        &self.grades
    }

    pub fn length_m(&self) -> f64 {
        self.cell_m * self.grades.len() as f64
    }

    /// Grade at a position; beyond its ends the road goes on as it ends.
    pub fn grade(&self, position_m: f64) -> f64 {
        let index = (position_m / self.cell_m).max(0.0) as usize;
        self.grades[index.min(self.grades.len() - 1)]
    }

    /// Content of a map from the cell under `position_m` on: `reach_m` at most, less where the road ends.
    pub fn preview(&self, position_m: f64, reach_m: f64) -> Preview {
        let first = ((position_m / self.cell_m).max(0.0) as usize).min(self.grades.len());
        // One cell more, since the first one is partly behind.
        let wanted = (reach_m / self.cell_m).ceil() as usize + 1;
        let count = wanted.min(MAX_CELLS).min(self.grades.len() - first);
        let mut preview = Preview {
            start_m: first as f64 * self.cell_m,
            cell_m: self.cell_m,
            count,
            ..Preview::default()
        };
        preview.grades[..count].copy_from_slice(&self.grades[first..first + count]);
        preview
    }
}

/// A hilly road of a seed, like the given one of the paper's scenarios.
pub fn generated(length_m: f64, seed: u64) -> Road {
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
