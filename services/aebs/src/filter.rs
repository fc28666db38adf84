//! The filter of a lateral motion: how probable each lateral speed is, and where the object is with it.
//!
//! A vehicle keeps its lane most of the time, and then changes it. The filter tests whether it has begun to. One state
//! is for a vehicle that keeps its lane, others for lateral speeds [`STEP_MPS`] apart. Each has a probability, and mean
//! and variance of the position.
//!
//! | between two scans | rate, 1/s |
//! |---|---|
//! | it begins to change its lane, with each speed that it can have at first alike | [`BEGINS`], less below [`BEGINS_FROM_MPS`] |
//! | it ends the change | [`ENDS`] |
//! | its speed becomes the next one, up or down | [`VARIES`] each |
//!
//! No vehicle moves faster across the lanes than along them, and what stands does not move at all. A crawling object
//! turns slowly: on its smallest circle its lateral speed grows with v²/R ([`TURNS_M`]).
//!
//! A measured position corrects the states by Kalman's formulas, and their probabilities by Bayes' rule. A measured
//! lateral speed corrects the probabilities. Either is an outlier with probability [`OUTLIER`].
//!
//! Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
//! 11.6 (multiple models with switching).

/// Distance between two lateral speeds, m/s.
const STEP_MPS: f64 = 0.2;
/// Lateral speeds on each side of 0.
const SIDE: usize = 10;
/// States: the one that keeps its lane, then the speeds.
const STATES: usize = 2 * SIDE + 1;
/// Rates of changes, 1/s. A vehicle on a motorway begins to change its lane about every 250 s. Source: Krajewski et
/// al., The highD dataset, ITSC 2018: 5,600 changes in 44,500 km. Chosen: 40 times as often, as a change that is seen
/// late costs more.
const BEGINS: f64 = 0.15;
const ENDS: f64 = 0.3;
const VARIES: f64 = 4.0;
/// Speed from which it begins at the full rate, m/s. Chosen: lane changes come by the way that is driven.
const BEGINS_FROM_MPS: f64 = 10.0;
/// Radius of the smallest circle that a vehicle turns on, m: 11 m between kerbs, as usual cars.
const TURNS_M: f64 = 5.5;
/// Time for which it has turned when it is said to have begun, s. Found: as long as the filter needs to see it.
const TURNED_S: f64 = 0.4;
/// Growth of the position's variance, m²/s: a vehicle that keeps its lane wanders in it.
const WANDER_M2PS: f64 = 0.01;
/// Probability of an outlier, and its density over 1 m or 1 m/s.
const OUTLIER: f64 = 0.05;
const OUTLIER_DENSITY: f64 = 0.25;
/// Probability that a new vehicle keeps its lane.
const KEEPS: f64 = 0.8;
/// Largest share of a state that becomes the next one between two scans.
const MOST_VARY: f64 = 0.3;
/// Variance of a position that is known, m².
const KNOWN_M2: f64 = 1e-4;
/// Least probability of a state.
const LEAST: f64 = 1e-9;
/// A rate of the row stands for those around it, with this standard deviation, m/s.
const RATE_SIGMA_MPS: f64 = 0.055;
/// Least standard deviation of a distance across the lanes, m.
const LEAST_SIGMA_M: f64 = 1e-3;

/// Knowledge of one state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct State {
    probability: f64,
    mean_m: f64,
    variance_m2: f64,
}

/// A lateral position with its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateral {
    /// Mean position, m, left positive.
    pub position_m: f64,
    /// Mean rate, m/s.
    pub rate_mps: f64,
    states: [State; STATES],
}

/// A hypothesis: a rate, its probability, and the position with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// Probability.
    pub probability: f64,
    /// Rate, m/s.
    pub rate_mps: f64,
    /// Mean position, m.
    pub position_m: f64,
    /// Standard deviation of the position, m.
    pub sigma_m: f64,
}

impl Hypothesis {
    /// Standard deviation of the position when the rate was carried on for `time_s`, m.
    pub(crate) fn sigma_after_m(&self, time_s: f64) -> f64 {
        libm::hypot(self.sigma_m, RATE_SIGMA_MPS * time_s)
    }
}

