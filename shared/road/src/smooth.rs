//! A curve to go along, a place on it, and integrals along it.

use crate::Pose;

/// A place on a piece, in axes that begin with the piece.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct State {
    /// Along the piece, m.
    pub q_m: f64,
    pub pose: Pose,
    pub curvature_perm: f64,
    /// Change of the curvature along the curve, 1/m².
    pub rate_perm2: f64,
    pub parameter: f64,
}

/// Something smooth to go along.
pub(crate) trait Smooth {
    /// Its length in `q`, m.
    fn length_m(&self) -> f64;
    fn begin(&self) -> State;
    /// The place at `q_m`, at most a cell from another one.
    fn advance(&self, from: &State, q_m: f64) -> State;
    /// Metres along the curve for one metre of `q`.
    fn pace(&self) -> f64 {
        1.0
    }
    /// Largest error of a cell's series at its ends, m and rad. One axis beside another takes more than this one.
    fn tolerance(&self) -> (f64, f64) {
        (1e-7, 5e-8)
    }
    /// True if the curvature changes evenly.
    fn is_clothoid(&self) -> bool {
        false
    }
}

/// Gauss-Legendre quadrature with 8 points (Abramowitz and Stegun, table 25.4).
const ABSCISSAE: [f64; 4] = [
    0.183_434_642_495_649_8,
    0.525_532_409_916_329,
    0.796_666_477_413_626_7,
    0.960_289_856_497_536_3,
];
const WEIGHTS: [f64; 4] = [
    0.362_683_783_378_362,
    0.313_706_645_877_887_3,
    0.222_381_034_453_374_48,
    0.101_228_536_290_376_26,
];

/// The integral of two functions at once, by Gauss-Legendre quadrature, from `from` to `to`.
pub fn integrate(from: f64, to: f64, f: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut first, mut second) = (0.0, 0.0);
    for (abscissa, weight) in ABSCISSAE.into_iter().zip(WEIGHTS) {
        let (left, right) = (f(middle - half * abscissa), f(middle + half * abscissa));
        first += weight * (left.0 + right.0);
        second += weight * (left.1 + right.1);
    }
    (half * first, half * second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_degree_15_are_exact() {
        let (high, constant) = integrate(0.0, 2.0, |x| (libm::pow(x, 15.0), 3.0));
        assert!((high / 4096.0 - 1.0).abs() < 1e-14 && (constant - 6.0).abs() < 1e-14);
    }
}
