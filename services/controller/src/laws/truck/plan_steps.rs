//! Ends of the steps of a plan.
//!
//! They end at edges of the map's cells, where the grade changes. Between edges the speed has neither peak nor dip. A
//! step over two cells hides the peak between them. The truck then brakes there at its limit although the plan does
//! not. With errors of 1 m in the heights that cost 1.3 points of fuel. Near the truck a step is a cell; later ones,
//! which are planned again before they are driven, are longer.

use crate::law::{MAX_SEGMENTS, Preview};

/// Length of a step that begins before this distance, m: (before, length).
const LENGTHS_M: [(f64, f64); 3] = [(400.0, 50.0), (1200.0, 100.0), (f64::INFINITY, 200.0)];
/// Shortest first step, m: its torque has to act before the next plan.
const SHORTEST_M: f64 = 25.0;
/// Edges are no further apart, m: a longer cell is divided.
const LONGEST_EDGE_M: f64 = 100.0;

/// Ends of the steps, m, in order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanSteps {
    start_m: f64,
    ends_m: [f64; MAX_SEGMENTS],
    len: usize,
}

impl PlanSteps {
    /// Steps from `start_m` on, as far as the map and `horizon_m` reach.
    pub(crate) fn new(preview: &Preview, start_m: f64, horizon_m: f64) -> Self {
        let edge_m = preview.cell_m / (preview.cell_m / LONGEST_EDGE_M).ceil();
        let edges_to = |end_m: f64| (end_m - preview.start_m) / edge_m;
        let end_m = preview.end_m().min(start_m + horizon_m);
        let last_edge = (edges_to(end_m) + 1e-6).floor();
        let mut steps = Self { start_m, ends_m: [start_m; MAX_SEGMENTS], len: 0 };
        let mut edge = edges_to(start_m + SHORTEST_M).ceil();
        while edge <= last_edge && steps.len < MAX_SEGMENTS {
            let end_m = preview.start_m + edge_m * edge;
            steps.ends_m[steps.len] = end_m;
            steps.len += 1;
            let length_m = LENGTHS_M.iter().find(|(before_m, _)| end_m - start_m < *before_m);
            let edges = (length_m.map_or(edge_m, |(_, length_m)| *length_m) / edge_m).ceil();
            // The last step is as long as what is left.
            edge = if edge < last_edge { (edge + edges).min(last_edge) } else { edge + edges };
        }
        steps
    }

    /// Their number.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Start and end of a step, m.
    pub(crate) fn step_m(&self, index: usize) -> (f64, f64) {
        let from_m = if index == 0 { self.start_m } else { self.ends_m[index - 1] };
        (from_m, self.ends_m[index])
    }

    /// End of the last one, m.
    pub(crate) fn end_m(&self) -> f64 {
        self.ends_m[..self.len].last().copied().unwrap_or(self.start_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HORIZON_M: f64 = 2000.0;

    fn lengths_m(cell_m: f64, count: usize, start_m: f64) -> Vec<f64> {
        let preview = Preview { start_m: 1000.0, cell_m, count, ..Preview::default() };
        let steps = PlanSteps::new(&preview, start_m, HORIZON_M);
        (0..steps.len()).map(|index| steps.step_m(index)).map(|(from, to)| to - from).collect()
    }

    #[test]
    fn they_end_at_edges_of_cells_and_grow_with_the_distance() {
        let lengths = lengths_m(50.0, 41, 1010.0);
        let expected = [vec![40.0], vec![50.0; 8], vec![100.0; 8], vec![200.0; 3], vec![110.0]];
        let whole: f64 = lengths.iter().sum();
        assert_eq!(lengths[..17], expected.concat()[..17]);
        assert!((1940.0..=2000.0).contains(&whole), "{lengths:?}");
    }

    #[test]
    fn the_first_one_is_never_short() {
        assert_eq!(lengths_m(50.0, 41, 1024.0)[0], 26.0);
        assert_eq!(lengths_m(50.0, 41, 1026.0)[0], 74.0);
    }

    #[test]
    fn no_map_is_too_fine_too_coarse_or_too_short() {
        for cell_m in [1.0, 7.0, 10.0, 30.0, 50.0, 80.0, 170.0, 1000.0] {
            for count in [1_u32, 2, 40, 64] {
                let lengths = lengths_m(cell_m, count as usize, 1003.0);
                let known_m = (cell_m * f64::from(count) - 3.0).clamp(0.0, HORIZON_M);
                let whole: f64 = lengths.iter().sum();
                assert!(whole <= known_m + 1e-3, "{cell_m} {count}: {lengths:?}");
                assert!(whole > known_m - 101.0, "{cell_m} {count}: {lengths:?}");
            }
        }
    }
}
