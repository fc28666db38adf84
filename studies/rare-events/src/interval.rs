//! Intervals of estimates.

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
