//! The covariance of two points.

use multiversion::multiversion;

use crate::lanes::{self, LANES, Lanes};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number: near values are alike.
    Number,
    /// A word: two values are the same or not. Coordinates in one of `n` equal parts of the unit interval are one word.
    Word(usize),
    /// A word of which each value adds a part of its own to the function. At most one coordinate is of this kind.
    Branch(usize),
    /// A number that matters in the parts of the branch alone, in each of them apart.
    Own,
}

/// Parameters of the covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperparameters {
    /// Length of each coordinate. That of a branch is not read.
    pub lengths: Vec<f64>,
    /// Standard deviation of the function.
    pub signal: f64,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Standard deviation of the part of each word of the branch; empty without a branch.
    pub parts: Vec<f64>,
}

impl Kind {
    /// Squared difference of two coordinates; of words 0 or 1.
    pub(crate) fn squared(self, a: f64, b: f64) -> f64 {
        let (a, b) = (self.mark(a), self.mark(b));
        match self {
            Self::Number | Self::Own => (a - b) * (a - b),
            Self::Word(_) | Self::Branch(_) if a == b => 0.0,
            Self::Word(_) | Self::Branch(_) => 1.0,
        }
    }

    /// A coordinate that only what is the same has: a number itself, the place of a word.
    pub(crate) fn mark(self, x: f64) -> f64 {
        match self {
            Self::Number | Self::Own => x,
            Self::Word(count) | Self::Branch(count) => {
                ((x * count as f64) as usize).min(count - 1) as f64
            }
        }
    }

    /// The coordinate counts in the distance of the common part.
    fn is_common(self) -> bool {
        matches!(self, Self::Number | Self::Word(_))
    }
}

/// Number of words of the branch, 0 without one.
pub(crate) fn words(kinds: &[Kind]) -> usize {
    let count = |kind: &Kind| if let Kind::Branch(count) = kind { *count } else { 0 };
    kinds.iter().map(count).sum()
}

/// The covariance of a function:
///
/// ```text
/// k(x, x') = s² m(r_c) + [same branch b] p_b² m(r_a)        c: without numbers of branches, a: with them
/// ```
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    kinds: Vec<Kind>,
    /// Inverse squares of the lengths of the common coordinates and of the branches' own ones, 0 for the others.
    common: Vec<f64>,
    own: Vec<f64>,
    variance: f64,
    branch: Option<usize>,
    /// Variances of the parts.
    parts: Vec<f64>,
}

impl Kernel {
    pub fn new(kinds: &[Kind], parameters: &Hyperparameters) -> Self {
        let inverse = |is_wanted: &dyn Fn(&Kind) -> bool| -> Vec<f64> {
            let all = kinds.iter().zip(&parameters.lengths);
            let of = |(kind, length): (&Kind, &f64)| {
                if is_wanted(kind) { 1.0 / (length * length) } else { 0.0 }
            };
            all.map(of).collect()
        };
        Self {
            common: inverse(&|kind| kind.is_common()),
            own: inverse(&|kind| *kind == Kind::Own),
            variance: parameters.signal * parameters.signal,
            branch: kinds.iter().position(|kind| matches!(kind, Kind::Branch(_))),
            parts: parameters.parts.iter().map(|part| part * part).collect(),
            kinds: kinds.to_vec(),
        }
    }

    /// Word of the branch at a point.
    pub fn word(&self, x: &[f64]) -> Option<usize> {
        self.branch.map(|place| self.kinds[place].mark(x[place]) as usize)
    }

    /// Variance of the function at a point.
    pub fn variance(&self, x: &[f64]) -> f64 {
        self.variance + self.word(x).map_or(0.0, |word| self.parts[word])
    }

    /// Covariance of two points.
    pub fn covariance(&self, a: &[f64], b: &[f64]) -> f64 {
        let (mut common, mut own) = (0.0, 0.0);
        for (place, kind) in self.kinds.iter().enumerate() {
            let squared = kind.squared(a[place], b[place]);
            common += squared * self.common[place];
            own += squared * self.own[place];
        }
        let sum = self.variance * matern(common);
        match (self.word(a), self.word(b)) {
            (Some(a), Some(b)) if a == b => sum + self.parts[a] * matern(common + own),
            _ => sum,
        }
    }

    /// Covariances of the points in the lanes of `marks`, which has a row for each coordinate, with other points.
    pub fn covariances(&self, marks: &[Lanes], others: &[Vec<f64>], found: &mut Vec<Lanes>) {
        covariances(self, marks, others, found);
    }

    /// Marks of up to [`LANES`] points: a row for each coordinate.
    pub fn marks(&self, points: &[Vec<f64>]) -> Vec<Lanes> {
        let mut marks = vec![[0.0; LANES]; self.kinds.len()];
        for (lane, point) in points.iter().enumerate() {
            for ((marks, kind), at) in marks.iter_mut().zip(&self.kinds).zip(point) {
                marks[lane] = kind.mark(*at);
            }
        }
        marks
    }
}

