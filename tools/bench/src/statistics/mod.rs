//! Ratios of two arms with their 95 % intervals: pure functions of the samples.
//!
//! Ours and its floor are measured in alternating blocks; a block of each is a pair. A machine drifts slowly
//! compared with a pair, so that drift affects both arms.
//!
//! Pairs come in sessions with new processes at different times. Effects of a session, such as the place of
//! memory, affect the arms unequally and are part of the spread:
//!
//! * medians: the mean of the sessions' mean log ratios, with Student's t over the sessions;
//! * 99th percentiles: the pooled ones, with a bootstrap over sessions and their pairs. Samples of one block are not
//!   independent, blocks nearly are;
//! * rare events: given their sum, the events of one arm are binomial. This gives an exact interval for the ratio of
//!   two Poisson rates (Clopper and Pearson 1934; Przyborowski and Wilenski 1940).

use ::statistics::{beta_quantile, student_t};
use rand_core::Rng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// Probability outside the intervals.
const TAILS: f64 = 0.05;
/// Fewest samples of an arm for a judged 99th percentile: fifty of them are beyond it.
pub const ENOUGH_FOR_P99: usize = 5_000;
const DRAWS: usize = 1_000;
/// Stream of the bootstrap's generator: the same samples give the same interval.
const STREAM: u128 = 99;

/// A block of each arm, ours first: durations in ns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    pub ours: Vec<u32>,
    pub floor: Vec<u32>,
}

/// A ratio and its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub ours: f64,
    pub floor: f64,
    /// Their ratio; infinite if only ours has events.
    pub ratio: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end; infinite if unbounded.
    pub high: f64,
    pub n: u64,
}

/// Median of some values; `None` without any.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    (n > 0).then(|| (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0)
}

/// The ratio of the medians in µs, from the sessions' mean log ratios; `None` below two sessions.
pub fn medians(sessions: &[&[Pair]]) -> Option<Estimate> {
    let us =
        |block: &[u32]| median(&block.iter().map(|ns| f64::from(*ns) / 1e3).collect::<Vec<_>>());
    // Geometric means: their ratio is the exponential of the mean log ratio.
    let of_session = |session: &&[Pair]| {
        let blocks: Option<Vec<(f64, f64)>> =
            session.iter().map(|pair| us(&pair.ours).zip(us(&pair.floor))).collect();
        let (ours, floor): (Vec<f64>, Vec<f64>) = blocks?.into_iter().unzip();
        geometric_mean(&ours).zip(geometric_mean(&floor))
    };
    let of_sessions: Option<Vec<(f64, f64)>> = sessions.iter().map(of_session).collect();
    let n = sessions.concat().iter().map(|pair| pair.ours.len() as u64).sum();
    Some(Estimate { n, ..paired(&of_sessions?)? })
}

/// Geometric mean of values; `None` without any, or if one is not above 0.
fn geometric_mean(values: &[f64]) -> Option<f64> {
    let positive = !values.is_empty() && values.iter().all(|value| *value > 0.0);
    let logs = values.iter().map(|value| libm::log(*value));
    positive.then(|| libm::exp(logs.sum::<f64>() / values.len() as f64))
}

/// The ratio of paired figures, from their log ratios. `None` below two pairs, or if a figure is not above 0.
pub fn paired(pairs: &[(f64, f64)]) -> Option<Estimate> {
    if pairs.len() < 2 || pairs.iter().any(|pair| !(pair.0 > 0.0 && pair.1 > 0.0)) {
        return None;
    }
    let count = pairs.len() as f64;
    let logs: Vec<f64> = pairs.iter().map(|(ours, floor)| libm::log(ours / floor)).collect();
    let mean = logs.iter().sum::<f64>() / count;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let half = student_t(count - 1.0, TAILS) * (variance / count).sqrt();
    let (ours, floor): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    Some(Estimate {
        ours: median(&ours)?,
        floor: median(&floor)?,
        ratio: libm::exp(mean),
        low: libm::exp(mean - half),
        high: libm::exp(mean + half),
        n: pairs.len() as u64,
    })
}

