//! The draws that all scenes share: a generator for each number, vehicles that wander, and the ego.

use std::fmt::Write;

use rand_core::SeedableRng;
use rand_pcg::Pcg64;

/// Width of a lane, m.
pub const LANE_M: f64 = 3.5;
/// Largest wander of a vehicle in its lane, m.
const WANDER_M: f64 = 0.25;
/// Shortest and longest time between two wanders, s; each takes three quarters of it.
const WANDERS_S: (f64, f64) = (4.0, 8.0);
/// Share of lorries.
const LORRIES: f64 = 0.2;

/// Draws of a scene by its number.
pub struct Draws(Pcg64);

impl Draws {
    /// The draws of scene `number`; `stream` distinguishes the kinds of scenes.
    pub fn new(number: u64, stream: u64) -> Self {
        Self(Pcg64::seed_from_u64(number ^ stream))
    }

    /// Uniform between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * random::uniform(&mut self.0)
    }

    /// Uniform in the logarithm between two positive values.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// 1 or -1.
    pub fn side(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// Length and width of a vehicle, m.
    pub fn size_m(&mut self) -> (f64, f64) {
        if self.chance(LORRIES) { (12.0, 2.5) } else { (4.5, 1.8) }
    }

    /// The lateral motions of a vehicle that wanders about `lane_m` until `until_s`.
    pub fn wander(&mut self, lane_m: f64, until_s: f64) -> String {
        let mut text = String::from("lateral = [\n");
        let mut time_s = self.between(0.0, WANDERS_S.0);
        while time_s < until_s {
            let takes_s = self.between(WANDERS_S.0, WANDERS_S.1);
            let to_m = lane_m + self.between(-WANDER_M, WANDER_M);
            let duration_s = 0.75 * takes_s;
            writeln!(
                text,
                "  {{ time_s = {time_s:.2}, to_m = {to_m:.3}, duration_s = {duration_s:.2} }},"
            )
            .expect("a string takes all");
            time_s += takes_s;
        }
        text + "]\n"
    }
}

/// The ego of a scene and all that is the same in each.
pub struct Ego<'a> {
    /// Name of the scenario.
    pub name: String,
    /// Seed of the run.
    pub seed: u64,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Set speed and speed at the start, m/s.
    pub speed_mps: f64,
    /// The keys of `[road.plan]` that make the axis.
    pub plan: &'a str,
    /// Sources of the course, as TOML.
    pub sources: &'a str,
    /// Name of the law that drives.
    pub law: &'a str,
}

impl Ego<'_> {
    /// Start of the scenario file. The radar has all of its imperfections.
    pub fn text(&self) -> String {
        let Self { name, seed, duration_s, speed_mps, plan, sources, law } = self;
        format!(
            "schema_version = 1\nname = \"{name}\"\nduration_s = {duration_s:.1}\nseed = {seed}\n\
             set_speed_mps = {speed_mps:.3}\n\
             [road.plan]\n{plan}\n\
             lanes = {{ left = 1, right = 1, width_m = {LANE_M} }}\n\
             [plant]\ninitial_speed_mps = {speed_mps:.3}\n\
             powertrain = {{ mass_kg = 1600, max_power_kw = 110 }}\n\
             [plant.lateral]\nmodel = \"single-track\"\n\
             [perception.radar]\ndropout_probability = 0.02\nlatency_ms = 50\n\
             [perception.course]\nsources = {sources}\n\
             [controller]\nname = \"{law}\"\n"
        )
    }
}
