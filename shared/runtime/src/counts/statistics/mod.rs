//! Latency histograms and their percentiles.

#![allow(unsafe_code, reason = "a struct of atomic numbers in shared memory")]

pub mod histogram_log;

use crate::words::{Atomics, Shared};
use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

/// Longest duration that a histogram distinguishes, ns; longer ones are counted as this.
const HIGHEST_NS: u64 = 60_000_000_000;

/// Leading bits of a duration that determine its bucket: two decimal digits need 200 steps.
const DIGIT_BITS: u32 = 8;
const BUCKETS: usize = bucket(HIGHEST_NS) + 1;

/// A histogram: buckets, the longest duration, ns, and the complement of the shortest one. From zero on, all only rise.
#[repr(C, align(4096))]
#[derive(Debug)]
pub(super) struct Buckets {
    counts: [AtomicU32; BUCKETS],
    longest_ns: AtomicU64,
    not_shortest_ns: AtomicU64,
}

// SAFETY: words alone.
unsafe impl Atomics for Buckets {}

impl Buckets {
    fn add(&self, duration_ns: u64, count: u32) {
        // The extremes come first: no process that dies leaves a record beyond them.
        if self.longest_ns.load(Ordering::Relaxed) < duration_ns {
            self.longest_ns.fetch_max(duration_ns, Ordering::Relaxed);
        }
        if self.not_shortest_ns.load(Ordering::Relaxed) < !duration_ns {
            self.not_shortest_ns.fetch_max(!duration_ns, Ordering::Relaxed);
        }
        self.counts[bucket(duration_ns.min(HIGHEST_NS))].fetch_add(count, Ordering::Relaxed);
    }
}

/// The bucket of a duration, by HdrHistogram's layout: one for each ns below 2⁸, and 2⁷ for each doubling above.
const fn bucket(duration_ns: u64) -> usize {
    let shift = u64::BITS - (duration_ns | ((1 << DIGIT_BITS) - 1)).leading_zeros() - DIGIT_BITS;
    ((shift as usize) << (DIGIT_BITS - 1)) + (duration_ns >> shift) as usize
}

const fn shortest_ns(bucket: usize) -> u64 {
    let shift = (bucket >> (DIGIT_BITS - 1)).saturating_sub(1);
    ((bucket - (shift << (DIGIT_BITS - 1))) as u64) << shift
}

const fn longest_ns(bucket: usize) -> u64 {
    shortest_ns(bucket + 1) - 1
}

/// A histogram of durations: no record allocates.
///
/// High dynamic range from 1 ns to 60 s with two significant decimal digits: a bucket is at most 1 % wide. The
/// shortest and the longest duration are exact. Serialized as pairs of a duration and its count, the shortest first and
/// the longest last. A copy has memory of its own.
#[derive(Debug, Serialize, Deserialize)]
#[serde(from = "Vec<(u64, u64)>", into = "Vec<(u64, u64)>")]
pub struct Latencies {
    /// Those of this process, or in shared memory with those of the processes before it.
    buckets: Shared<Buckets>,
    /// It records while this is set.
    records: Arc<AtomicBool>,
}

impl Default for Latencies {
    fn default() -> Self {
        Self { buckets: Shared::private(), records: Arc::new(true.into()) }
    }
}

impl Clone for Latencies {
    fn clone(&self) -> Self {
        self.pairs().into()
    }
}

impl PartialEq for Latencies {
    fn eq(&self, other: &Self) -> bool {
        self.extremes_ns() == other.extremes_ns() && self.recorded().eq(other.recorded())
    }
}

impl From<Latencies> for Vec<(u64, u64)> {
    fn from(latencies: Latencies) -> Self {
        latencies.pairs()
    }
}

impl From<Vec<(u64, u64)>> for Latencies {
    fn from(pairs: Vec<(u64, u64)>) -> Self {
        let latencies = Self::default();
        for (duration_ns, count) in pairs {
            latencies.buckets.add(duration_ns, u32::try_from(count).unwrap_or(u32::MAX));
        }
        latencies
    }
}

