//! Where the road ends, as far as standing objects show it.
//!
//! A moving echo from beyond a row of standing objects is the mirror image of a vehicle in a guard rail,
//! or a vehicle on another road: no track begins there.

/// Standing echoes nearer to the lane's centre are no edge, m.
const NEAREST_M: f64 = 4.5;
/// Weight of an object inside the known edge, and of one outside it.
const INWARD: f64 = 0.3;
const OUTWARD: f64 = 0.005;
/// Room between the edge and what counts as beyond, m.
const MARGIN_M: f64 = 1.0;

/// The edges on both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadEdge {
    left_m: Option<f64>,
    right_m: Option<f64>,
}

impl RoadEdge {
    /// Takes note of a standing object.
    pub fn observe(&mut self, lateral_m: f64) {
        let distance_m = lateral_m.abs();
        if distance_m < NEAREST_M {
            return;
        }
        let edge = if lateral_m > 0.0 { &mut self.left_m } else { &mut self.right_m };
        *edge = Some(match *edge {
            None => distance_m,
            Some(known_m) => {
                let weight = if distance_m < known_m { INWARD } else { OUTWARD };
                known_m + weight * (distance_m - known_m)
            }
        });
    }

    /// A lateral position, m, is off the road.
    #[must_use]
    pub fn is_beyond(&self, lateral_m: f64) -> bool {
        let edge = if lateral_m > 0.0 { self.left_m } else { self.right_m };
        edge.is_some_and(|edge_m| lateral_m.abs() > edge_m + MARGIN_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_is_where_the_nearest_objects_stand() {
        let mut edge = RoadEdge::default();
        assert!(!edge.is_beyond(40.0));
        for k in 0..100 {
            edge.observe(8.0 + f64::from(k % 4));
            edge.observe(0.5);
        }
        assert!(edge.is_beyond(10.0) && !edge.is_beyond(8.5) && !edge.is_beyond(-40.0));
    }
}
