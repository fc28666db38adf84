//! Importance sampling from a density that is fitted to the event by its cross entropy, in independent replicas.
//!
//! ```text
//! replica:  nominal ─ level 1 ─ fit ─ level 2 ─ fit … settled ─ last fit ─ all other runs ─► mean of weights
//!           (each level: a fourteenth of the replica's runs, at most nine levels)
//! ```
//!
//! The estimate uses the points of the last density alone, which does not depend on them: it has no bias. The interval
//! is Student's over the replicas, on the logarithm of the estimate, since an estimate of a rare event scatters by a
//! factor. Source of the levels: Papaioannou, Geyer, Straub 2019.

use crate::Limit;
use crate::estimate::{Budget, Estimate, Replica};
use crate::gaussian::Gaussian;
use crate::interval::REPLICAS;
use crate::smoothing::Smoothing;
use rand_core::Rng;
use rand_pcg::Pcg64;

/// Most levels of a replica.
const MOST_LEVELS: usize = 9;
/// A replica's runs over those of a level.
const LEVELS_IN_RUNS: usize = 14;

/// Estimates the probability of the event in `dimensions` variables. The replicas share the budget.
///
/// # Errors
/// As `limit`.
pub fn cross_entropy<E>(
    dimensions: usize,
    budget: Budget,
    limit: &mut impl Limit<E>,
) -> Result<Estimate, E> {
    let each = Budget { runs: budget.runs / REPLICAS, ..budget };
    let replicas = (0..REPLICAS).map(|number| replica(dimensions, each, number, limit));
    Ok(Estimate::of_replicas(&replicas.collect::<Result<Vec<_>, E>>()?))
}

/// One replica by its number, with a budget of its own. All replicas have one seed.
///
/// # Errors
/// As `limit`.
pub fn replica<E>(
    dimensions: usize,
    budget: Budget,
    number: usize,
    limit: &mut impl Limit<E>,
) -> Result<Replica, E> {
    // Streams of Monte Carlo's points count from the other end.
    let mut generator = Pcg64::new(budget.seed.into(), u128::MAX - number as u128);
    generator.next_u64();
    let of_level = (budget.runs / LEVELS_IN_RUNS).max(1);
    let mut density = Gaussian::nominal(dimensions);
    let mut smoothing: Option<Smoothing> = None;
    let (mut used, mut is_settled) = (0, false);
    let mut draw = |density: &Gaussian, count: usize| -> Result<(Vec<Vec<f64>>, Vec<f64>), E> {
        let points: Vec<Vec<f64>> = (0..count).map(|_| density.draw(&mut generator)).collect();
        let values = points.iter().map(|point| limit(point)).collect::<Result<_, E>>()?;
        Ok((points, values))
    };
    for _ in 0..MOST_LEVELS {
        let (points, values) = draw(&density, of_level)?;
        used += of_level;
        let ratios: Vec<f64> = points.iter().map(|point| density.ratio(point)).collect();
        is_settled = smoothing.as_ref().is_some_and(|smoothing| smoothing.is_settled(&values));
        let smoothing = smoothing.get_or_insert_with(|| Smoothing::before(&values));
        let weights = smoothing.weights(&values, &ratios);
        if let Some(fitted) = Gaussian::fitted(&points, &weights) {
            density = fitted;
        }
        if is_settled {
            break;
        }
    }
    let count = budget.runs.saturating_sub(used).max(1);
    let (points, values) = draw(&density, count)?;
    let events = points.into_iter().zip(values).filter(|(_, value)| *value < 0.0);
    let events: Vec<Vec<f64>> = events.map(|(point, _)| point).collect();
    let weights: Vec<f64> = events.iter().map(|point| density.ratio(point)).collect();
    let probability = weights.iter().sum::<f64>() / count as f64;
    Ok(Replica { probability, runs: used + count, is_settled, events, weights })
}
