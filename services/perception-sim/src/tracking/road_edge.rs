//! The road's edges, as standing objects show them.
//!
//! A moving echo from beyond a row of standing objects is a mirror image in a guard rail. Or it is a vehicle on another
//! road. No track begins there.

use super::numbers::Numbers;

/// The edges on both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadEdge {
    left_m: Option<f64>,
    right_m: Option<f64>,
}

impl RoadEdge {
    /// Takes note of a standing object.
    pub fn observe(&mut self, lateral_m: f64, numbers: &Numbers) {
        let distance_m = lateral_m.abs();
        if distance_m < numbers.edge_from_m {
            return;
        }
        let edge = if lateral_m > 0.0 { &mut self.left_m } else { &mut self.right_m };
        *edge = Some(match *edge {
            None => distance_m,
            Some(known_m) => {
                let Numbers { edge_inward, edge_outward, .. } = *numbers;
                let weight = if distance_m < known_m { edge_inward } else { edge_outward };
                known_m + weight * (distance_m - known_m)
            }
        });
    }

    /// A lateral position, m, is off the road.
    #[must_use]
    pub fn is_beyond(&self, lateral_m: f64, numbers: &Numbers) -> bool {
        let edge = if lateral_m > 0.0 { self.left_m } else { self.right_m };
        edge.is_some_and(|edge_m| lateral_m.abs() > edge_m + numbers.edge_margin_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_is_where_the_nearest_objects_stand() {
        let mut edge = RoadEdge::default();
        assert!(!edge.is_beyond(40.0, &Numbers::DEFAULT));
        for k in 0..100 {
            edge.observe(8.0 + f64::from(k % 4), &Numbers::DEFAULT);
            edge.observe(0.5, &Numbers::DEFAULT);
        }
        let is_beyond = |lateral_m| edge.is_beyond(lateral_m, &Numbers::DEFAULT);
        assert!(is_beyond(10.0) && !is_beyond(8.5) && !is_beyond(-40.0));
    }

    #[test]
    fn an_edge_comes_in_fast_goes_out_slowly_and_has_a_margin() {
        let numbers = &Numbers::DEFAULT;
        let mut edge = RoadEdge::default();
        let mut after = |lateral_m: f64| {
            edge.observe(lateral_m, numbers);
            (edge.left_m, edge.right_m)
        };
        assert_eq!(after(4.4), (None, None), "the next lane");
        assert_eq!(after(8.0), (Some(8.0), None));
        assert_eq!(after(-4.5), (Some(8.0), Some(4.5)));
        // 0.3 of the way in, 0.005 of the way out.
        assert_eq!(after(7.0).0, Some(8.0 - 0.3));
        assert_eq!(after(9.7).0, Some(7.7 + 0.005 * 2.0));
        let edge = RoadEdge { left_m: Some(8.0), right_m: Some(5.0) };
        for (lateral_m, beyond) in [(8.9, false), (9.1, true), (-5.9, false), (-6.1, true)] {
            assert_eq!(edge.is_beyond(lateral_m, numbers), beyond, "{lateral_m}");
        }
    }
}
