//! Importance sampling from a density that is fitted to the event by its cross entropy, in independent replicas.
//!
//! ```text
//! replica:  nominal ─ level 1 ─ fit ─ level 2 ─ fit … settled ─ fit ─ 1/3 of the rest ─ last fit ─ 2/3 ─► mean of weights
//!           (each level: a fourteenth of the replica's runs, at most nine levels)
//! ```
//!
//! A fit uses the points of all densities before it. A point's weight is the nominal density over the mixture of these
//! densities (the balance heuristic, Veach and Guibas 1995). So a point of an early density does not decide alone.
//!
//! The estimate uses the points of the last density alone, which does not depend on them: it has no bias. The interval
//! is Student's over the replicas, on the logarithm of the estimate. An estimate of a rare event scatters by a factor.
//! Source of the levels: Papaioannou, Geyer, Straub 2019.

use crate::Limit;
use crate::estimate::{Budget, Estimate, REPLICAS, Replica};
use crate::gaussian::Gaussian;
use crate::smoothing::Smoothing;
use rand_core::Rng;
use rand_pcg::Pcg64;

const MOST_LEVELS: usize = 9;
/// A replica's runs over those of a level.
const LEVELS_IN_RUNS: usize = 14;
/// The runs after the levels over those of them that go into the last fit.
const REFIT: usize = 3;

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
    let mut pool = Pool::default();
    let mut density = Gaussian::nominal(dimensions);
    let mut smoothing: Option<Smoothing> = None;
    let mut is_settled = false;
    let mut draw = |density: &Gaussian, count: usize| -> Result<(Vec<Vec<f64>>, Vec<f64>), E> {
        let points: Vec<Vec<f64>> = (0..count).map(|_| density.draw(&mut generator)).collect();
        let values = points.iter().map(|point| limit(point)).collect::<Result<_, E>>()?;
        Ok((points, values))
    };
    for _ in 0..MOST_LEVELS {
        let (points, values) = draw(&density, of_level)?;
        is_settled = smoothing.as_ref().is_some_and(|smoothing| smoothing.is_settled(&values));
        let smoothing = smoothing.get_or_insert_with(|| Smoothing::before(&values));
        pool.add(density.clone(), points, values);
        density = pool.fit(smoothing, of_level).unwrap_or(density);
        if is_settled {
            break;
        }
    }
    let left = budget.runs.saturating_sub(pool.points.len()).max(1);
    if let Some(smoothing) = &mut smoothing {
        let (points, values) = draw(&density, left / REFIT)?;
        pool.add(density.clone(), points, values);
        density = pool.fit(smoothing, of_level).unwrap_or(density);
    }
    let count = left - left / REFIT;
    let used = pool.points.len();
    let (points, values) = draw(&density, count)?;
    let events = points.into_iter().zip(values).filter(|(_, value)| *value < 0.0);
    let events: Vec<Vec<f64>> = events.map(|(point, _)| point).collect();
    let weights: Vec<f64> = events.iter().map(|point| density.ratio(point)).collect();
    let probability = weights.iter().fold(0.0, |sum, weight| sum + weight) / count as f64;
    Ok(Replica { probability, runs: used + count, is_settled, events, weights })
}

/// Points of all densities so far.
#[derive(Default)]
struct Pool {
    points: Vec<Vec<f64>>,
    values: Vec<f64>,
    /// Sum over the densities of their share in the points, times density over the nominal one, at each point.
    over_nominal: Vec<f64>,
    densities: Vec<(Gaussian, f64)>,
}

impl Pool {
    fn add(&mut self, density: Gaussian, points: Vec<Vec<f64>>, values: Vec<f64>) {
        let count = points.len() as f64;
        for (sum, point) in self.over_nominal.iter_mut().zip(&self.points) {
            *sum += count / density.ratio(point);
        }
        self.densities.push((density, count));
        let of_all = |point: &Vec<f64>| {
            self.densities.iter().map(|(density, count)| count / density.ratio(point)).sum::<f64>()
        };
        self.over_nominal.extend(points.iter().map(of_all));
        self.points.extend(points);
        self.values.extend(values);
    }

    /// The fit to the points of all densities, each with the weight that it has in their mixture.
    fn fit(&self, smoothing: &mut Smoothing, of_level: usize) -> Option<Gaussian> {
        let count = self.points.len() as f64;
        let ratios: Vec<f64> = self.over_nominal.iter().map(|sum| count / sum).collect();
        let weights = smoothing.weights(&self.values, &ratios, of_level as f64);
        Gaussian::fitted(&self.points, &weights)
    }
}
