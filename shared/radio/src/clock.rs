//! Difference between another host's wall clock and this one, from questions and answers.
//!
//! The asking host notes t1 when it asks and t4 when the answer arrives, by its own clock. The other host notes t2 when
//! the question arrives and t3 when it answers. Both are by its clock (RFC 5905, section 8):
//!
//! ```text
//! offset = ((t2 - t1) + (t3 - t4)) / 2      round trip = (t4 - t1) - (t3 - t2)
//! ```
//!
//! For any delays, the true offset is within half a round trip of the estimate. So the question with the shortest round
//! trip is the best one. Older ones lose value. Clocks drift apart by at most
//! [`drift_ppm`](crate::numbers::Numbers::drift_ppm), twice the 50 parts per million of a usual crystal.
//!
//! After a clock was set, earlier and later exchanges contradict each other. Then the earlier ones are
//! dropped.

use serde::{Deserialize, Serialize};

use crate::numbers::Numbers;

/// A question with its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Exchange {
    /// t1, by the own clock, ns.
    pub(crate) asked_ns: i64,
    /// t2, by the other clock, ns.
    pub(crate) heard_ns: i64,
    /// t3, by the other clock, ns.
    pub(crate) answered_ns: i64,
    /// t4, by the own clock, ns.
    pub(crate) returned_ns: i64,
}

/// Difference of two clocks at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockDifference {
    /// The other clock minus the own one, ns.
    pub offset_ns: i64,
    /// Largest error of `offset_ns`, ns.
    pub uncertainty_ns: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockComparison {
    /// The other clock minus the own one, us.
    #[serde(rename = "clock_offset_us")]
    pub offset_us: f64,
    /// Largest error of `offset_us`, us.
    #[serde(rename = "clock_uncertainty_us")]
    pub uncertainty_us: f64,
    /// Shortest round trip of a question and its answer, us.
    pub shortest_round_trip_us: f64,
    /// Number of answered questions.
    pub answers: u64,
}

/// The exchanges with one host.
#[derive(Clone, Debug, Default)]
pub(crate) struct Comparison {
    pub(crate) numbers: Numbers,
    last: Vec<Exchange>,
    next: usize,
    answers: u64,
}

impl ClockDifference {
    /// True if one offset fits both.
    fn agrees(&self, other: &Self) -> bool {
        let apart = self.offset_ns.saturating_sub(other.offset_ns).saturating_abs();
        apart <= self.uncertainty_ns.saturating_add(other.uncertainty_ns)
    }
}

impl Exchange {
    fn offset_ns(&self) -> i64 {
        // Subtract first: the sum of two wall clocks would overflow.
        let there = self.heard_ns.wrapping_sub(self.asked_ns);
        let back = self.answered_ns.wrapping_sub(self.returned_ns);
        there / 2 + back / 2 + (there % 2 + back % 2) / 2
    }

    fn round_trip_ns(&self) -> i64 {
        let whole = self.returned_ns.wrapping_sub(self.asked_ns);
        whole.saturating_sub(self.answered_ns.wrapping_sub(self.heard_ns))
    }

    fn difference(&self, now_ns: i64, drift_ppm: u32) -> ClockDifference {
        let age_ns = now_ns.saturating_sub(self.returned_ns).max(0);
        let drift_ns = age_ns / 1_000_000 * i64::from(drift_ppm);
        // Half of an odd number of nanoseconds is rounded up.
        let uncertainty_ns = (self.round_trip_ns() / 2).saturating_add(1 + drift_ns);
        ClockDifference { offset_ns: self.offset_ns(), uncertainty_ns }
    }
}

impl Comparison {
    /// Adds an exchange; false if its stamps are impossible.
    pub(crate) fn take(&mut self, exchange: Exchange) -> bool {
        let is_ordered = exchange.returned_ns >= exchange.asked_ns
            && exchange.answered_ns >= exchange.heard_ns
            && exchange.round_trip_ns() >= 0;
        if !is_ordered {
            return false;
        }
        self.answers += 1;
        let now_ns = exchange.returned_ns;
        let Numbers { drift_ppm, remembered, .. } = self.numbers;
        let newest = exchange.difference(now_ns, drift_ppm);
        if !self.last.iter().all(|older| newest.agrees(&older.difference(now_ns, drift_ppm))) {
            self.last.clear();
            self.next = 0;
        }
        if self.last.len() < remembered as usize {
            self.last.push(exchange);
        } else {
            self.last[self.next] = exchange;
        }
        self.next = (self.next + 1) % remembered as usize;
        true
    }

    /// The difference at `now_ns` by the own clock; `None` before the first answer.
    pub(crate) fn difference(&self, now_ns: i64) -> Option<ClockDifference> {
        let all = self.last.iter();
        let all = all.map(|exchange| exchange.difference(now_ns, self.numbers.drift_ppm));
        all.min_by_key(|difference| difference.uncertainty_ns)
    }

