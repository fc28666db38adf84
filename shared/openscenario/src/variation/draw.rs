//! Draws from a probability distribution.

use rand_core::SeedableRng;
use rand_pcg::Pcg64;

/// Draws outside a range before the file is refused.
const MAX_REDRAWS: usize = 10_000;

#[derive(Clone, Debug)]
pub(crate) enum Distribution {
    /// Texts with their weights.
    Set(Vec<(String, f64)>),
    /// Expected value and standard deviation, of the value or of its logarithm.
    Normal { mean: f64, deviation: f64, log: bool, range: Option<(f64, f64)> },
    /// Even between two limits.
    Uniform(f64, f64),
    /// Whole numbers.
    Poisson { mean: f64, range: Option<(f64, f64)> },
    /// Bins with their weights.
    Histogram(Vec<((f64, f64), f64)>),
}

impl Distribution {
    pub(super) fn seeded(self, seed: u64, stream: u64) -> Draws {
        // SplitMix64's increment keeps the seeds of streams apart.
        let seed = seed ^ stream.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Draws { distribution: self, generator: Pcg64::seed_from_u64(seed) }
    }
}

/// A distribution with its generator.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    distribution: Distribution,
    generator: Pcg64,
}

impl Draws {
    /// The next value; none if its range holds hardly any.
    pub(super) fn draw(&mut self) -> Option<String> {
        let distribution = self.distribution.clone();
        match distribution {
            Distribution::Set(items) => {
                let chosen = self.weighted(items.iter().map(|item| item.1));
                Some(items[chosen].0.clone())
            }
            Distribution::Histogram(bins) => {
                let chosen = self.weighted(bins.iter().map(|bin| bin.1));
                let (lower, upper) = bins[chosen].0;
                Some((lower + (upper - lower) * self.unit()).to_string())
            }
            Distribution::Uniform(lower, upper) => {
                Some((lower + (upper - lower) * self.unit()).to_string())
            }
            Distribution::Normal { mean, deviation, log, range } => self.inside(range, |draws| {
                let value = mean + deviation * random::normal(&mut draws.generator);
                if log { libm::exp(value) } else { value }
            }),
            Distribution::Poisson { mean, range } => {
                self.inside(range, |draws| draws.poisson(mean))
            }
        }
    }

    fn inside(
        &mut self,
        range: Option<(f64, f64)>,
        mut next: impl FnMut(&mut Self) -> f64,
    ) -> Option<String> {
        for _ in 0..MAX_REDRAWS {
            let value = next(self);
            if range.is_none_or(|(lower, upper)| (lower..=upper).contains(&value)) {
                return Some(value.to_string());
            }
        }
        None
    }

    fn weighted(&mut self, weights: impl Iterator<Item = f64> + Clone) -> usize {
        let mut at = self.unit() * weights.clone().sum::<f64>();
        let mut chosen = 0;
        for (i, weight) in weights.enumerate() {
            if weight > 0.0 {
                chosen = i;
                if at < weight {
                    break;
                }
            }
            at -= weight;
        }
        chosen
    }

    /// Uniform in [0, 1), 53 bits.
    fn unit(&mut self) -> f64 {
        random::uniform(&mut self.generator)
    }

    /// Poisson, by Knuth's product of uniform draws.
    fn poisson(&mut self, mean: f64) -> f64 {
        let limit = libm::exp(-mean);
        let (mut count, mut product) = (0.0, self.unit());
        while product > limit {
            count += 1.0;
            product *= self.unit();
        }
        count
    }
}
