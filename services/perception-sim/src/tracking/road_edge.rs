//! The road's edges, as standing objects show them.
//!
//! A moving echo from beyond a row of standing objects is a mirror image in a guard rail or a vehicle on another
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
}
