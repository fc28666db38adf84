//! Goals for timegap relative to the machine's own floor, judged in the same run. Their limits are ratios to the floor. A
//! changed limit is an entry of its own in CHANGELOG.md.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-21 | futex against itself, p50 and p99 | 1.1, 1.5 | chosen; the true ratio is 1 |
//! | 2026-11-21 | message over futex, p50, same core and two cores | 1.3, 1.15 | chosen |
//! | 2026-11-21 | message over futex, p99 | 1.5 | chosen |
//! | 2026-11-21 | detections, payload, p50 | 1.2, 1.1 | chosen |
//! | 2026-11-21 | net reaction over the sum of its floors, p50 | 1.5 | chosen |
//! | 2026-11-21 | deadline misses over the floor's | 1 | no more than a process that sleeps and computes |

use super::paired::{Compared, Comparison};
use super::setup::Placement;
use super::statistics::{self, Estimate, Events};
use schemars::JsonSchema;
use serde::Serialize;

/// Outcome of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The whole interval is at or below the limit.
    Met,
    /// The whole interval is above the limit.
    Missed,
    /// The interval contains the limit: more samples are needed.
    Undecided,
}

/// A figure over its floor, with the judgement.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Goal {
    /// Names of the two sides and of the figure.
    pub name: String,
    pub placement: Placement,
    /// Unit of both figures: µs, or events per million cycles.
    pub unit: &'static str,
    pub ours: f64,
    pub floor: f64,
    /// Their ratio; null if only ours has an event.
    pub ratio: Option<f64>,
    /// Interval of the true ratio with 95 % confidence, lower and upper end; a null upper end is unbounded.
    pub ci95: [Option<f64>; 2],
    pub limit: f64,
    pub n: u64,
    pub verdict: Verdict,
    /// Differences between this machine and the one that the goal is meant for.
    pub caveats: Vec<String>,
}

impl Goal {
    fn new(name: String, placement: Placement, limit: f64, estimate: Estimate) -> Self {
        let Estimate { ours, floor, ratio, low, high, n } = estimate;
        let verdict = match () {
            () if high <= limit => Verdict::Met,
            () if low > limit => Verdict::Missed,
            () => Verdict::Undecided,
        };
        let finite = |value: f64| value.is_finite().then_some(value);
        let ci95 = [finite(low), finite(high)];
        let caveats = Vec::new();
        let ratio = finite(ratio);
        Self { name, placement, unit: "µs", ours, floor, ratio, ci95, limit, n, verdict, caveats }
    }
}

/// The goals of a comparison. `tails` also judges the 99th percentiles if there are enough samples.
pub fn of_comparison(compared: &Compared, tails: bool) -> Vec<Goal> {
    let (p50, p99) = limits_of(compared.comparison, compared.conditions.placement);
    let name = |figure: &str| format!("{}, {figure}", compared.comparison.label());
    let placement = compared.conditions.placement;
    let sessions = compared.sessions();
    let medians = statistics::medians(&sessions);
    let medians = medians.map(|estimate| Goal::new(name("p50"), placement, p50, estimate));
    let tails = p99.filter(|_| tails).zip(statistics::p99s(&sessions));
    let tails = tails.map(|(limit, estimate)| Goal::new(name("p99"), placement, limit, estimate));
    medians.into_iter().chain(tails).collect()
}

/// The goal of a chain: blocks of (net reaction time, sum of the floors), µs.
pub fn of_chain(period_us: u32, placement: Placement, blocks: &[(f64, f64)]) -> Option<Goal> {
    let name = format!("net reaction over the sum of its floors at {} ms, p50", period_us / 1000);
    statistics::paired(blocks).map(|estimate| Goal::new(name, placement, CHAIN, estimate))
}

/// The goal of the deadlines at 1 ms. It allows the misses of a process that sleeps and then computes as long as the
/// law. It runs on the same core during the same seconds. Without a miss of ours it is met.
pub fn of_misses(placement: Placement, ours: Events, floor: Events) -> Option<Goal> {
    let name = "deadline misses per million at 1 ms over the floor's".to_owned();
    let goal = Goal::new(name, placement, MISSES, statistics::rates(ours, floor)?);
    let goal = Goal { unit: "per million", ..goal };
    Some(if ours.events == 0 { Goal { verdict: Verdict::Met, ..goal } } else { goal })
}

/// Largest ratio of a chain's software overhead to the sum of its floors.
const CHAIN: f64 = 1.5;
/// Largest ratio of the deadline misses to the floor's.
const MISSES: f64 = 1.0;

/// Limits of a comparison: of the medians' ratio and, if judged, of the 99th percentiles' ratio.
fn limits_of(comparison: Comparison, placement: Placement) -> (f64, Option<f64>) {
    match (comparison, placement) {
        // The true ratio is 1: excess up to here may be chance.
        (Comparison::FloorItself, _) => (1.1, Some(1.5)),
        (Comparison::Message, Placement::SameCore) => (1.3, Some(1.5)),
        (Comparison::Message, Placement::TwoCores) => (1.15, Some(1.5)),
        (Comparison::Detections, _) => (1.2, None),
        (Comparison::Payload, _) => (1.1, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::{Conditions, Load, Scheduling};
    use crate::statistics::Pair;

    fn verdict(low: f64, high: f64) -> Verdict {
        let estimate = Estimate { ours: 1.0, floor: 1.0, ratio: 1.0, low, high, n: 1 };
        Goal::new(String::new(), Placement::SameCore, 1.3, estimate).verdict
    }

    #[test]
    fn a_goal_is_met_or_missed_only_by_its_whole_interval() {
        assert_eq!(verdict(1.1, 1.3), Verdict::Met);
        assert_eq!(verdict(1.31, 1.4), Verdict::Missed);
        assert_eq!(verdict(1.2, 1.4), Verdict::Undecided);
        assert_eq!(verdict(0.0, f64::INFINITY), Verdict::Undecided);
    }

    #[test]
    fn a_quick_run_judges_no_99th_percentile() {
        let arm = |ns: u32| (0..250).map(|index| ns + index).collect::<Vec<_>>();
        let pair = Pair { ours: arm(11_000), floor: arm(10_000) };
        let compared = Compared {
            comparison: Comparison::Message,
            conditions: Conditions {
                placement: Placement::SameCore,
                scheduling: Scheduling::Fifo,
                load: Load::Idle,
            },
            period_us: 1_000,
            lost: 0,
            pairs: vec![pair; 20],
        };
        let names = |tails| -> Vec<String> {
            of_comparison(&compared, tails).into_iter().map(|goal| goal.name).collect()
        };
        assert_eq!(names(false).len(), 1);
        assert_eq!(names(true).len(), 2);
        assert!(names(true)[1].ends_with("p99"));
    }

    #[test]
    fn misses_are_compared_as_rates_and_zero_is_enough() {
        let verdict = |ours, floor| {
            let events = |events| Events { events, cycles: 10_000 };
            let goal = of_misses(Placement::SameCore, events(ours), events(floor));
            goal.expect("cycles").verdict
        };
        assert_eq!(verdict(0, 0), Verdict::Met);
        assert_eq!(verdict(40, 4), Verdict::Missed);
        assert_eq!(verdict(5, 4), Verdict::Undecided);
        assert_eq!(verdict(3, 30), Verdict::Met);
        assert!(of_misses(Placement::SameCore, Events::default(), Events::default()).is_none());
    }
}