/// The ratio of the 99th percentiles in µs, with a bootstrap over sessions and pairs. `None` below [`ENOUGH_FOR_P99`]
/// samples in an arm.
pub fn p99s(sessions: &[&[Pair]]) -> Option<Estimate> {
    let pairs = &sessions.concat();
    let counted =
        |arm: fn(&Pair) -> &Vec<u32>| pairs.iter().map(|pair| arm(pair).len()).sum::<usize>();
    let n = counted(|pair| &pair.ours);
    if n.min(counted(|pair| &pair.floor)) < ENOUGH_FOR_P99 {
        return None;
    }
    let all: Vec<usize> = (0..pairs.len()).collect();
    let (ours, floor) = pooled_p99s(pairs, &all)?;
    let mut random = Pcg64::new(n as u128, STREAM);
    random.next_u64();
    let mut below = |count: usize| ((u128::from(random.next_u64()) * count as u128) >> 64) as usize;
    // Place of each session's first pair.
    let firsts: Vec<usize> = (sessions.iter())
        .scan(0, |end, session| {
            *end += session.len();
            Some(*end - session.len())
        })
        .collect();
    let mut ratios = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS {
        let mut drawn = Vec::with_capacity(pairs.len());
        for _ in sessions {
            let session = below(sessions.len());
            let count = sessions[session].len();
            drawn.extend((0..count).map(|_| firsts[session] + below(count)));
        }
        let (ours, floor) = pooled_p99s(pairs, &drawn)?;
        ratios.push(ours / floor);
    }
    ratios.sort_by(f64::total_cmp);
    let at = |share: f64| ratios[(share * (DRAWS - 1) as f64).round() as usize];
    let (low, high) = (at(TAILS / 2.0), at(1.0 - TAILS / 2.0));
    Some(Estimate { ours, floor, ratio: ours / floor, low, high, n: n as u64 })
}

/// The 99th percentiles in µs of the pooled samples of some pairs; `None` if one is 0.
fn pooled_p99s(pairs: &[Pair], chosen: &[usize]) -> Option<(f64, f64)> {
    let of = |arm: fn(&Pair) -> &Vec<u32>| {
        let mut pool: Vec<u32> =
            chosen.iter().flat_map(|&index| arm(&pairs[index])).copied().collect();
        let place = (pool.len() * 99).div_ceil(100).checked_sub(1)?;
        let (_, p99, _) = pool.select_nth_unstable(place);
        (*p99 > 0).then(|| f64::from(*p99) / 1e3)
    };
    of(|pair| &pair.ours).zip(of(|pair| &pair.floor))
}

/// Events among cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    pub events: u64,
    pub cycles: u64,
}

impl Events {
    pub fn per_million(self) -> f64 {
        self.events as f64 * 1e6 / self.cycles.max(1) as f64
    }
}

