//! The edges of the road beside the course, as standing objects show them, and the place from which they mislead.
//!
//! An object counts for the edge of its side. The course is followed from the ego on: an object on the road says that
//! the road bends otherwise. Objects beyond it may be of the other side, and do not count for a while.

use super::course_numbers::CourseNumbers;

/// Distance along the course within which two scans show the same object, m. Chosen: the radar's errors and a scan's way.
const SAME_M: f64 = 5.0;

/// The edges of both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edges {
    left: Edge,
    right: Edge,
    doubt: Doubt,
}

/// The edge of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Edge {
    /// Its place to the left of the course, m.
    d_m: f64,
    objects: u32,
}

/// An object that stands on the road.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Doubt {
    /// Its place on the course, m; infinite without such an object.
    from_m: f64,
    /// Scans that showed it.
    scans: u32,
    /// Time for which it still counts, s.
    left_s: f64,
}

/// Meaning of a standing object for the course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    /// It is not known to be of an edge.
    Nothing,
    /// It is of an edge, and this far to the left of it, m.
    OfEdge {
        /// Distance to the left of the edge, m.
        off_m: f64,
    },
    /// It stands on the road, or beyond an object that does.
    OnRoad {
        /// Enough scans have shown it now: the course there is wrong.
        is_certain: bool,
    },
}

impl Doubt {
    const NONE: Self = Self { from_m: f64::INFINITY, scans: 0, left_s: 0.0 };
}

impl Default for Edges {
    fn default() -> Self {
        Self { left: Edge::default(), right: Edge::default(), doubt: Doubt::NONE }
    }
}

impl Edges {
    /// The ego moves on by `way_m` in `dt_s`.
    pub fn advance(&mut self, dt_s: f64, way_m: f64) {
        self.doubt.from_m -= way_m;
        self.doubt.left_s -= dt_s;
        if self.doubt.left_s <= 0.0 {
            self.doubt = Doubt::NONE;
        }
    }

    /// A strong echo stands at this place of the course: what was seen there is a vehicle, and says nothing of the road.
    pub fn take_vehicle(&mut self, sigma_m: f64) {
        if (sigma_m - self.doubt.from_m).abs() < SAME_M {
            self.doubt = Doubt::NONE;
        }
    }

    /// Takes in an object at a place of the course, which is known there within `reach_m`.
    pub fn take(
        &mut self,
        (sigma_m, d_m): (f64, f64),
        reach_m: f64,
        numbers: &CourseNumbers,
    ) -> Meaning {
        // With a course so doubtful the object may be of the other side.
        if reach_m > numbers.post_reach_most_m {
            return Meaning::Nothing;
        }
        if self.doubt.scans > 1 && sigma_m > self.doubt.from_m {
            return Meaning::OnRoad { is_certain: false };
        }
        let are_known = self.left.objects > 0 && self.right.objects > 0;
        if are_known && (self.right.d_m + reach_m..self.left.d_m - reach_m).contains(&d_m) {
            let is_same = (sigma_m - self.doubt.from_m).abs() < SAME_M;
            let scans = if is_same { self.doubt.scans + 1 } else { 1 };
            self.doubt = Doubt { from_m: sigma_m, scans, left_s: numbers.doubt_s };
            return Meaning::OnRoad { is_certain: f64::from(scans) == numbers.doubt_scans };
        }
        let edge = if d_m < 0.0 { &mut self.right } else { &mut self.left };
        let off_m = d_m - edge.d_m;
        let could_be = (numbers.edge_from_m..numbers.edge_to_m).contains(&d_m.abs());
        if edge.objects > 0 && off_m.abs() > reach_m || edge.objects == 0 && !could_be {
            return Meaning::Nothing;
        }
        if sigma_m < numbers.edge_near_m {
            edge.objects = edge.objects.saturating_add(1);
            edge.d_m += numbers.edge_weight.max(1.0 / f64::from(edge.objects)) * off_m;
        }
        // A few objects do not show where the edge is.
        if f64::from(edge.objects) < numbers.post_scans {
            return Meaning::Nothing;
        }
        Meaning::OfEdge { off_m }
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
        assert_eq!(off_m(100.0, 10.0), Meaning::OfEdge { off_m: 1.0 });
        assert_eq!(off_m(100.0, -11.0), Meaning::OfEdge { off_m: -2.0 });
        assert_eq!(off_m(100.0, 11.6), Meaning::Nothing);
        let first = Edges::default().take((100.0, 4.9), REACH_M, &NUMBERS);
        assert_eq!(first, Meaning::Nothing, "the next lane");
    }

    #[test]
    fn beyond_an_object_on_the_road_nothing_counts_for_a_second() {
        let mut edges = known();
        let on_road = Meaning::OnRoad { is_certain: false };
        let of_edge = Meaning::OfEdge { off_m: 0.5 };
        assert_eq!(edges.take((90.0, 6.4), REACH_M, &NUMBERS), on_road);
        assert_eq!(edges.take((91.0, 9.5), REACH_M, &NUMBERS), of_edge, "one echo may be clutter");
        assert_eq!(edges.take((84.9, 6.4), REACH_M, &NUMBERS), on_road);
        assert_eq!(edges.take((91.0, 9.5), REACH_M, &NUMBERS), of_edge, "another place");
        assert_eq!(edges.take((89.8, 6.4), REACH_M, &NUMBERS), on_road);
        assert_eq!(edges.take((90.0, 6.4), REACH_M, &NUMBERS), on_road);
        assert_eq!(edges.take((89.0, 9.5), REACH_M, &NUMBERS), of_edge);
        assert_eq!(edges.take((91.0, 9.5), REACH_M, &NUMBERS), on_road);
        edges.advance(0.5, 10.0);
        assert_eq!(edges.take((81.0, 9.5), REACH_M, &NUMBERS), on_road);
        edges.advance(0.5, 10.0);
        assert_eq!(edges.take((71.0, 9.5), REACH_M, &NUMBERS), of_edge);
    }

    #[test]
    fn it_is_certain_once_at_the_fifth_scan() {
        let mut edges = known();
        let mut certain = Vec::new();
        for scan in 0..8 {
            let meaning = edges.take((60.0 - f64::from(scan), 0.0), REACH_M, &NUMBERS);
            certain.push(meaning == Meaning::OnRoad { is_certain: true });
            edges.advance(0.05, 1.0);
        }
        assert_eq!(certain, [false, false, false, false, true, false, false, false]);
    }

    #[test]
    fn a_strong_echo_at_the_same_place_ends_the_doubt() {
        let mut edges = known();
        for _ in 0..3 {
            edges.take((60.0, 0.5), REACH_M, &NUMBERS);
        }
        edges.take_vehicle(66.0);
        let beyond = edges.take((90.0, 9.5), REACH_M, &NUMBERS);
        assert_eq!(beyond, Meaning::OnRoad { is_certain: false }, "another vehicle");
        edges.take_vehicle(64.0);
        assert_eq!(edges.take((90.0, 9.5), REACH_M, &NUMBERS), Meaning::OfEdge { off_m: 0.5 });
    }

    #[test]
    fn a_doubtful_course_says_nothing_of_an_object() {
        let mut edges = known();
        assert_eq!(edges.take((60.0, 0.0), 8.1, &NUMBERS), Meaning::Nothing);
        assert_eq!(edges, known());
    }
}