impl Latencies {
    /// One in these buckets, which records while `records` is set.
    pub(super) fn of(buckets: Shared<Buckets>, records: Arc<AtomicBool>) -> Self {
        Self { buckets, records }
    }

    /// Records one duration, ns; a negative one counts as zero.
    pub fn record_ns(&mut self, duration_ns: i64) {
        if self.records.load(Ordering::Relaxed) {
            self.buckets.add(u64::try_from(duration_ns).unwrap_or(0), 1);
        }
    }

    /// Durations that stand for the buckets, and the counts. The first and the last are the extremes.
    fn pairs(&self) -> Vec<(u64, u64)> {
        let pairs = self.recorded().map(|(bucket, count)| (longest_ns(bucket), count));
        let mut pairs: Vec<_> = pairs.collect();
        // Both extremes are in one bucket.
        if let [(ns, count @ 2..)] = pairs[..] {
            pairs = vec![(ns, count - 1), (ns, 1)];
        }
        if let Some((shortest_ns, longest_ns)) = self.range_ns() {
            pairs.first_mut().expect("something was recorded").0 = shortest_ns;
            pairs.last_mut().expect("something was recorded").0 = longest_ns;
        }
        pairs
    }

    /// The shortest and the longest duration that was noted, ns. Before the first one it is the other way round.
    fn extremes_ns(&self) -> (u64, u64) {
        let load = |word: &AtomicU64| word.load(Ordering::Relaxed);
        (!load(&self.buckets.not_shortest_ns), load(&self.buckets.longest_ns))
    }

    /// The shortest and the longest duration, ns; `None` if nothing was recorded.
    fn range_ns(&self) -> Option<(u64, u64)> {
        let mut recorded = self.recorded().map(|(bucket, _)| bucket);
        let first = recorded.next()?;
        let last = recorded.last().unwrap_or(first);
        let (shortest, longest) = self.extremes_ns();
        // A process that dies between two stores leaves extremes that its buckets do not have.
        let within = |bucket: usize, duration_ns: u64| {
            let open_end = if bucket + 1 == BUCKETS { u64::MAX } else { longest_ns(bucket) };
            duration_ns.clamp(shortest_ns(bucket), open_end)
        };
        Some((within(first, shortest), within(last, longest)))
    }

    /// The buckets with a count, in the order of their durations.
    fn recorded(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let (shortest_ns, longest_ns) = self.extremes_ns();
        let [first, last] = [shortest_ns, longest_ns].map(|ns| bucket(ns.min(HIGHEST_NS)));
        let counts = self.buckets.counts.iter().map(|count| count.load(Ordering::Relaxed).into());
        counts.enumerate().take(last + 1).skip(first).filter(|(_, count)| *count > 0)
    }

    /// As the HdrHistogram family has it.
    pub(crate) fn histogram(&self) -> Histogram<u64> {
        let mut histogram = Histogram::new_with_bounds(1, HIGHEST_NS, 2)
            .expect("1 <= low, 2 low <= high and 2 digits are valid bounds");
        for (bucket, count) in self.recorded() {
            histogram.saturating_record_n(shortest_ns(bucket), count);
        }
        histogram
    }

    pub fn count(&self) -> u64 {
        self.recorded().map(|(_, count)| count).sum()
    }

    /// Number of recorded durations of more than `duration_ns`, to the resolution of the histogram.
    pub fn count_above_ns(&self, duration_ns: u64) -> u64 {
        let limit = bucket(duration_ns.min(HIGHEST_NS));
        let above = self.recorded().filter(|(bucket, _)| *bucket > limit);
        above.map(|(_, count)| count).sum()
    }

    /// The whole distribution, as a curve; empty if nothing was recorded.
    pub fn quantile_curve(&self) -> QuantileCurve {
        // Ten points between the median and the next quarter, the next eighth, and so on.
        let Some((shortest_ns, longest_ns)) = self.range_ns() else { return Vec::new() };
        let histogram = self.histogram();
        let points = histogram.iter_quantiles(10).map(|point| {
            let ns = point.value_iterated_to().clamp(shortest_ns, longest_ns);
            (point.quantile(), ns as f64 / 1e3)
        });
        points.collect()
    }

