//! Random draws of the radar, the same on every machine: a named generator (PCG64) and `libm`.
//!
//! Not `rand_distr`: its normal and Poisson deviates call `num_traits`. The `exp` and `ln` of that crate become the
//! system's as soon as any crate of the program enables its `std`.

use rand_core::SeedableRng;
use rand_pcg::Pcg64;

/// The golden ratio's odd multiple, which keeps neighbouring seeds and streams apart.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random {
    generator: Pcg64,
    /// Second half of the last pair of normal deviates.
    spare: Option<f64>,
}

impl Random {
    /// The stream of one source over a whole run.
    pub fn of_run(seed: u64, source: u64) -> Self {
        let seed = seed.wrapping_add(source.wrapping_mul(GOLDEN));
        Self { generator: Pcg64::seed_from_u64(seed), spare: None }
    }

    pub fn of_scan(seed: u64, source: u64, time_ns: i64) -> Self {
        let seed = hash(hash(seed, source), time_ns as u64);
        Self { generator: Pcg64::seed_from_u64(seed), spare: None }
    }

    /// Uniform in [0, 1), with 53 bits.
    pub fn uniform(&mut self) -> f64 {
        random::uniform(&mut self.generator)
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    /// Two independent standard normal deviates (Box and Muller 1958).
    pub fn normal_pair(&mut self) -> (f64, f64) {
        random::normal_pair(&mut self.generator)
    }

    /// A standard normal deviate.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let (first, second) = self.normal_pair();
        self.spare = Some(second);
        first
    }

    /// An exponential deviate with mean 1.
    pub fn exponential(&mut self) -> f64 {
        exponential(self.uniform())
    }

    /// Number of events of a Poisson process with this mean: exponential waiting times are counted.
    pub fn poisson(&mut self, mean: f64) -> u32 {
        let (mut elapsed, mut events) = (self.exponential(), 0);
        while elapsed < mean {
            elapsed += self.exponential();
            events += 1;
        }
        events
    }
}

/// An exponential deviate with mean 1 from a uniform one in [0, 1).
pub fn exponential(uniform: f64) -> f64 {
    -libm::log(1.0 - uniform)
}

/// A number in [0, 1) that belongs to `index` of the stream `seed`. It serves what stands in the world and must be the
/// same in every scan.
pub fn fixed(seed: u64, index: u64) -> f64 {
    random::unit(hash(seed, index))
}

/// Mixes two numbers (the finaliser of SplitMix64, Steele, Lea and Flood 2014).
pub fn hash(seed: u64, index: u64) -> u64 {
    let mut z = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(GOLDEN));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;

    const N: u32 = 100_000;

    fn moments(mut draw: impl FnMut(&mut Random) -> f64) -> (f64, f64) {
        let mut random = Random::of_run(3, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..N {
            let value = draw(&mut random);
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(N);
        (mean, squares / f64::from(N) - mean * mean)
    }

    #[test]
    fn the_deviates_have_their_means_and_variances() {
        let close = |(mean, variance): (f64, f64), expected: (f64, f64)| {
            let limit = 5.0 * (expected.1 / f64::from(N)).sqrt();
            assert!((mean - expected.0).abs() < limit, "mean {mean}, not {}", expected.0);
            assert!((variance / expected.1 - 1.0).abs() < 0.05, "{variance}, not {}", expected.1);
        };
        close(moments(Random::normal), (0.0, 1.0));
        close(moments(Random::exponential), (1.0, 1.0));
        close(moments(|random| random.between(2.0, 4.0)), (3.0, 1.0 / 3.0));
        for mean in [0.5, 3.0, 20.0] {
            close(moments(|random| f64::from(random.poisson(mean))), (mean, mean));
        }
        let mut index = 0;
        close(
            moments(|_| {
                index += 1;
                fixed(9, index)
            }),
            (0.5, 1.0 / 12.0),
        );
    }

    #[test]
    fn scans_and_sources_have_streams_of_their_own() {
        let first = |seed, source, time_ns| Random::of_scan(seed, source, time_ns).uniform();
        let base = first(1, 0, 0);
        assert_eq!(base, first(1, 0, 0));
        for other in
            [first(2, 0, 0), first(1, 1, 0), first(1, 0, 1), first(0, 1, 0), first(1, 0, -1)]
        {
            assert_ne!(base, other);
        }
    }

    /// So that a change of the generator or of its seeding cannot pass unseen.
    #[test]
    fn the_random_numbers_are_the_named_generators() {
        let mut random = Random::of_run(1, 0);
        let drawn = [(); 3].map(|()| random.generator.next_u64());
        let first = 15_492_934_433_077_865_799;
        assert_eq!(drawn, [first, 319_104_231_195_455_319, 2_101_115_697_694_094_752]);
    }
}
