//! Results of an estimator, and their intervals.

/// Runs that an estimator may use, and its random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Evaluations of the caller's function.
    pub runs: usize,
    pub seed: u64,
}

/// A probability with its interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    pub probability: f64,
    /// 95 % interval.
    pub interval: [f64; 2],
    /// Evaluations that it took.
    pub runs: usize,
    pub events: usize,
    /// Share of each coordinate in the event's direction: the squares of the event's mean point, which sum to 1. Empty
    /// without an event.
    pub importance: Vec<f64>,
    /// Estimates of the replicas; empty without replicas.
    pub replicas: Vec<f64>,
    /// Replicas whose density did not settle on the event: their estimates may miss a part of it.
    pub unsettled: usize,
}

/// An independent estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct Replica {
    pub probability: f64,
    /// Evaluations that it took.
    pub runs: usize,
    /// The density settled on the event.
    pub is_settled: bool,
    pub events: Vec<Vec<f64>>,
    /// Their weights: nominal density over the one that they were drawn from.
    pub weights: Vec<f64>,
}

impl Estimate {
    /// The estimate of `runs` nominal points, of which these are in the event.
    pub fn of_points(events: &[Vec<f64>], runs: usize) -> Self {
        Self {
            probability: if runs > 0 { events.len() as f64 / runs as f64 } else { 0.0 },
            interval: wilson(events.len(), runs),
            runs,
            events: events.len(),
            importance: importance(&events.iter().map(|u| (u, 1.0)).collect::<Vec<_>>()),
            replicas: Vec::new(),
            unsettled: 0,
        }
    }

    /// The mean of replicas, with the interval of their scatter.
    pub fn of_replicas(all: &[Replica]) -> Self {
        let replicas: Vec<f64> = all.iter().map(|replica| replica.probability).collect();
        let weighed = all.iter().flat_map(|one| one.events.iter().zip(one.weights.iter().copied()));
        let weighed: Vec<(&Vec<f64>, f64)> = weighed.collect();
        Self {
            probability: replicas.iter().sum::<f64>() / replicas.len().max(1) as f64,
            interval: of_replicas(&replicas),
            runs: all.iter().map(|replica| replica.runs).sum(),
            events: weighed.len(),
            importance: importance(&weighed),
            unsettled: all.iter().filter(|replica| !replica.is_settled).count(),
            replicas,
        }
    }
}

/// True if two results contradict each other: their intervals have nothing in common.
pub fn disagree(one: &Estimate, other: &Estimate) -> bool {
    one.interval[1] < other.interval[0] || other.interval[1] < one.interval[0]
}

/// The shares of the coordinates in the event's direction, from its points with their weights.
fn importance(points: &[(&Vec<f64>, f64)]) -> Vec<f64> {
    let Some((first, _)) = points.first() else { return Vec::new() };
    let mean = |place: usize| points.iter().map(|(u, w)| w * u[place]).sum::<f64>();
    let squares: Vec<f64> = (0..first.len()).map(|place| mean(place).powi(2)).collect();
    let whole: f64 = squares.iter().sum();
    if whole > 0.0 { squares.iter().map(|square| square / whole).collect() } else { Vec::new() }
}

pub const REPLICAS: usize = 5;
/// Student's quantile at 97.5 % for one less than the replicas.
const STUDENT: f64 = 2.776445105;

/// The 95 % interval of a share (Wilson 1927).
///
/// ```
/// let [low, high] = rare_events::wilson(0, 100);
/// assert!(low == 0.0 && (high - 0.0370).abs() < 1e-4);
/// ```
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

/// The 95 % interval of the mean of the replicas' estimates.
pub(crate) fn of_replicas(replicas: &[f64]) -> [f64; 2] {
    let count = replicas.len() as f64;
    let mean = replicas.iter().sum::<f64>() / count;
    if replicas.len() < REPLICAS || mean <= 0.0 {
        return [0.0, 1.0];
    }
    let variance = replicas.iter().map(|p| (p - mean) * (p - mean)).sum::<f64>() / (count - 1.0);
    let factor = libm::exp(STUDENT * libm::sqrt(variance / count) / mean);
    [mean / factor, (mean * factor).min(1.0)]
}
