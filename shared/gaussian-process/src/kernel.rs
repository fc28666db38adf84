//! The covariance of two points.

use multiversion::multiversion;

use crate::lanes::{self, LANES, Lanes};

/// Kind of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number: near values are alike.
    Number,
    /// A word: two values are the same or not. Coordinates in one of `n` equal parts of the unit interval are one word.
    Word(usize),
}

/// Parameters of the covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperparameters {
    /// Length of each coordinate.
    pub lengths: Vec<f64>,
    /// Standard deviation of the function.
    pub signal: f64,
    /// Standard deviation of the noise.
    pub noise: f64,
}

impl Kind {
    /// Squared difference of two coordinates; of words 0 or 1.
    pub(crate) fn squared(self, a: f64, b: f64) -> f64 {
        let (a, b) = (self.mark(a), self.mark(b));
        match self {
            Self::Number => (a - b) * (a - b),
            Self::Word(_) if a == b => 0.0,
            Self::Word(_) => 1.0,
        }
    }

    /// A coordinate that only what is the same has: a number itself, the place of a word.
    pub(crate) fn mark(self, x: f64) -> f64 {
        match self {
            Self::Number => x,
            Self::Word(count) => ((x * count as f64) as usize).min(count - 1) as f64,
        }
    }
}

const ROOT_5: f64 = 2.236_067_977_499_79;

/// Matérn's covariance at a squared distance, for a variance of 1.
pub(crate) fn matern(squared: f64) -> f64 {
    let r = ROOT_5 * squared.sqrt();
    (1.0 + r + r * r / 3.0) * libm::exp(-r)
}

/// Matérn's covariances at squared distances, and their derivatives by the logarithm of a length, over the length's own
/// part of the squared distance.
#[inline(always)]
fn with_slopes(squared: &Lanes) -> [Lanes; 2] {
    let (mut r, mut below) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        r[lane] = ROOT_5 * squared[lane].sqrt();
        below[lane] = -r[lane];
    }
    let falls = lanes::exp(&below);
    let mut both = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let r = r[lane];
        both[0][lane] = (1.0 + r + r * r / 3.0) * falls[lane];
        both[1][lane] = 5.0 / 3.0 * (1.0 + r) * falls[lane];
    }
    both
}

/// Covariances and slopes, times `variance`, of pairs of points by the squared differences of their coordinates: for
/// each lane of pairs as many numbers as there are inverse squares of lengths.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn covariances_and_slopes(
    squares: &[Lanes],
    inverse: &[f64],
    variance: f64,
    found: &mut [Vec<Lanes>; 2],
) {
    for pairs in squares.chunks_exact(inverse.len()) {
        let mut squared = [0.0; LANES];
        for (square, inverse) in pairs.iter().zip(inverse) {
            for lane in 0..LANES {
                squared[lane] += square[lane] * inverse;
            }
        }
        let mut both = with_slopes(&squared);
        for (found, values) in found.iter_mut().zip(&mut both) {
            for value in values.iter_mut() {
                *value *= variance;
            }
            found.push(*values);
        }
    }
}

/// Covariances of the points in the lanes of `marks`, which has a row for each coordinate, with other points.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn covariances(
    (kinds, inverse, variance): (&[Kind], &[f64], f64),
    marks: &[Lanes],
    others: &[Vec<f64>],
    found: &mut Vec<Lanes>,
) {
    for other in others {
        let mut squared = [0.0; LANES];
        for (((kind, inverse), marks), other) in kinds.iter().zip(inverse).zip(marks).zip(other) {
            let other = kind.mark(*other);
            match kind {
                Kind::Number => {
                    for lane in 0..LANES {
                        let off = marks[lane] - other;
                        squared[lane] += off * off * inverse;
                    }
                }
                Kind::Word(_) => {
                    for lane in 0..LANES {
                        squared[lane] += if marks[lane] == other { 0.0 } else { *inverse };
                    }
                }
            }
        }
        let [mut values, _] = with_slopes(&squared);
        for value in &mut values {
            *value *= variance;
        }
        found.push(values);
    }
}

/// Squared distance with these inverse squares of the lengths.
pub(crate) fn distance(kinds: &[Kind], inverse: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (((kind, inverse), a), b) in kinds.iter().zip(inverse).zip(a).zip(b) {
        sum += kind.squared(*a, *b) * inverse;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_the_covariance() {
        // d k / d log l at one coordinate: squared distance q = Δ²/l², d q / d log l = −2 q.
        for q in [0.01, 0.3, 2.0] {
            let h = 1e-6;
            let by_difference =
                (matern(q * libm::exp(-2.0 * h)) - matern(q * libm::exp(2.0 * h))) / (2.0 * h);
            let [covariances, slopes] = with_slopes(&[q; LANES]);
            assert!((by_difference - slopes[3] * q).abs() < 1e-6, "{q}");
            assert!((covariances[15] - matern(q)).abs() < 1e-15, "{q}");
        }
        assert_eq!(matern(0.0), 1.0);
    }

    #[test]
    fn covariances_side_by_side_are_those_one_by_one() {
        let (kinds, inverse) = ([Kind::Number, Kind::Word(4), Kind::Number], [3.0, 0.5, 11.0]);
        let part = |k: usize, by: f64| (k as f64 * by).fract();
        let point = |k: usize| vec![part(k, 0.754_877), part(k, 0.569_84), part(k, 0.433_9)];
        let (points, others): (Vec<_>, Vec<_>) =
            ((0..LANES).map(point).collect(), (40..70).map(point).collect());
        let marks: Vec<Lanes> = kinds
            .iter()
            .enumerate()
            .map(|(place, kind)| std::array::from_fn(|lane| kind.mark(points[lane][place])))
            .collect();
        let mut found = Vec::new();
        covariances((&kinds, &inverse, 2.0), &marks, &others, &mut found);
        for (other, found) in others.iter().zip(&found) {
            for (point, found) in points.iter().zip(found) {
                let expected = 2.0 * matern(distance(&kinds, &inverse, point, other));
                assert!((found - expected).abs() < 1e-14, "{found} {expected}");
            }
        }
    }

    #[test]
    fn words_are_the_same_or_not() {
        let kind = Kind::Word(3);
        assert_eq!((kind.squared(0.1, 0.3), kind.squared(0.3, 0.35)), (0.0, 1.0));
        assert_eq!(kind.squared(0.99, 1.0), 0.0);
    }
}