/// The ratio of two rates of rare events, per million cycles, with its exact interval. `None` without cycles
/// in both arms. Without events in both arms the interval is from 0 to infinity.
pub fn rates(ours: Events, floor: Events) -> Option<Estimate> {
    if ours.cycles == 0 || floor.cycles == 0 {
        return None;
    }
    let exposure = floor.cycles as f64 / ours.cycles as f64;
    let (k, rest) = (ours.events as f64, floor.events as f64);
    let as_ratio = |share: f64| if share >= 1.0 { f64::INFINITY } else { share / (1.0 - share) };
    let low = if ours.events == 0 { 0.0 } else { beta_quantile(k, rest + 1.0, TAILS / 2.0) };
    let high =
        if floor.events == 0 { 1.0 } else { beta_quantile(k + 1.0, rest, 1.0 - TAILS / 2.0) };
    let (a, b) = (ours.per_million(), floor.per_million());
    Some(Estimate {
        ours: a,
        floor: b,
        // Zero events do not exceed zero.
        ratio: if ours.events == 0 { 0.0 } else { a / b },
        low: as_ratio(low) * exposure,
        high: as_ratio(high) * exposure,
        n: ours.cycles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Latencies with a tail, ns, from a stream of its own.
    fn block(random: &mut Pcg64, scale: f64, count: usize) -> Vec<u32> {
        let uniform =
            |random: &mut Pcg64| ((random.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
        (0..count)
            .map(|_| (scale * (5_000.0 - 3_000.0 * libm::log(uniform(random)))) as u32)
            .collect()
    }

    fn pairs(seed: u128, ours: f64, floor: f64) -> Vec<Pair> {
        let mut random = Pcg64::new(seed, 1);
        random.next_u64();
        (0..20)
            .map(|_| {
                // The machine drifts: both blocks of a pair are affected.
                let drift = 1.0 + (random.next_u64() % 100) as f64 / 100.0;
                Pair {
                    ours: block(&mut random, ours * drift, 250),
                    floor: block(&mut random, floor * drift, 250),
                }
            })
            .collect()
    }

    fn sessions(pairs: &[Pair]) -> Vec<&[Pair]> {
        pairs.chunks(4).collect()
    }

    /// Number of runs whose interval holds the true ratio.
    fn covered(runs: u128, ratio: f64, estimate: fn(&[&[Pair]]) -> Option<Estimate>) -> usize {
        let holds = |seed: &u128| {
            let pairs = pairs(*seed, ratio, 1.0);
            let estimate = estimate(&sessions(&pairs)).expect("enough samples");
            (estimate.low..=estimate.high).contains(&ratio)
        };
        (1..=runs).filter(holds).count()
    }

    #[test]
    fn an_interval_of_95_percent_holds_the_truth_about_as_often() {
        for ratio in [1.0, 1.3] {
            let medians = covered(100, ratio, medians);
            assert!(medians >= 88, "{ratio}: {medians} of 100");
            let tails = covered(30, ratio, p99s);
            assert!(tails >= 24, "{ratio}: {tails} of 30");
        }
    }

    #[test]
    fn a_percentile_of_too_few_samples_is_not_judged() {
        let mut pairs = pairs(7, 1.0, 1.0);
        assert!(p99s(&sessions(&pairs)).is_some());
        pairs[0].floor.pop();
        assert!(p99s(&sessions(&pairs)).is_none() && medians(&sessions(&pairs)).is_some());
        assert!(medians(&sessions(&pairs[..4])).is_none(), "one session has no spread");
    }

    #[test]
    fn differences_between_sessions_widen_the_interval() {
        let steady = pairs(3, 1.3, 1.0);
        let mut shifting = steady.clone();
        for (session, pairs) in shifting.chunks_mut(4).enumerate() {
            // Processes of each session have their memory at another place.
            let factor = 1.0 + 0.05 * session as f64;
            for ns in pairs.iter_mut().flat_map(|pair| &mut pair.ours) {
                *ns = (f64::from(*ns) * factor) as u32;
            }
        }
        let width = |pairs: &[Pair]| {
            let estimate = medians(&sessions(pairs)).expect("five sessions");
            estimate.high / estimate.low
        };
        assert!(width(&shifting) > 1.1 && width(&shifting) > width(&steady));
    }

    #[test]
    fn rare_events_have_the_exact_interval() {
        let events = |events, cycles| Events { events, cycles };
        // 10 against 10 in equal time: Clopper and Pearson's 0.272 to 0.728 of the sum.
        let even = rates(events(10, 1_000), events(10, 1_000)).expect("cycles");
        assert!(
            (even.low - 0.272 / 0.728).abs() < 2e-3 && (even.high - 0.728 / 0.272).abs() < 2e-2
        );
        assert_eq!(even.ratio, 1.0);
        let none = rates(events(0, 1_000), events(0, 1_000)).expect("cycles");
        assert_eq!((none.ratio, none.low, none.high), (0.0, 0.0, f64::INFINITY));
        let only_ours = rates(events(20, 1_000), events(0, 1_000)).expect("cycles");
        assert!(only_ours.low > 1.0 && only_ours.high.is_infinite());
        assert!(rates(events(0, 0), events(1, 5)).is_none());
        let longer = rates(events(10, 2_000), events(10, 1_000)).expect("cycles");
        assert!((longer.low - 0.5 * even.low).abs() < 1e-9, "rates, not counts");
    }

    proptest! {
        #[test]
        fn an_interval_holds_its_ratio(
            a in proptest::collection::vec(1.0_f64..1e6, 2..40),
            scale in 0.1_f64..10.0,
        ) {
            let pairs: Vec<_> = a.iter().enumerate()
                .map(|(index, value)| (value * scale * (1.0 + 0.01 * (index % 3) as f64), *value))
                .collect();
            let estimate = paired(&pairs).expect("two pairs at least");
            prop_assert!(estimate.low <= estimate.ratio && estimate.ratio <= estimate.high);
        }

        #[test]
        fn exchanging_the_arms_inverts_the_ratio(seed in 1_u128..1_000) {
            let there = pairs(seed, 1.3, 1.0);
            let back: Vec<_> = (there.iter())
                .map(|pair| Pair { ours: pair.floor.clone(), floor: pair.ours.clone() })
                .collect();
            let medians = |pairs: &[Pair]| medians(&sessions(pairs)).expect("five sessions");
            let (there, back) = (medians(&there), medians(&back));
            prop_assert!((there.ratio * back.ratio - 1.0).abs() < 1e-12);
            prop_assert!((there.low * back.high - 1.0).abs() < 1e-12);
        }

        #[test]
        fn more_events_of_ours_raise_the_interval(k in 0_u64..50, floor in 0_u64..50) {
            let with = |events| {
                let ours = Events { events, cycles: 10_000 };
                rates(ours, Events { events: floor, cycles: 10_000 }).expect("cycles")
            };
            let (less, more) = (with(k), with(k + 1));
            prop_assert!(less.low <= more.low && less.high <= more.high);
            prop_assert!(more.low <= more.ratio && more.ratio <= more.high);
        }
    }
}