    /// Percentiles in microseconds; `None` if nothing was recorded.
    pub fn percentiles_us(&self) -> Option<Percentiles> {
        let (_, most_ns) = self.range_ns()?;
        let histogram = self.histogram();
        let at = |quantile| histogram.value_at_quantile(quantile).min(most_ns) as f64 / 1e3;
        Some(Percentiles {
            p50: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            p999: at(0.999),
            p9999: at(0.9999),
            max: most_ns as f64 / 1e3,
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
    pub p50: f64,
    pub p90: f64,
    pub p99: f64,
    pub p999: f64,
    pub p9999: f64,
    pub max: f64,
    /// Number of samples.
    pub count: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_are_those_of_the_histogram() {
        let histogram = Latencies::default().histogram();
        let values = (0..100_000).chain((100_000..HIGHEST_NS).step_by(9_999_991));
        for ns in values.chain([HIGHEST_NS]) {
            let shortest_ns = shortest_ns(bucket(ns));
            assert_eq!(shortest_ns, histogram.lowest_equivalent(ns), "{ns}");
            assert_eq!(longest_ns(bucket(ns)), histogram.highest_equivalent(ns), "{ns}");
            assert!((longest_ns(bucket(ns)) - shortest_ns) as f64 <= 0.01 * shortest_ns as f64);
            assert!(bucket(ns) < BUCKETS);
        }
    }

    #[test]
    fn counts_are_those_of_the_histogram() {
        let mut random = 1_u64;
        for samples in [1, 2, 3, 10, 999, 1_000, 1_001, 50_000] {
            let (mut latencies, mut longest_ns) = (Latencies::default(), 0);
            for _ in 0..samples {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let ns = random >> 33 >> (random % 31);
                latencies.record_ns(ns as i64);
                longest_ns = ns.max(longest_ns);
            }
            let histogram = latencies.histogram();
            let p = latencies.percentiles_us().expect("samples were recorded");
            assert_eq!((p.max, p.count), (longest_ns as f64 / 1e3, histogram.len()));
            let above = histogram.len() - histogram.count_between(0, 70_000);
            assert_eq!(latencies.count_above_ns(70_000), above);
            assert_eq!((latencies.clone(), latencies.count()), (latencies, samples));
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
    fn figures_above_a_limit_are_counted() {
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
        let mut journey = |durations_ns: &mut dyn Iterator<Item = i64>| {
            durations_ns.for_each(|ns| latencies.record_ns(ns));
            let text = serde_json::to_string(&latencies).expect("plain data");
            let back: Latencies = serde_json::from_str(&text).expect("our own");
            assert_eq!(back, latencies);
            back.range_ns().zip(back.percentiles_us().map(|p| p.max))
        };
        assert_eq!(journey(&mut std::iter::empty()), None);
        // Three in one bucket of 512 ns.
        for (ns, range_ns) in [(70_001, (70_001, 70_001)), (70_003, (70_001, 70_003))] {
            assert_eq!(journey(&mut [ns].into_iter()), Some((range_ns, range_ns.1 as f64 / 1e3)));
        }
        assert_eq!(journey(&mut [70_002].into_iter()), Some(((70_001, 70_003), 70.003)));
        let all = journey(&mut (1..1000).map(|k| k * k * k));
        assert_eq!(all, Some(((1, 997_002_999), 997_002.999)));
    }

    #[test]
    fn nothing_recorded_gives_no_value_and_extremes_saturate() {
        let mut latencies = Latencies::default();
        assert_eq!(latencies.percentiles_us(), None);
        latencies.record_ns(-5);
        latencies.record_ns(i64::MAX);
        assert_eq!((latencies.count(), latencies.range_ns()), (2, Some((0, i64::MAX as u64))));
    }
}
