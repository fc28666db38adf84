//! The edges of the road beside the course, as standing objects show them. An object counts for the edge of its side.

use super::course_numbers::CourseNumbers;

/// The edges of both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Edges {
    left: Edge,
    right: Edge,
}

/// The edge of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Edge {
    /// Its place to the left of the course, m.
    d_m: f64,
    objects: u32,
}

impl Edges {
    /// Takes in an object at a place of the course, which is known there within `reach_m`. Returns how far it is to the
    /// left of its edge, m; `None` if it is not known to be of one.
    pub fn take(
        &mut self,
        (sigma_m, d_m): (f64, f64),
        reach_m: f64,
        numbers: &CourseNumbers,
    ) -> Option<f64> {
        // With a course so doubtful the object may be of the other side.
        if reach_m > numbers.post_reach_most_m {
            return None;
        }
        let edge = if d_m < 0.0 { &mut self.right } else { &mut self.left };
        let off_m = d_m - edge.d_m;
        let could_be = (numbers.edge_from_m..numbers.edge_to_m).contains(&d_m.abs());
        if edge.objects > 0 && off_m.abs() > reach_m || edge.objects == 0 && !could_be {
            return None;
        }
        if sigma_m < numbers.edge_near_m {
            edge.objects = edge.objects.saturating_add(1);
            edge.d_m += numbers.edge_weight.max(1.0 / f64::from(edge.objects)) * off_m;
        }
        // A few objects do not show where the edge is.
        if f64::from(edge.objects) < numbers.post_scans {
            return None;
        }
        Some(off_m)
    }

    /// The same with another left edge: its place, m, and the number of its objects.
    #[cfg(test)]
    pub fn with_left(self, d_m: f64, objects: u32) -> Self {
        Self { left: Edge { d_m, objects }, ..self }
    }

    /// Place, m, and number of objects of the left edge and the right one.
    #[cfg(test)]
    pub fn known(&self) -> [(f64, u32); 2] {
        [&self.left, &self.right].map(|edge| (edge.d_m, edge.objects))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: CourseNumbers = CourseNumbers::DEFAULT;
    const REACH_M: f64 = 2.5;

    /// Edges 9 m to both sides, which count.
    fn known() -> Edges {
        let mut edges = Edges::default();
        for _ in 0..25 {
            edges.take((20.0, 9.0), REACH_M, &NUMBERS);
            edges.take((20.0, -9.0), REACH_M, &NUMBERS);
        }
        edges
    }

    #[test]
    fn an_object_within_reach_of_its_edge_counts() {
        let off_m = |sigma_m, d_m| known().take((sigma_m, d_m), REACH_M, &NUMBERS);
        assert_eq!(off_m(100.0, 10.0), Some(1.0));
        assert_eq!(off_m(100.0, -11.0), Some(-2.0));
        assert_eq!(off_m(100.0, 11.6), None);
        let first = Edges::default().take((100.0, 4.9), REACH_M, &NUMBERS);
        assert_eq!(first, None, "the next lane");
    }

    #[test]
    fn a_doubtful_course_says_nothing_of_an_object() {
        let mut edges = known();
        assert_eq!(edges.take((60.0, 0.0), 8.1, &NUMBERS), None);
        assert_eq!(edges, known());
    }
}
