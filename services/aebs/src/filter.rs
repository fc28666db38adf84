//! The filter of a lateral motion: how probable each lateral speed is, and where the object is with it.
//!
//! A vehicle keeps its lane most of the time, and then changes it. The filter tests whether it has begun to. One state
//! is for a vehicle that keeps its lane, others for lateral speeds [`STEP_MPS`] apart. Each has a probability, and mean
//! and variance of the position.
//!
//! | between two scans | rate, 1/s |
//! |---|---|
//! | it begins to change its lane, with each speed alike | [`BEGINS`], less below [`BEGINS_FROM_MPS`] |
//! | it ends the change | [`ENDS`] |
//! | its speed becomes the next one, up or down | [`VARIES`] each |
//!
//! No vehicle moves faster across the lanes than along them, and what stands does not move at all.
//!
//! A measured position corrects the states by Kalman's formulas, and their probabilities by Bayes' rule. A measured
//! lateral speed corrects the probabilities. Either is an outlier with probability [`OUTLIER`].
//!
//! Source: Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
//! 11.6 (multiple models with switching).

use std::array::from_fn;

/// Distance between two lateral speeds, m/s.
const STEP_MPS: f64 = 0.2;
/// States: the one that keeps its lane, then ten speeds to each side.
const STATES: usize = 21;
/// Rates of changes, 1/s. A vehicle on a motorway begins to change its lane about every 250 s. Source: Krajewski et
/// al., The highD dataset, ITSC 2018: 5,600 changes in 44,500 km. Chosen: 40 times as often, as a change that is seen
/// late costs more.
const BEGINS: f64 = 0.15;
const ENDS: f64 = 0.3;
const VARIES: f64 = 4.0;
/// Speed from which it begins at the full rate, m/s. Chosen: lane changes come by the way that is driven.
const BEGINS_FROM_MPS: f64 = 10.0;
/// Growth of the position's variance, m²/s: a vehicle that keeps its lane wanders in it.
const WANDER_M2PS: f64 = 0.01;
/// Probability of an outlier, and its density over 1 m or 1 m/s.
const OUTLIER: f64 = 0.05;
const OUTLIER_DENSITY: f64 = 0.25;
/// Probability that a new vehicle keeps its lane.
const KEEPS: f64 = 0.8;
/// Largest share of a state that becomes the next one between two scans.
const MOST_VARY: f64 = 0.3;
const LEAST: f64 = 1e-9;
/// A rate of the row stands for those around it, with this standard deviation, m/s.
const RATE_SIGMA_MPS: f64 = 0.055;

type Row = [f64; STATES];

/// Lateral speeds: of the state that keeps its lane, to the right, to the left.
const RATES_MPS: Row = [
    0.0, -2.0, -1.8, -1.6, -1.4, -1.2, -1.0, -0.8, -0.6, -0.4, -0.2, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2,
    1.4, 1.6, 1.8, 2.0,
];

/// A lateral position with its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateral {
    /// Mean position, m, left positive.
    pub position_m: f64,
    pub rate_mps: f64,
    pub states: [State; STATES],
}

/// A lateral speed: its probability, and the position with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub probability: f64,
    pub rate_mps: f64,
    pub position_m: f64,
    pub variance_m2: f64,
}

impl State {
    /// Standard deviation of the position when the rate was carried on for `time_s`, m.
    pub(crate) fn sigma_after_m(&self, time_s: f64) -> f64 {
        libm::hypot(self.variance_m2.sqrt(), RATE_SIGMA_MPS * time_s)
    }
}

/// Probability that two vehicles overlap. `reach_m` is the sum of their half widths; their middles are `off_m` apart,
/// with a standard deviation of `sigma_m`.
pub(crate) fn overlap(reach_m: f64, off_m: f64, sigma_m: f64) -> f64 {
    let deviates = (reach_m - off_m) / sigma_m;
    0.5 * libm::erfc(-deviates * std::f64::consts::FRAC_1_SQRT_2)
}

impl Lateral {
    /// A motion that is known: its rate is rounded to the next of the row.
    #[cfg(test)]
    pub(crate) fn known(position_m: f64, rate_mps: f64) -> Self {
        // Between two rates of the row both are as probable as the rate is near.
        let near = |rate: f64| (1.0 - (rate - rate_mps).abs() / STEP_MPS).max(0.0);
        let mut lateral = Self::first(position_m, 0.01);
        lateral.states.iter_mut().for_each(|state| state.probability = near(state.rate_mps));
        lateral.normalise();
        lateral
    }

