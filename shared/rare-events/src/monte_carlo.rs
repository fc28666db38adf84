//! Plain Monte Carlo, until enough events are there or the budget is used up.

use crate::Limit;
use crate::estimate::{Budget, Estimate};
use rand_core::Rng;
use rand_pcg::Pcg64;

/// Events after which Monte Carlo ends: the standard error is then a tenth of the estimate.
pub const ENOUGH_EVENTS: usize = 100;

/// The point of a run by its number, so that runs can be done in any order.
#[must_use]
pub fn point(dimensions: usize, seed: u64, number: u64) -> Vec<f64> {
    let mut generator = Pcg64::new(seed.into(), number.into());
    // The first number of a stream is almost the same for all small seeds.
    generator.next_u64();
    (0..dimensions).map(|_| random::normal(&mut generator)).collect()
}

/// Estimates the probability of the event in `dimensions` variables.
///
/// # Errors
/// As `limit`.
pub fn monte_carlo<E>(
    dimensions: usize,
    budget: Budget,
    limit: &mut impl Limit<E>,
) -> Result<Estimate, E> {
    let mut events: Vec<Vec<f64>> = Vec::new();
    let mut runs = 0;
    while runs < budget.runs && events.len() < ENOUGH_EVENTS {
        let point = point(dimensions, budget.seed, runs as u64);
        runs += 1;
        if limit(&point)? < 0.0 {
            events.push(point);
        }
    }
    Ok(Estimate::of_points(&events, runs))
}

/// The 95 % interval of a share (Wilson 1927).
///
/// ```
/// let [low, high] = rare_events::wilson(0, 100);
/// assert!(low == 0.0 && (high - 0.0370).abs() < 1e-4);
/// ```
#[must_use]
pub fn wilson(events: usize, runs: usize) -> [f64; 2] {
    /// Quantile of the normal distribution at 97.5 %.
    const Z: f64 = 1.959963984540054;
    if runs == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (runs as f64, events as f64 / runs as f64);
    let whole = 1.0 + Z * Z / n;
    let middle = p + Z * Z / (2.0 * n);
    let half = Z * libm::sqrt(p * (1.0 - p) / n + Z * Z / (4.0 * n * n));
    let low = if events == 0 { 0.0 } else { (middle - half) / whole };
    let high = if events == runs { 1.0 } else { (middle + half) / whole };
    [low.max(0.0), high.min(1.0)]
}
