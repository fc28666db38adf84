//! Uniform and normal deviates from the bits of a named generator.
//!
//! The same bits give the same number on every machine. The functions are those of `libm`, not of the machine. A
//! deviate takes the same number of bits whatever their values.
//!
//! ```
//! use rand_core::SeedableRng;
//! let mut generator = rand_pcg::Pcg64::seed_from_u64(7);
//! assert!((0.0..1.0).contains(&random::uniform(&mut generator)));
//! ```

use rand_core::Rng;
use std::f64::consts::TAU;

/// Uniform in [0, 1): the highest 53 of 64 random bits.
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// Uniform in [0, 1).
pub fn uniform(generator: &mut impl Rng) -> f64 {
    unit(generator.next_u64())
}

/// Uniform in (0, 1), for what has no value at an end.
pub fn open_uniform(generator: &mut impl Rng) -> f64 {
    ((generator.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// A standard normal deviate from two uniform ones, of which `u` is not 0 (Box and Muller 1958).
pub fn box_muller(u: f64, v: f64) -> f64 {
    libm::sqrt(-2.0 * libm::log(u)) * libm::cos(TAU * v)
}

/// A standard normal deviate.
pub fn normal(generator: &mut impl Rng) -> f64 {
    let u = 1.0 - uniform(generator);
    box_muller(u, uniform(generator))
}

/// Two independent standard normal deviates.
pub fn normal_pair(generator: &mut impl Rng) -> (f64, f64) {
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - uniform(generator)));
    let (sine, cosine) = libm::sincos(TAU * uniform(generator));
    (radius * cosine, radius * sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn the_ends_are_where_they_belong() {
        assert_eq!(unit(0), 0.0);
        assert!(unit(u64::MAX) < 1.0);
        assert!(box_muller(f64::MIN_POSITIVE, 0.5).is_finite());
        assert_eq!(box_muller(1.0, 0.25), 0.0);
    }

    #[test]
    fn deviates_have_the_moments_of_their_distribution() {
        const COUNT: usize = 100_000;
        let mut generator = Pcg64::seed_from_u64(1);
        let moments = |draw: &mut dyn FnMut() -> f64| {
            let drawn: Vec<f64> = (0..COUNT).map(|_| draw()).collect();
            let mean = drawn.iter().sum::<f64>() / COUNT as f64;
            let variance =
                drawn.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / COUNT as f64;
            (mean, variance)
        };
        let (mean, variance) = moments(&mut || uniform(&mut generator));
        assert!((mean - 0.5).abs() < 0.005 && (variance - 1.0 / 12.0).abs() < 0.002);
        let (mean, variance) = moments(&mut || normal(&mut generator));
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
        let (mean, variance) = moments(&mut || normal_pair(&mut generator).1);
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    }
}
