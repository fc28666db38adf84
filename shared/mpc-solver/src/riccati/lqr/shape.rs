//! Structure of dynamics and cost, known at compile time. Products with one and sums with zero cost
//! nothing, and dependent results come earlier.

use crate::problem::Problem;

/// Structure known at compile time.
pub(in crate::riccati) type Shape = u8;
/// No structure.
pub(in crate::riccati) const GENERAL: Shape = 0;
/// The first two states integrate (`a_00 = a_11 = 1`), and the input acts on the last state only.
pub(in crate::riccati) const CHAIN: Shape = 2;
/// [`CHAIN`] with `a_02 = 0` (a constant gap) and `s = 0` (no cost of jerk); the bits are those of
/// a chain.
pub(in crate::riccati) const PLAIN: Shape = 3;

pub(super) fn shape_of(problem: &Problem) -> Shape {
    let is_integrating = [problem.a[0][0], problem.a[1][1]] == [1.0; 2];
    let is_last_only = problem.b[..2] == [0.0; 2];
    let is_plain = problem.a[0][2] == 0.0 && problem.s == [0.0; 3];
    match (is_integrating, is_last_only) {
        (true, true) if is_plain => PLAIN,
        (true, true) => CHAIN,
        _ => GENERAL,
    }
}
