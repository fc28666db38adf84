//! A process judged by its count of cycles.

/// Decides by another process's count of cycles whether that process works.
#[derive(Debug)]
pub struct CycleWatch {
    /// Cycles that it had done at the last look, and since when it had done them.
    cycles: u64,
    since_ns: i64,
    looked_ns: i64,
    period_ns: i64,
    timeout_ns: i64,
}

impl CycleWatch {
    /// A watch from `now_ns` on over a process that works every `period_ns`.
    pub fn new(now_ns: i64, period_ns: i64, timeout_ns: i64) -> Self {
        Self { cycles: 0, since_ns: now_ns, looked_ns: now_ns, period_ns, timeout_ns }
    }

    /// Looks at the count at `now_ns`; true if the process completed no cycle for a period and the timeout.
    pub fn is_silent(&mut self, now_ns: i64, cycles: u64) -> bool {
        // If this process did not get the processor, the other one may not have got it either.
        let stalled = 2 * (now_ns - self.looked_ns) > 3 * self.period_ns.max(self.timeout_ns);
        self.looked_ns = now_ns;
        if cycles != self.cycles || stalled {
            (self.cycles, self.since_ns) = (cycles, now_ns);
            return false;
        }
        now_ns - self.since_ns > self.period_ns + self.timeout_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD_NS: i64 = 100;
    const TIMEOUT_NS: i64 = 30;

    #[test]
    fn a_process_is_silent_after_a_period_and_the_timeout() {
        let mut watch = CycleWatch::new(1_000, PERIOD_NS, TIMEOUT_NS);
        assert!(!watch.is_silent(1_100, 1), "its first cycle");
        assert!(!watch.is_silent(1_200, 1));
        assert!(!watch.is_silent(1_230, 1), "not longer than both");
        assert!(watch.is_silent(1_231, 1));
        assert!(watch.is_silent(1_300, 1), "it stays silent");
        assert!(!watch.is_silent(1_310, 2), "it works again");
        assert!(!watch.is_silent(1_440, 2));
        assert!(watch.is_silent(1_441, 2));
    }

    #[test]
    fn an_observer_that_did_not_run_itself_starts_anew() {
        let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
        assert!(watch.is_silent(150, 0), "1.5 periods between two looks are usual");
        let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
        assert!(!watch.is_silent(151, 0), "more are not");
        assert!(!watch.is_silent(281, 0), "from 151 on");
        assert!(watch.is_silent(282, 0));
        // The longer one of period and timeout is the measure.
        let mut watch = CycleWatch::new(0, PERIOD_NS, 1_000);
        assert!(watch.is_silent(1_500, 0), "1.5 timeouts");
        let mut watch = CycleWatch::new(0, PERIOD_NS, 1_000);
        assert!(!watch.is_silent(1_501, 0));
    }

    proptest! {
        #[test]
        fn a_process_that_completes_a_cycle_before_each_look_is_never_silent(
            pauses in prop::collection::vec(1_i64..2_000, 1..50),
        ) {
            let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
            let mut now_ns = 0;
            for (cycle, pause_ns) in (1..).zip(pauses) {
                now_ns += pause_ns;
                prop_assert!(!watch.is_silent(now_ns, cycle));
            }
        }

        #[test]
        fn a_process_that_ended_is_noticed_by_an_observer_that_runs(
            pauses in prop::collection::vec(1_i64..=150, 1..200),
        ) {
            let mut watch = CycleWatch::new(0, PERIOD_NS, TIMEOUT_NS);
            let mut now_ns = 0;
            for pause_ns in pauses {
                now_ns += pause_ns;
                prop_assert_eq!(watch.is_silent(now_ns, 0), now_ns > PERIOD_NS + TIMEOUT_NS);
            }
        }
    }
}