/// Probability that two vehicles overlap. `reach_m` is the sum of their half widths; their middles are `off_m` apart,
/// with a standard deviation of `sigma_m`.
pub(crate) fn overlap(reach_m: f64, off_m: f64, sigma_m: f64) -> f64 {
    let deviates = (reach_m - off_m) / sigma_m.max(LEAST_SIGMA_M);
    0.5 * libm::erfc(-deviates * std::f64::consts::FRAC_1_SQRT_2)
}

/// The rate of a state, m/s.
fn rate(state: usize) -> f64 {
    match state {
        0 => 0.0,
        k if k <= SIDE => (k as f64 - SIDE as f64 - 1.0) * STEP_MPS,
        k => (k - SIDE) as f64 * STEP_MPS,
    }
}

impl Lateral {
    /// A motion that is known: its rate is rounded to the next of the row.
    #[must_use]
    pub fn known(position_m: f64, rate_mps: f64) -> Self {
        let mut lateral = Self { position_m, rate_mps, states: [State::default(); STATES] };
        for state in &mut lateral.states {
            state.mean_m = position_m;
            state.variance_m2 = KNOWN_M2;
        }
        // Between two rates of the row both are as probable as the rate is near.
        for k in 0..STATES {
            let off = (rate(k) - rate_mps).abs() / STEP_MPS;
            if off < 1.0 {
                lateral.states[k].probability = 1.0 - off;
            }
        }
        lateral.normalise();
        lateral
    }

    /// A motion of which one measurement is known, with its standard deviation, m.
    #[must_use]
    pub fn first(position_m: f64, sigma_m: f64) -> Self {
        let mut states = [State {
            probability: (1.0 - KEEPS) / (STATES - 1) as f64,
            mean_m: position_m,
            variance_m2: sigma_m * sigma_m,
        }; STATES];
        states[0].probability = KEEPS;
        Self { position_m, rate_mps: 0.0, states }
    }

    /// All states.
    pub fn hypotheses(&self) -> impl Iterator<Item = Hypothesis> {
        self.states.iter().enumerate().map(|(k, state)| Hypothesis {
            probability: state.probability,
            rate_mps: rate(k),
            position_m: state.mean_m,
            sigma_m: state.variance_m2.sqrt(),
        })
    }

    /// Standard deviation of the position, m.
    #[must_use]
    pub fn position_sigma_m(&self) -> f64 {
        let square = |state: &State| {
            let off_m = state.mean_m - self.position_m;
            state.probability * (state.variance_m2 + off_m * off_m)
        };
        self.states.iter().map(square).sum::<f64>().sqrt()
    }

    /// The state `time_s` later at an unchanged rate; its uncertainty stays.
    pub fn move_on(&mut self, time_s: f64) {
        for (k, state) in self.states.iter_mut().enumerate() {
            state.mean_m += rate(k) * time_s;
        }
        self.position_m += self.rate_mps * time_s;
    }

    /// Distance by which the origin of its position moved to the right, m. The object moves to the left by it, and
    /// keeps its rate.
    pub fn shift(&mut self, by_m: f64) {
        for state in &mut self.states {
            state.mean_m += by_m;
        }
        self.position_m += by_m;
    }

    /// It stays where it is from now on.
    pub fn rest(&mut self) {
        *self = Self::first(self.position_m, self.position_sigma_m());
    }

