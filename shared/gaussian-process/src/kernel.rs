//! The covariance of two points.

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
        match self {
            Self::Number => (a - b) * (a - b),
            Self::Word(count) => {
                let word = |x: f64| ((x * count as f64) as usize).min(count - 1);
                if word(a) == word(b) { 0.0 } else { 1.0 }
            }
        }
    }
}

const ROOT_5: f64 = 2.236_067_977_499_79;

/// Matérn's covariance at a squared distance, for a variance of 1.
pub(crate) fn matern(squared: f64) -> f64 {
    let r = ROOT_5 * squared.sqrt();
    (1.0 + r + r * r / 3.0) * libm::exp(-r)
}

/// Its derivative by the logarithm of a length, over the length's own part of the squared distance.
pub(crate) fn slope(squared: f64) -> f64 {
    let r = ROOT_5 * squared.sqrt();
    5.0 / 3.0 * (1.0 + r) * libm::exp(-r)
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
            assert!((by_difference - slope(q) * q).abs() < 1e-6, "{q}");
        }
        assert_eq!(matern(0.0), 1.0);
    }

    #[test]
    fn words_are_the_same_or_not() {
        let kind = Kind::Word(3);
        assert_eq!((kind.squared(0.1, 0.3), kind.squared(0.3, 0.35)), (0.0, 1.0));
        assert_eq!(kind.squared(0.99, 1.0), 0.0);
    }
}
