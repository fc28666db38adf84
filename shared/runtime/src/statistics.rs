//! Latency histograms and their percentiles.

use crate::kept::Buckets;
use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Longest duration a histogram tells apart, ns; longer ones are counted as this.
const HIGHEST_NS: u64 = 60_000_000_000;

/// Bits of a duration that its bucket tells: two decimal digits need 200 steps.
const DIGIT_BITS: u32 = 8;
/// Buckets of a histogram.
pub(crate) const BUCKETS: usize = bucket(HIGHEST_NS) + 1;

/// The bucket of a duration, as HdrHistogram lays them out: one for each ns below 2⁸, and 2⁷ for each doubling
/// above.
const fn bucket(duration_ns: u64) -> usize {
    let shift = u64::BITS - (duration_ns | ((1 << DIGIT_BITS) - 1)).leading_zeros() - DIGIT_BITS;
    ((shift as usize) << (DIGIT_BITS - 1)) + (duration_ns >> shift) as usize
}

/// Shortest duration of a bucket, ns.
const fn shortest_ns(bucket: usize) -> u64 {
    let shift = (bucket >> (DIGIT_BITS - 1)).saturating_sub(1);
    ((bucket - (shift << (DIGIT_BITS - 1))) as u64) << shift
}

/// A histogram of durations, allocated once: recording allocates nothing.
///
/// High dynamic range from 1 ns to 60 s with two significant decimal digits.
/// Serialized as pairs of a duration and its count. A copy has memory of its own.
#[derive(Debug, Serialize, Deserialize)]
#[serde(from = "Vec<(u64, u64)>", into = "Vec<(u64, u64)>")]
pub struct Latencies(Counts);

/// Where the counts are.
#[derive(Debug)]
enum Counts {
    Own(Histogram<u64>),
    /// In shared memory, with those of the processes before this one.
    Kept(Buckets),
}

/// A histogram of durations, each with its count.
fn filled(pairs: impl IntoIterator<Item = (u64, u64)>) -> Histogram<u64> {
    let mut histogram = Histogram::new_with_bounds(1, HIGHEST_NS, 2)
        .expect("1 <= low, 2 low <= high and 2 digits are valid bounds");
    for (duration_ns, count) in pairs {
        histogram.saturating_record_n(duration_ns, count);
    }
    histogram
}

impl Default for Latencies {
    fn default() -> Self {
        Self(Counts::Own(filled([])))
    }
}

impl Clone for Latencies {
    fn clone(&self) -> Self {
        Self(Counts::Own(self.histogram().into_owned()))
    }
}

impl PartialEq for Latencies {
    fn eq(&self, other: &Self) -> bool {
        self.histogram() == other.histogram()
    }
}

impl From<Latencies> for Vec<(u64, u64)> {
    fn from(latencies: Latencies) -> Self {
        let histogram = latencies.histogram();
        let recorded = histogram.iter_recorded();
        recorded.map(|value| (value.value_iterated_to(), value.count_at_value())).collect()
    }
}

impl From<Vec<(u64, u64)>> for Latencies {
    fn from(pairs: Vec<(u64, u64)>) -> Self {
        Self(Counts::Own(filled(pairs)))
    }
}

impl Latencies {
    /// One whose counts outlive the process.
    pub(crate) fn kept(buckets: Buckets) -> Self {
        Self(Counts::Kept(buckets))
    }

    /// Records one duration, ns; a negative one counts as zero.
    pub fn record_ns(&mut self, duration_ns: i64) {
        let duration_ns = u64::try_from(duration_ns).unwrap_or(0);
        match &mut self.0 {
            Counts::Own(histogram) => histogram.saturating_record(duration_ns),
            Counts::Kept(buckets) => buckets.add(bucket(duration_ns.min(HIGHEST_NS))),
        }
    }

    pub(crate) fn histogram(&self) -> Cow<'_, Histogram<u64>> {
        match &self.0 {
            Counts::Own(histogram) => Cow::Borrowed(histogram),
            Counts::Kept(buckets) => {
                let pairs = (0..BUCKETS).map(|bucket| (shortest_ns(bucket), buckets.count(bucket)));
                Cow::Owned(filled(pairs.filter(|(_, count)| *count > 0)))
            }
        }
    }

    /// Number of recorded durations.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.histogram().len()
    }

    /// Number of recorded durations of more than `duration_ns`, to the resolution of the histogram.
    #[must_use]
    pub fn count_above_ns(&self, duration_ns: u64) -> u64 {
        let histogram = self.histogram();
        histogram.len() - histogram.count_between(0, duration_ns)
    }

    /// The whole distribution, as a curve; empty if nothing was recorded.
    #[must_use]
    pub fn quantile_curve(&self) -> QuantileCurve {
        // Ten points between the median and the next quarter, the next eighth, and so on.
        let histogram = self.histogram();
        let points = histogram
            .iter_quantiles(10)
            .map(|point| (point.quantile(), point.value_iterated_to() as f64 / 1e3));
        points.collect()
    }

    /// Percentiles in microseconds; `None` if nothing was recorded.
    #[must_use]
    pub fn percentiles_us(&self) -> Option<Percentiles> {
        let histogram = self.histogram();
        if histogram.is_empty() {
            return None;
        }
        let at = |quantile: f64| histogram.value_at_quantile(quantile) as f64 / 1e3;
        Some(Percentiles {
            p50: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            p999: at(0.999),
            p9999: at(0.9999),
            max: histogram.max() as f64 / 1e3,
            count: histogram.len(),
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
    fn buckets_are_those_of_the_histogram() {
        let histogram = Latencies::default().histogram().into_owned();
        let values = (0..100_000).chain((100_000..HIGHEST_NS).step_by(9_999_991));
        for ns in values.chain([HIGHEST_NS]) {
            let shortest_ns = shortest_ns(bucket(ns));
            assert_eq!(shortest_ns, histogram.lowest_equivalent(ns), "{ns}");
            assert!(bucket(ns) < BUCKETS);
        }
    }

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