    /// The result at `now_ns` by the own clock.
    pub(crate) fn report(&self, now_ns: i64) -> Option<ClockComparison> {
        let difference = self.difference(now_ns)?;
        let shortest = self.last.iter().map(Exchange::round_trip_ns).min()?;
        Some(ClockComparison {
            offset_us: difference.offset_ns as f64 / 1e3,
            uncertainty_us: difference.uncertainty_ns as f64 / 1e3,
            shortest_round_trip_us: shortest as f64 / 1e3,
            answers: self.answers,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SECOND: i64 = 1_000_000_000;

    /// An exchange with delays `there` and `back` and a clock that is `offset` ahead.
    fn exchange(asked_ns: i64, there: i64, stay: i64, back: i64, offset: i64) -> Exchange {
        Exchange {
            asked_ns,
            heard_ns: asked_ns + there + offset,
            answered_ns: asked_ns + there + stay + offset,
            returned_ns: asked_ns + there + stay + back,
        }
    }

    #[test]
    fn equal_ways_give_the_exact_offset() {
        let mut clock = Comparison::default();
        assert_eq!(clock.difference(0), None);
        assert!(clock.take(exchange(5 * SECOND, 2_000_000, 300, 2_000_000, -7_000_000)));
        let now_ns = 5 * SECOND + 4_000_300;
        let difference = clock.difference(now_ns).expect("one answer");
        assert_eq!(
            difference,
            ClockDifference { offset_ns: -7_000_000, uncertainty_ns: 2_000_001 }
        );
    }

    #[test]
    fn the_shortest_round_trip_counts_until_drift_has_eaten_its_lead() {
        let mut clock = Comparison::default();
        assert!(clock.take(exchange(0, 1_000_000, 0, 1_000_000, 500)));
        assert!(clock.take(exchange(20 * SECOND, 9_000_000, 0, 1_000_000, 500)));
        let offset = |now_ns| clock.difference(now_ns).expect("answers").offset_ns;
        assert_eq!(offset(20 * SECOND + 10_000_000), 500, "1 ms and 2 ms of drift beat 5 ms");
        let mut fresh = clock.clone();
        assert!(fresh.take(exchange(60 * SECOND, 3_000_000, 0, 1_000_000, 500)));
        let difference = fresh.difference(60 * SECOND + 4_000_000).expect("answers");
        assert_eq!(difference.offset_ns, 1_000_500, "2 ms beat 1 ms and 6 ms of drift");
    }

    #[test]
    fn a_clock_that_is_set_is_noticed_with_the_next_answer() {
        for step in [-3600 * SECOND, -10_000_000, 10_000_000, 3600 * SECOND] {
            let mut clock = Comparison::default();
            for k in 0..40 {
                assert!(clock.take(exchange(k * SECOND, 1_000_000, 0, 1_000_000, 500)));
            }
            assert!(clock.take(exchange(40 * SECOND, 2_000_000, 0, 2_000_000, 500 + step)));
            let difference = clock.difference(40 * SECOND + 4_000_000).expect("answers");
            assert_eq!(difference.offset_ns, 500 + step);
            // The own clock is set back by an hour, so that the other one appears ahead.
            let asked_ns = 41 * SECOND - 3600 * SECOND;
            let offset = 500 + step + 3600 * SECOND;
            assert!(clock.take(exchange(asked_ns, 1_000_000, 0, 1_000_000, offset)));
            let difference = clock.difference(asked_ns + 2_000_000).expect("answers");
            assert_eq!(difference.offset_ns, offset);
        }
    }

    #[test]
    fn stamps_that_cannot_be_true_are_refused() {
        let mut clock = Comparison::default();
        let mut wrong = exchange(SECOND, 1000, 0, 1000, 0);
        wrong.returned_ns = SECOND - 1;
        assert!(!clock.take(wrong));
        let slow = Exchange { answered_ns: i64::MAX, heard_ns: i64::MIN, ..wrong };
        assert!(!clock.take(slow));
        assert!(!clock.take(exchange(SECOND, 1000, 5000, -2000, 0)));
        assert_eq!(clock.report(2 * SECOND), None);
    }

    proptest! {
        #[test]
        fn the_truth_is_within_the_uncertainty(
            ways in prop::collection::vec((0..50_000_000i64, 0..1_000_000i64, 0..50_000_000i64), 1..80),
            offset in -3600 * SECOND..3600 * SECOND, ppm in -100..=100i64,
        ) {
            let mut clock = Comparison::default();
            let start_ns = 1_800_000_000 * SECOND;
            for (k, (there, stay, back)) in (0..).zip(ways) {
                let asked_ns = start_ns + k * SECOND;
                // The other clock drifts.
                let offset_now = offset + k * ppm * 1000;
                prop_assert!(clock.take(exchange(asked_ns, there, stay, back, offset_now)));
                let now_ns = asked_ns + there + stay + back;
                let found = clock.difference(now_ns).expect("there were answers");
                let error = (found.offset_ns - offset_now).abs();
                prop_assert!(error <= found.uncertainty_ns, "{error} {found:?}");
            }
        }
    }
}
