//! Random roads.
//!
//! Curves follow each other. Each is a spiral, an arc and a spiral. On average every second one has a straight line of
//! 50 to 400 m before it. The radius is drawn evenly by its logarithm, the turn from 0.1 to 1.2 rad. The two spirals
//! take at most four fifths of the turn. A curve turns to a random side, but back where the road would leave ±1.2 rad
//! from its first direction. So a road never crosses itself.

use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use random::uniform;

use crate::{MIN_RADIUS_M, Piece};

/// Share of curves with a straight line before them.
const LINE_SHARE: f64 = 0.5;
/// Length of these lines, m.
const LINE_M: [f64; 2] = [50.0, 400.0];
/// Smallest and largest turn of a curve, rad.
const TURN_RAD: [f64; 2] = [0.1, 1.2];
/// Largest heading from the first direction after a curve, rad.
const MAX_HEADING_RAD: f64 = 1.2;
/// Largest share of a turn that the two spirals take.
const SPIRAL_SHARE: f64 = 0.8;

/// A kind of random road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Least length, m; the last curve is completed, and a line follows.
    pub length_m: f64,
    /// Smallest radius, m; at least 20.
    pub min_radius_m: f64,
    pub max_radius_m: f64,
    /// Shortest and longest spiral, m; shorter ones where a turn leaves no room, none if both are 0.
    pub spiral_m: [f64; 2],
}

/// The road of a seed. It begins and ends with a line.
///
/// ```
/// use road::{Axis, random::{Recipe, pieces}};
/// let recipe =
///     Recipe { length_m: 5e3, min_radius_m: 250.0, max_radius_m: 2e3, spiral_m: [30.0, 200.0] };
/// let axis = Axis::new(&pieces(&recipe, 1))?;
/// assert!((5e3..8e3).contains(&axis.length_m()));
/// # Ok::<(), road::AxisError>(())
/// ```
pub fn pieces(recipe: &Recipe, seed: u64) -> Vec<Piece> {
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut draw = |[from, to]: [f64; 2]| from + (to - from) * uniform(&mut generator);
    let radii = [recipe.min_radius_m, recipe.max_radius_m].map(|r| libm::log(r.max(MIN_RADIUS_M)));
    let mut pieces = vec![Piece::Line { length_m: draw(LINE_M) }];
    let (mut length_m, mut heading_rad) = (0.0, 0.0);
    while length_m < recipe.length_m {
        let first = pieces.len();
        if first > 1 && draw([0.0, 1.0]) < LINE_SHARE {
            pieces.push(Piece::Line { length_m: draw(LINE_M) });
        }
        let radius_m = libm::exp(draw(radii)).max(MIN_RADIUS_M);
        let turn_rad = draw(TURN_RAD);
        let spiral_m = draw(recipe.spiral_m).min(SPIRAL_SHARE * turn_rad * radius_m);
        let left = draw([-1.0, 1.0]) >= 0.0;
        let after_rad = if left { heading_rad + turn_rad } else { heading_rad - turn_rad };
        let is_left =
            if libm::fabs(after_rad) > MAX_HEADING_RAD { heading_rad < 0.0 } else { left };
        let sign = if is_left { 1.0 } else { -1.0 };
        heading_rad += sign * turn_rad;
        let curvature_perm = sign / radius_m;
        let spiral =
            |start_perm, end_perm| Piece::Spiral { length_m: spiral_m, start_perm, end_perm };
        if spiral_m > 0.0 {
            pieces.push(spiral(0.0, curvature_perm));
        }
        pieces.push(Piece::Arc { length_m: turn_rad * radius_m - spiral_m, curvature_perm });
        if spiral_m > 0.0 {
            pieces.push(spiral(curvature_perm, 0.0));
        }
        length_m += pieces[first..].iter().map(Piece::length_m).sum::<f64>();
    }
    pieces.push(Piece::Line { length_m: draw(LINE_M) });
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Axis;

    #[test]
    fn roads_of_every_recipe_are_axes() {
        for (min_radius_m, spiral_m) in [
            (20.0, [30.0, 200.0]),
            (125.0, [0.0, 0.0]),
            (250.0, [30.0, 200.0]),
            (500.0, [80.0, 80.0]),
        ] {
            let recipe =
                Recipe { length_m: 5e3, min_radius_m, max_radius_m: 8.0 * min_radius_m, spiral_m };
            for seed in 0..40 {
                let pieces = pieces(&recipe, seed);
                let axis = Axis::new(&pieces).unwrap_or_else(|error| panic!("{seed}: {error}"));
                assert!(axis.length_m() >= 5e3);
                let ends = axis.pose(axis.length_m()).heading_rad;
                assert!(ends.abs() <= MAX_HEADING_RAD + 1e-9, "{ends}");
            }
        }
    }

    #[test]
    fn seeds_differ() {
        let recipe = Recipe {
            length_m: 1e3,
            min_radius_m: 250.0,
            max_radius_m: 2e3,
            spiral_m: [30.0, 60.0],
        };
        assert_eq!(pieces(&recipe, 3), pieces(&recipe, 3));
        assert_ne!(pieces(&recipe, 3), pieces(&recipe, 4));
    }
}