    /// A motion of which one measurement is known, with its standard deviation, m.
    pub fn first(position_m: f64, sigma_m: f64) -> Self {
        let (probability, variance_m2) = ((1.0 - KEEPS) / (STATES - 1) as f64, sigma_m * sigma_m);
        let mut states =
            RATES_MPS.map(|rate_mps| State { probability, rate_mps, position_m, variance_m2 });
        states[0].probability = KEEPS;
        Self { position_m, rate_mps: 0.0, states }
    }

    pub fn position_sigma_m(&self) -> f64 {
        let square = |state: &State| {
            let off_m = state.position_m - self.position_m;
            state.probability * (state.variance_m2 + off_m * off_m)
        };
        self.states.iter().map(square).sum::<f64>().sqrt()
    }

    /// Distance by which the origin of its position moved to the right, m. The object moves to the left by it, and
    /// keeps its rate.
    pub fn shift(&mut self, by_m: f64) {
        self.states.iter_mut().for_each(|state| state.position_m += by_m);
        self.position_m += by_m;
    }

    /// Moves on by `period_s`, in which it may change its rate up to `fastest_mps`.
    pub fn predict(&mut self, period_s: f64, fastest_mps: f64) {
        let begins = (BEGINS * (fastest_mps / BEGINS_FROM_MPS).min(1.0) * period_s).min(MOST_VARY);
        let ends = (ENDS * period_s).min(MOST_VARY);
        let varies = (VARIES * period_s).min(MOST_VARY);
        let beginning = begins / (STATES - 1) as f64;
        let next = |of: fn(&State) -> f64| -> Row {
            let from = self.states.map(|state| state.probability * of(&state));
            let moving: f64 = from[1..].iter().sum();
            let mut to: Row = from_fn(|k| {
                // The outermost rates have one neighbour.
                let (slower, faster) = (k.max(2) - 1, (k + 1).min(STATES - 1));
                (1.0 - ends - 2.0 * varies) * from[k]
                    + varies * (from[slower] + from[faster])
                    + beginning * from[0]
            });
            to[0] = (1.0 - begins) * from[0] + ends * moving;
            to
        };
        // Each state gives weight, moment and square of its position alike.
        let weights = next(|_| 1.0);
        let moments = next(|state| state.position_m);
        let squares = next(|state| state.variance_m2 + state.position_m * state.position_m);
        let wander_m2 = WANDER_M2PS * period_s;
        for (k, state) in self.states.iter_mut().enumerate() {
            let mean_m = moments[k] / weights[k];
            let is_possible = state.rate_mps.abs() <= fastest_mps;
            state.probability = if is_possible { weights[k] } else { 0.0 };
            state.position_m = mean_m + state.rate_mps * period_s;
            state.variance_m2 = (squares[k] / weights[k] - mean_m * mean_m).max(0.0) + wander_m2;
        }
        self.normalise();
    }

    /// Takes a measured position with its variance, m², at the time predicted to.
    pub fn update(&mut self, measured_m: f64, variance_m2: f64) {
        for state in &mut self.states {
            let spread_m2 = state.variance_m2 + variance_m2;
            let off_m = measured_m - state.position_m;
            let inlier = (1.0 - OUTLIER) * density(off_m, spread_m2);
            let likelihood = inlier + OUTLIER * OUTLIER_DENSITY;
            state.probability *= likelihood;
            let gain = inlier / likelihood * state.variance_m2 / spread_m2;
            state.position_m += gain * off_m;
            // Without the spread of both places, inlier and outlier: with it a walker who steps out is braked for later.
            state.variance_m2 *= 1.0 - gain;
        }
        self.normalise();
    }

    /// Takes a measured rate, m/s, with its variance, m²/s².
    pub fn update_rate(&mut self, measured_mps: f64, variance_m2ps2: f64) {
        let spread = variance_m2ps2 + STEP_MPS * STEP_MPS / 12.0;
        for state in &mut self.states {
            let inlier = (1.0 - OUTLIER) * density(measured_mps - state.rate_mps, spread);
            state.probability *= inlier + OUTLIER * OUTLIER_DENSITY;
        }
        self.normalise();
    }

    fn normalise(&mut self) {
        let share = 1.0 / self.states.iter().map(|state| state.probability).sum::<f64>();
        (self.position_m, self.rate_mps) = (0.0, 0.0);
        for state in &mut self.states {
            state.probability = (state.probability * share).max(LEAST);
            self.position_m += state.probability * state.position_m;
            self.rate_mps += state.probability * state.rate_mps;
        }
    }
}

fn density(off: f64, variance: f64) -> f64 {
    libm::exp(-0.5 * off * off / variance) / (std::f64::consts::TAU * variance).sqrt()
}

#[cfg(test)]
mod tests;
