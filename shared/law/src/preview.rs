//! The road ahead as the map describes it.

/// Most cells of a preview: 3.2 km of 50 m.
pub const MAX_CELLS: usize = 64;

/// Grades of the road ahead, in cells of equal length.
///
/// The map decides where it starts and how far it reaches. The road outside is unknown, never flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preview {
    /// Start of the first cell, m in the frame of `Ego::position_m`.
    pub start_m: f64,
    pub cell_m: f64,
    /// Mean grade (rise over run) of each cell; `count` of them are valid.
    pub grades: [f64; MAX_CELLS],
    pub count: usize,
}

/// Steepest grade that a road can have, rise over run.
const STEEPEST: f64 = 0.25;

impl Default for Preview {
    fn default() -> Self {
        Self { start_m: 0.0, cell_m: 50.0, grades: [0.0; MAX_CELLS], count: 0 }
    }
}

impl Preview {
    /// True if it describes a road: finite, of positive cell length, no steeper than any road is.
    pub fn is_sound(&self) -> bool {
        self.start_m.is_finite()
            && self.cell_m.is_finite()
            && self.cell_m >= 1.0
            && (1..=MAX_CELLS).contains(&self.count)
            && self.grades[..self.count].iter().all(|grade| grade.abs() <= STEEPEST)
    }

    pub fn end_m(&self) -> f64 {
        self.start_m + self.cell_m * self.count as f64
    }

    /// Grade at a position; `None` outside.
    pub fn grade(&self, position_m: f64) -> Option<f64> {
        let place = (position_m - self.start_m) / self.cell_m;
        if place.is_nan() || place < 0.0 {
            return None;
        }
        self.grades[..self.count].get(place as usize).copied()
    }

    /// Mean grade from `from_m` to `to_m`; `None` unless all of it is known.
    pub fn mean_grade(&self, from_m: f64, to_m: f64) -> Option<f64> {
        let known = from_m >= self.start_m && to_m <= self.end_m() + 1e-6;
        if !(known && to_m > from_m) {
            return None;
        }
        let (a, b) = (self.rise_m(from_m), self.rise_m(to_m));
        Some((b - a) / (to_m - from_m))
    }

    /// Height above the preview's start, m.
    fn rise_m(&self, position_m: f64) -> f64 {
        let place = ((position_m - self.start_m) / self.cell_m).clamp(0.0, self.count as f64);
        let whole = place as usize;
        let rest: f64 = if whole < self.count { self.grades[whole] } else { 0.0 };
        let full: f64 = self.grades[..whole].iter().sum();
        self.cell_m * (full + rest * (place - whole as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preview(grades: &[f64]) -> Preview {
        let mut preview = Preview { start_m: 1000.0, count: grades.len(), ..Preview::default() };
        preview.grades[..grades.len()].copy_from_slice(grades);
        preview
    }

    #[test]
    fn places_outside_are_unknown() {
        let preview = preview(&[0.01, 0.02]);
        assert_eq!(preview.grade(999.9), None);
        assert_eq!(preview.grade(1049.0), Some(0.01));
        assert_eq!(preview.grade(1050.0), Some(0.02));
        assert_eq!(preview.grade(1100.0), None);
        assert_eq!(preview.grade(f64::NAN), None);
        assert_eq!(preview.mean_grade(1050.0, 1101.0), None);
        assert_eq!(preview.mean_grade(f64::NAN, 1050.0), None);
    }

    #[test]
    fn means_keep_the_height() {
        let preview = preview(&[0.01, 0.03, -0.02]);
        let mean = preview.mean_grade(1025.0, 1125.0).expect("known");
        assert!((mean - (25.0 * 0.01 + 50.0 * 0.03 - 25.0 * 0.02) / 100.0).abs() < 1e-15);
        assert!(preview.mean_grade(1000.0, 1150.0).is_some());
    }

    #[test]
    fn a_map_that_is_no_road_is_recognised() {
        assert!(preview(&[0.01]).is_sound());
        assert!(!preview(&[]).is_sound());
        assert!(!preview(&[0.3]).is_sound());
        assert!(!preview(&[f64::NAN]).is_sound());
        assert!(!Preview { cell_m: 0.0, ..preview(&[0.01]) }.is_sound());
    }
}
