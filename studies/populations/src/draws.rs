//! The random numbers of a scene.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Share of lorries among the vehicles of a road.
const LORRIES: f64 = 0.2;

/// Random numbers of one scene: a function of its number and of its population's stream.
#[derive(Debug)]
pub struct Draws {
    random: Pcg64,
    pub number: u64,
}

impl Draws {
    /// Numbers of scene `number`; `stream` distinguishes the kinds of scenes.
    pub fn new(number: u64, stream: u64) -> Self {
        Self { random: Pcg64::seed_from_u64(number ^ stream), number }
    }

    /// Numbers of scene `number` from a generator of this state and stream.
    pub fn of(number: u64, state: u128, stream: u128) -> Self {
        Self { random: Pcg64::new(state, stream), number }
    }

    /// Uniform between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * random::uniform(&mut self.random)
    }

    /// Uniform in the logarithm between two positive values.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    pub fn side(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    pub fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.between(0.0, of.len() as f64)) as usize]
    }

    /// 32 random bits, which number another scene.
    pub fn bits(&mut self) -> u32 {
        self.random.next_u32()
    }

    /// Length and width of a vehicle, m.
    pub fn size_m(&mut self) -> (f64, f64) {
        if self.chance(LORRIES) { (12.0, 2.5) } else { (4.5, 1.8) }
    }
}
