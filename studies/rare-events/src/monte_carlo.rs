//! Plain Monte Carlo, until enough events are there or the budget is used up.

use crate::Limit;
use crate::estimate::{Budget, Estimate};
use rand_core::Rng;
use rand_pcg::Pcg64;

/// Events after which Monte Carlo ends: the standard error is then a tenth of the estimate.
pub const ENOUGH_EVENTS: usize = 100;

/// The point of a run by its number, so that runs can be done in any order.
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