    /// Moves on by `period_s`, in which it may change its rate up to `fastest_mps`.
    pub fn predict(&mut self, period_s: f64, fastest_mps: f64) {
        let begins = (BEGINS * (fastest_mps / BEGINS_FROM_MPS).min(1.0) * period_s).min(MOST_VARY);
        let ends = (ENDS * period_s).min(MOST_VARY);
        let varies = (VARIES * period_s).min(MOST_VARY);
        let at_first_mps = (fastest_mps * fastest_mps / TURNS_M * TURNED_S).max(STEP_MPS);
        let can_begin = |state: usize| rate(state).abs() <= at_first_mps + 0.5 * STEP_MPS;
        let beginnings = (1..STATES).filter(|state| can_begin(*state)).count() as f64;
        let mut sums = [[0.0; 3]; STATES];
        let mut give = |to: usize, from: &State, share: f64| {
            let weight = share * from.probability;
            let [p, m, s] = &mut sums[to];
            *p += weight;
            *m += weight * from.mean_m;
            *s += weight * (from.variance_m2 + from.mean_m * from.mean_m);
        };
        give(0, &self.states[0], 1.0 - begins);
        for k in 1..STATES {
            let state = &self.states[k];
            if can_begin(k) {
                give(k, &self.states[0], begins / beginnings);
            }
            give(0, state, ends);
            let mut stays = 1.0 - ends;
            let mut step = |to: usize| {
                give(to, state, varies);
                stays -= varies;
            };
            if k > 1 {
                step(k - 1);
            }
            if k + 1 < STATES {
                step(k + 1);
            }
            give(k, state, stays);
        }
        let wander = WANDER_M2PS * period_s;
        for (k, (state, [probability, mean, square])) in
            self.states.iter_mut().zip(sums).enumerate()
        {
            let mean_m = mean / probability;
            *state = State {
                probability: if rate(k).abs() > fastest_mps { 0.0 } else { probability },
                mean_m: mean_m + rate(k) * period_s,
                variance_m2: (square / probability - mean_m * mean_m).max(0.0) + wander,
            };
        }
        self.normalise();
    }

    /// Density of a position that is measured with this variance, m², at the time predicted to, 1/m.
    pub(crate) fn expects(&self, measured_m: f64, variance_m2: f64) -> f64 {
        let of = |state: &State| {
            state.probability * density(measured_m - state.mean_m, state.variance_m2 + variance_m2)
        };
        self.states.iter().map(of).sum()
    }

    /// Takes a measured position with its variance, m², at the time predicted to.
    pub fn update(&mut self, measured_m: f64, variance_m2: f64) {
        for state in &mut self.states {
            let spread_m2 = state.variance_m2 + variance_m2;
            let off_m = measured_m - state.mean_m;
            let inlier = (1.0 - OUTLIER) * density(off_m, spread_m2);
            let likelihood = inlier + OUTLIER * OUTLIER_DENSITY;
            state.probability *= likelihood;
            let gain = inlier / likelihood * state.variance_m2 / spread_m2;
            state.mean_m += gain * off_m;
            // Without the spread of both places, inlier and outlier: with it a walker who steps out is braked for later.
            state.variance_m2 *= 1.0 - gain;
        }
        self.normalise();
    }

    /// Takes a measured rate, m/s, with its variance, m²/s².
    pub fn update_rate(&mut self, measured_mps: f64, variance_m2ps2: f64) {
        let spread = variance_m2ps2 + STEP_MPS * STEP_MPS / 12.0;
        let scale = (std::f64::consts::TAU * spread).sqrt();
        for (k, state) in self.states.iter_mut().enumerate() {
            let off_mps = measured_mps - rate(k);
            let inlier = (1.0 - OUTLIER) * (bell(off_mps * off_mps / spread) / scale);
            state.probability *= inlier + OUTLIER * OUTLIER_DENSITY;
        }
        self.normalise();
    }

    fn normalise(&mut self) {
        let sum: f64 = self.states.iter().map(|state| state.probability).sum();
        (self.position_m, self.rate_mps) = (0.0, 0.0);
        for (k, state) in self.states.iter_mut().enumerate() {
            state.probability = (state.probability / sum).max(LEAST);
            self.position_m += state.probability * state.mean_m;
            self.rate_mps += state.probability * rate(k);
        }
    }
}

/// Density of a normal deviate.
pub(crate) fn density(off: f64, variance: f64) -> f64 {
    bell(off * off / variance) / (std::f64::consts::TAU * variance).sqrt()
}

/// `exp(-square / 2)`; a power of two takes half of the time.
fn bell(square: f64) -> f64 {
    libm::exp2(-0.5 * std::f64::consts::LOG2_E * square)
}

#[cfg(test)]
mod tests;
