//! Latency histograms and their percentiles.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

/// Longest duration a histogram tells apart, ns; longer ones are counted as this.
const HIGHEST_NS: u64 = 60_000_000_000;

/// A histogram of durations, allocated once: recording allocates nothing.
///
/// High dynamic range from 1 ns to 60 s with two significant decimal digits.
/// Serialized as pairs of a duration and its count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<(u64, u64)>", into = "Vec<(u64, u64)>")]
pub struct Latencies(Histogram<u64>);

impl Default for Latencies {
    fn default() -> Self {
        let histogram = Histogram::new_with_bounds(1, HIGHEST_NS, 2)
            .expect("1 <= low, 2 low <= high and 2 digits are valid bounds");
        Self(histogram)
    }
}

impl From<Latencies> for Vec<(u64, u64)> {
    fn from(latencies: Latencies) -> Self {
        let recorded = latencies.0.iter_recorded();
        recorded.map(|value| (value.value_iterated_to(), value.count_at_value())).collect()
    }
}

impl From<Vec<(u64, u64)>> for Latencies {
    fn from(pairs: Vec<(u64, u64)>) -> Self {
        let mut latencies = Self::default();
        for (duration_ns, count) in pairs {
            latencies.0.saturating_record_n(duration_ns, count);
        }
        latencies
    }
}

impl Latencies {
    /// Records one duration, ns; a negative one counts as zero.
    pub fn record_ns(&mut self, duration_ns: i64) {
        self.0.saturating_record(u64::try_from(duration_ns).unwrap_or(0));
    }

    pub(crate) fn histogram(&self) -> &Histogram<u64> {
        &self.0
    }

    /// Number of recorded durations.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.len()
    }

    /// Number of recorded durations of more than `duration_ns`, to the resolution of the histogram.
    #[must_use]
    pub fn count_above_ns(&self, duration_ns: u64) -> u64 {
        self.0.len() - self.0.count_between(0, duration_ns)
    }

    /// The whole distribution, as a curve; empty if nothing was recorded.
    #[must_use]
    pub fn quantile_curve(&self) -> QuantileCurve {
        // Ten points between the median and the next quarter, the next eighth, and so on.
        let points = self
            .0
            .iter_quantiles(10)
            .map(|point| (point.quantile(), point.value_iterated_to() as f64 / 1e3));
        points.collect()
    }

    /// Percentiles in microseconds; `None` if nothing was recorded.
    #[must_use]
    pub fn percentiles_us(&self) -> Option<Percentiles> {
        if self.0.is_empty() {
            return None;
        }
        let at = |quantile: f64| self.0.value_at_quantile(quantile) as f64 / 1e3;
        Some(Percentiles {
            p50: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            p999: at(0.999),
            p9999: at(0.9999),
            max: self.0.max() as f64 / 1e3,
            count: self.0.len(),
        })
    }
}

/// A distribution by its quantiles: (share of the samples, value in µs) in rising order, finer
/// towards the tail.
pub type QuantileCurve = Vec<(f64, f64)>;

/// Percentiles of a distribution and the number of samples behind them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Median.
    pub p50: f64,
    /// 90th percentile.
    pub p90: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// 99.99th percentile.
    pub p9999: f64,
    /// Largest sample.
    pub max: f64,
    /// Number of samples.
    pub count: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_known_distribution() {
        let mut latencies = Latencies::default();
        for us in 1..=10_000 {
            latencies.record_ns(us * 1_000);
        }
        let p = latencies.percentiles_us().expect("samples were recorded");
        let near = |got: f64, exact: f64| (got - exact).abs() <= exact * 0.01;
        assert!(near(p.p50, 5_000.0) && near(p.p90, 9_000.0) && near(p.p99, 9_900.0), "{p:?}");
        assert!(near(p.p999, 9_990.0) && near(p.p9999, 9_999.0) && near(p.max, 1e4), "{p:?}");
        assert_eq!(p.count, 10_000);
    }

    #[test]
    fn what_is_above_a_limit_is_counted() {
        let mut latencies = Latencies::default();
        for us in 1..=1_000 {
            latencies.record_ns(us * 1_000);
        }
        assert_eq!(latencies.count_above_ns(0), 1_000);
        assert!(latencies.count_above_ns(900_000).abs_diff(100) <= 10);
        assert_eq!(latencies.count_above_ns(2_000_000), 0);
    }

    #[test]
    fn the_curve_rises_to_the_largest_sample() {
        let mut latencies = Latencies::default();
        assert!(latencies.quantile_curve().is_empty());
        for us in 1..=1_000 {
            latencies.record_ns(us * 1_000);
        }
        let curve = latencies.quantile_curve();
        assert!(curve.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 <= pair[1].1));
        let median = curve.iter().find(|point| point.0 >= 0.5).map(|point| point.1);
        assert!(median.is_some_and(|us| (us - 500.0).abs() <= 5.0), "{median:?}");
        assert!(curve.last().is_some_and(|last| last.0 == 1.0 && (last.1 - 1000.0).abs() <= 10.0));
    }

    #[test]
    fn a_histogram_survives_its_journey() {
        let mut latencies = Latencies::default();
        for k in 0..1000_i64 {
            latencies.record_ns(k * k * k);
        }
        let text = serde_json::to_string(&latencies).expect("plain data");
        let back: Latencies = serde_json::from_str(&text).expect("our own");
        assert_eq!(back.count(), 1000);
        assert_eq!(back.percentiles_us(), latencies.percentiles_us());
    }

    #[test]
    fn nothing_recorded_is_none_and_extremes_saturate() {
        let mut latencies = Latencies::default();
        assert_eq!(latencies.percentiles_us(), None);
        latencies.record_ns(-5);
        latencies.record_ns(i64::MAX);
        assert_eq!(latencies.count(), 2);
    }
}
