//! The Sobol sequence: points that fill the unit cube more evenly than random ones.
//!
//! ```text
//! v_i = m_i / 2^i,   m_i = 2 a_1 m_{i-1} ⊕ 2² a_2 m_{i-2} ⊕ … ⊕ 2^s m_{i-s} ⊕ m_{i-s}
//! x_k = v_1 g_1 ⊕ v_2 g_2 ⊕ …   with the Gray code g of k
//! ```
//!
//! A digital shift by the seed makes independent repetitions. Sources: Sobol (1967); Bratley and Fox, Algorithm 659
//! (1988). The direction numbers of the first 21 dimensions are of Joe and Kuo, Constructing Sobol sequences with
//! better two-dimensional projections (2008), file `new-joe-kuo-6.21201`.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

const BITS: usize = 32;

/// Most variables: the dimensions whose direction numbers are known.
pub const MOST_VARIABLES: usize = 21;

/// Degree, coefficients and first numbers m of the dimensions from the second on.
const DIRECTIONS: [(u32, u32, &[u32]); MOST_VARIABLES - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
];

/// A shifted Sobol sequence.
///
/// ```
/// use search::method::Sobol;
///
/// let sobol = Sobol::new(2, None);
/// assert_eq!([sobol.point(1), sobol.point(2), sobol.point(3)], [[0.5, 0.5], [0.75, 0.25], [0.25, 0.75]]);
/// ```
#[derive(Clone, Debug)]
pub struct Sobol {
    /// Direction numbers of each dimension.
    directions: Vec<[u32; BITS]>,
    shift: Vec<u32>,
}

impl Sobol {
    /// The sequence in this many dimensions; without a seed it has no shift.
    ///
    /// # Panics
    /// In more than [`MOST_VARIABLES`] dimensions.
    pub fn new(dimensions: usize, seed: Option<u64>) -> Self {
        let mut random = Pcg64::seed_from_u64(seed.unwrap_or_default());
        let shift = |_| seed.map_or(0, |_| (random.next_u64() >> 32) as u32);
        let shift = (0..dimensions).map(shift).collect();
        Self { directions: (0..dimensions).map(directions).collect(), shift }
    }

    /// The point of an index: without a shift, that of index 0 is the corner.
    pub fn point(&self, index: u64) -> Vec<f64> {
        let gray = index ^ (index >> 1);
        let coordinate = |(directions, shift): (&[u32; BITS], &u32)| {
            let set = directions.iter().enumerate().filter(|(bit, _)| gray >> bit & 1 == 1);
            let bits = set.fold(*shift, |bits, (_, direction)| bits ^ direction);
            f64::from(bits) / 2_f64.powi(BITS as i32)
        };
        self.directions.iter().zip(&self.shift).map(coordinate).collect()
    }
}

fn directions(dimension: usize) -> [u32; BITS] {
    let mut v = [0; BITS];
    let Some(place) = dimension.checked_sub(1) else {
        for (bit, v) in v.iter_mut().enumerate() {
            *v = 1 << (BITS - 1 - bit);
        }
        return v;
    };
    let (degree, coefficients, first) = DIRECTIONS[place];
    let degree = degree as usize;
    for bit in 0..BITS {
        v[bit] = if bit < degree {
            first[bit] << (BITS - 1 - bit)
        } else {
            let mut value = v[bit - degree] ^ (v[bit - degree] >> degree);
            for k in 1..degree {
                if coefficients >> (degree - 1 - k) & 1 == 1 {
                    value ^= v[bit - k];
                }
            }
            value
        };
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// In every dimension the first 2^k points have one in each of 2^k equal parts, shifted or not.
    #[test]
    fn every_dimension_is_filled_evenly() {
        for seed in [None, Some(3)] {
            let sobol = Sobol::new(MOST_VARIABLES, seed);
            for dimension in 0..MOST_VARIABLES {
                let part = |k: u64| (sobol.point(k)[dimension] * 256.0) as usize;
                let parts: BTreeSet<usize> = (0..256).map(part).collect();
                assert_eq!(parts.len(), 256, "dimension {dimension}");
            }
        }
    }

    /// Points 1 to 5 in dimension 4 of the published example of Joe and Kuo's program.
    #[test]
    fn the_first_points_are_the_published_ones() {
        let sobol = Sobol::new(4, None);
        let expected = [
            [0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25],
            [0.25, 0.75, 0.75, 0.75],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
        ];
        for (index, point) in expected.iter().enumerate() {
            assert_eq!(sobol.point(index as u64 + 1), point);
        }
    }

    #[test]
    fn another_seed_is_another_sequence_of_the_same_kind() {
        let (a, b) = (Sobol::new(3, Some(1)), Sobol::new(3, Some(2)));
        assert_ne!(a.point(7), b.point(7));
        let mean: f64 = (0..1024).map(|k| a.point(k)[2]).sum::<f64>() / 1024.0;
        assert!((mean - 0.5).abs() < 1e-3, "{mean}");
    }
}