const ROOT_5: f64 = 2.236_067_977_499_79;

/// Matérn's covariance at a squared distance, for a variance of 1.
pub(crate) fn matern(squared: f64) -> f64 {
    let r = ROOT_5 * squared.sqrt();
    (1.0 + r + r * r / 3.0) * libm::exp(-r)
}

/// Matérn's covariances at squared distances, and their derivatives by the logarithm of a length. The derivatives are
/// over the length's own part of the squared distance.
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

/// Covariances and slopes, times `variance`, of pairs of points by the squared differences of their coordinates. Each
/// lane of pairs has as many numbers as there are inverse squares of lengths.
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

#[multiversion(targets("x86_64+avx2"))]
fn covariances(kernel: &Kernel, marks: &[Lanes], others: &[Vec<f64>], found: &mut Vec<Lanes>) {
    let Kernel { kinds, common, own, variance, branch, parts } = kernel;
    for other in others {
        let (mut near, mut all) = ([0.0; LANES], [0.0; LANES]);
        for (place, kind) in kinds.iter().enumerate() {
            let (other, marks) = (kind.mark(other[place]), &marks[place]);
            match kind {
                Kind::Number => {
                    for lane in 0..LANES {
                        let off = marks[lane] - other;
                        near[lane] += off * off * common[place];
                    }
                }
                Kind::Word(_) => {
                    for lane in 0..LANES {
                        near[lane] += if marks[lane] == other { 0.0 } else { common[place] };
                    }
                }
                Kind::Own => {
                    for lane in 0..LANES {
                        let off = marks[lane] - other;
                        all[lane] += off * off * own[place];
                    }
                }
                Kind::Branch(_) => {}
            }
        }
        let [mut values, _] = with_slopes(&near);
        for value in &mut values {
            *value *= variance;
        }
        if let Some(place) = *branch {
            let word = kinds[place].mark(other[place]);
            for lane in 0..LANES {
                all[lane] += near[lane];
            }
            let [part, _] = with_slopes(&all);
            for lane in 0..LANES {
                let share = if marks[place][lane] == word { parts[word as usize] } else { 0.0 };
                values[lane] += share * part[lane];
            }
        }
        found.push(values);
    }
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
        let part = |k: usize, by: f64| (k as f64 * by).fract();
        let point = |k: usize| [0.754_877, 0.569_84, 0.433_9, 0.31].map(|by| part(k, by)).to_vec();
        let (points, others): (Vec<_>, Vec<_>) =
            ((0..LANES).map(point).collect(), (40..70).map(point).collect());
        for third in [Kind::Branch(3), Kind::Word(3)] {
            let kinds = [Kind::Number, Kind::Word(2), third, Kind::Own];
            let parameters = Hyperparameters {
                lengths: vec![0.6, 1.4, 1.0, 0.3],
                signal: 1.4,
                noise: 0.1,
                parts: vec![0.2, 1.7, 0.9],
            };
            let kernel = Kernel::new(&kinds, &parameters);
            let mut found = Vec::new();
            kernel.covariances(&kernel.marks(&points), &others, &mut found);
            for (other, found) in others.iter().zip(&found) {
                for (point, found) in points.iter().zip(found) {
                    let expected = kernel.covariance(point, other);
                    assert!((found - expected).abs() < 1e-14, "{found} {expected}");
                }
            }
        }
    }

    /// One number that is common, one that is the branch's own: by hand.
    #[test]
    fn each_word_of_a_branch_has_a_part_of_its_own() {
        let kinds = [Kind::Number, Kind::Branch(2), Kind::Own];
        let parameters = Hyperparameters {
            lengths: vec![0.5, 7.0, 0.25],
            signal: 2.0,
            noise: 0.1,
            parts: vec![0.5, 3.0],
        };
        let kernel = Kernel::new(&kinds, &parameters);
        let (a, b, c) = (vec![0.1, 0.2, 0.3], vec![0.6, 0.2, 0.8], vec![0.6, 0.9, 0.8]);
        let common = 4.0 * matern(1.0);
        assert_eq!(kernel.covariance(&a, &c), common, "other words");
        assert!((kernel.covariance(&a, &b) - common - 0.25 * matern(1.0 + 4.0)).abs() < 1e-15);
        assert_eq!(kernel.variance(&a), 4.25);
        assert_eq!(kernel.variance(&c), 13.0);
        assert_eq!(kernel.covariance(&c, &c), 13.0);
    }

    #[test]
    fn words_are_the_same_or_not() {
        let kind = Kind::Word(3);
        assert_eq!((kind.squared(0.1, 0.3), kind.squared(0.3, 0.35)), (0.0, 1.0));
        assert_eq!(kind.squared(0.99, 1.0), 0.0);
    }
}
