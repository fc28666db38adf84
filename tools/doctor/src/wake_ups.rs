//! The question of a platform engineer: which loops hold on this machine, now?
//!
//! A thread with the scheduling of a service sleeps to absolute instants, as every service does. Its lateness
//! is the floor of any loop of that period. A loop holds if no wake-up came later than its budget.
//!
//! ```text
//!          period                     period
//! ├────────────────────────┼────────────────────────┤
//! ▲ due    ▲ woke          ▲ due  ▲ woke
//! └ late ──┘ budget        └ late ┘
//! ```
//!
//! ```
//! use doctor::wake_ups::LoopFigures;
//!
//! let figures = LoopFigures { period_us: 10_000, budget_us: 1_000, wakes: 200, late: 0, p50_us: 9.0, worst_us: 212.0 };
//! let answer = "a 10 ms loop with a budget of 1 ms holds (0 of 200 late, worst 212.0 µs)";
//! assert_eq!(figures.answer(), answer);
//! ```

use super::finding::Finding;
use clap::Args;
use report::print::duration;
use report::results::{Column, Table, count, word};
use runtime::scheduling::{self, Granted, Policy, Request, usable_cores};
use runtime::statistics::Latencies;
use runtime::{monotonic_ns, sleep_until};
use serde::Serialize;
use serde_json::{Value, json};
use supervise::number_within;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Loop {
    pub period_us: u32,
    /// Largest accepted lateness, µs.
    pub budget_us: u32,
}

/// Part of a period that a loop may lose to a late wake-up. Chosen: the law and the message need the rest.
const BUDGET: u32 = 10;
/// A fast chassis loop and the fastest loop of timegap.
pub const USUAL: [Loop; 2] = [Loop::of(10_000), Loop::of(1_000)];

impl Loop {
    const fn of(period_us: u32) -> Self {
        Self { period_us, budget_us: period_us / BUDGET }
    }
}

/// A loop of the user's own.
///
/// ```
/// use doctor::wake_ups::{Loop, LoopOptions};
///
/// let own = LoopOptions { period_ms: Some(2.0), budget_ms: Some(0.5) };
/// assert_eq!(own.loops(), [Loop { period_us: 2_000, budget_us: 500 }]);
/// assert_eq!(LoopOptions::default().loops().len(), 2);
/// ```
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct LoopOptions {
    /// Period of a loop of yours, ms [default: loops of 10 ms and 1 ms]
    #[arg(long, value_name = "MS", value_parser = number_within(0.01..=10_000.0, "a number of milliseconds"))]
    pub period_ms: Option<f64>,
    /// Largest lateness of a wake-up that your loop accepts, ms [default: a tenth of the period]
    #[arg(long, value_name = "MS", value_parser = number_within(0.01..=10_000.0, "a number of milliseconds"), requires = "period_ms")]
    pub budget_ms: Option<f64>,
}

impl LoopOptions {
    pub fn loops(&self) -> Vec<Loop> {
        let us = |ms: f64| (1e3 * ms).round() as u32;
        let Some(period_ms) = self.period_ms else { return USUAL.to_vec() };
        let usual = Loop::of(us(period_ms));
        vec![Loop { budget_us: self.budget_ms.map_or(usual.budget_us, us), ..usual }]
    }
}

/// Upper ends of the histogram's bins, µs; the last bin is open.
const BINS_US: [u32; 9] = [5, 10, 20, 50, 100, 200, 500, 1_000, 10_000];
/// Widest bar of the histogram, characters.
const BAR: u64 = 32;

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopFigures {
    pub period_us: u32,
    /// Largest accepted lateness, µs.
    pub budget_us: u32,
    pub wakes: u64,
    /// Wake-ups that came later than the budget.
    pub late: u64,
    /// Median of the lateness, µs.
    pub p50_us: f64,
    /// Largest lateness, µs.
    pub worst_us: f64,
}

/// A bin of the histogram of lateness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Bin {
    /// Upper end, µs; null for the open last bin.
    pub up_to_us: Option<u32>,
    /// Wake-ups.
    pub count: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WakeUps {
    /// Length of the measurement of each loop, s.
    pub seconds: f64,
    /// Scheduling policy that the kernel granted.
    pub granted: String,
    /// The loops, the fastest one last.
    pub loops: Vec<LoopFigures>,
    /// Lateness of the last loop.
    pub histogram: Vec<Bin>,
}

impl LoopFigures {
    /// True if no wake-up was later than the budget.
    pub fn holds(&self) -> bool {
        self.wakes > 0 && self.late == 0
    }

    /// The answer for this loop, in words.
    pub fn answer(&self) -> String {
        let Self { wakes, late, .. } = self;
        let verb = if self.holds() { "holds" } else { "does not hold" };
        let (period, budget) = (whole(self.period_us), whole(self.budget_us));
        let worst = duration(self.worst_us);
        format!(
            "a {period} loop with a budget of {budget} {verb} ({late} of {wakes} late, worst {worst})"
        )
    }
}

/// A duration without decimals.
fn whole(us: u32) -> String {
    if us.is_multiple_of(1_000) { format!("{} ms", us / 1_000) } else { format!("{us} µs") }
}

/// Measures each loop for `seconds`, with the scheduling of a service on the last usable core. Returns the
/// lateness of the last loop too.
pub fn measure(loops: &[Loop], seconds: f64) -> (WakeUps, Latencies) {
    let request = Request {
        policy: Policy::Fifo(80),
        core: usable_cores().last().copied(),
        lock_memory: true,
    };
    let (granted, mut measured) = std::thread::scope(|scope| {
        let measuring = scope.spawn(|| {
            let granted = scheduling::apply(&request);
            let none = Latencies::default;
            let latencies = loops.iter().map(|each| lateness(each.period_us, seconds, none()));
            (granted, latencies.collect::<Vec<_>>())
        });
        measuring.join().expect("measuring does not panic")
    });
    let loops = loops.iter().zip(&measured).map(|(each, latencies)| figures(*each, latencies));
    let loops = loops.collect();
    let last = measured.pop().unwrap_or_default();
    let Granted { granted, .. } = granted;
    (WakeUps { seconds, granted, loops, histogram: histogram(&last) }, last)
}

/// Adds the lateness of a loop's wake-ups to these. A late loop owes every instant that it missed.
pub fn lateness(period_us: u32, seconds: f64, mut latencies: Latencies) -> Latencies {
    let period_ns = i64::from(period_us) * 1_000;
    let count = (seconds * 1e9 / period_ns as f64).ceil() as u64;
    let mut due_ns = monotonic_ns() + period_ns;
    for _ in 0..count {
        while monotonic_ns() < due_ns {
            sleep_until(due_ns);
        }
        latencies.record_ns(monotonic_ns() - due_ns);
        due_ns += period_ns;
    }
    latencies
}

pub fn figures(Loop { period_us, budget_us }: Loop, latencies: &Latencies) -> LoopFigures {
    LoopFigures {
        period_us,
        budget_us,
        wakes: latencies.count(),
        late: latencies.count_above_ns(u64::from(budget_us) * 1_000),
        p50_us: latencies.percentiles_us().map_or(0.0, |percentiles| percentiles.p50),
        worst_us: latencies.percentiles_us().map_or(0.0, |percentiles| percentiles.max),
    }
}

fn histogram(latencies: &Latencies) -> Vec<Bin> {
    let above = |us: u32| latencies.count_above_ns(u64::from(us) * 1_000);
    let mut left = latencies.count();
    let mut bins = Vec::with_capacity(BINS_US.len() + 1);
    for up_to_us in BINS_US {
        let beyond = above(up_to_us);
        bins.push(Bin { up_to_us: Some(up_to_us), count: left - beyond });
        left = beyond;
    }
    bins.push(Bin { up_to_us: None, count: left });
    bins
}

impl WakeUps {
    /// The answer to the engineer's question, in a sentence.
    pub fn answer(&self) -> String {
        let loops: Vec<_> = self.loops.iter().map(LoopFigures::answer).collect();
        format!("on this machine, now: {}", loops.join("; "))
    }

    pub fn histogram_table(&self) -> Table {
        let most = self.histogram.iter().map(|bin| bin.count).max().unwrap_or(0).max(1);
        let last = self.histogram.iter().rposition(|bin| bin.count > 0).unwrap_or(0);
        let rows: Vec<Value> = (self.histogram.iter().take(last + 1))
            .map(|bin| {
                let label =
                    bin.up_to_us.map_or_else(|| "later".to_owned(), |us| format!("to {us} µs"));
                let bar = "#".repeat((bin.count * BAR).div_ceil(most) as usize);
                json!({"late": label, "count": bin.count, "bar": bar})
            })
            .collect();
        let columns: [Column<Value>; 3] = [
            word("late", "late", "Lateness"),
            count("count", "wake-ups", "Wake-ups with this lateness"),
            word("bar", "", "The same as a bar"),
        ];
        let heading = format!("Lateness of the last of these loops ({})", self.granted);
        Table::new(&heading, &columns, &rows)
    }

    /// The wake-ups as a finding. The findings after it have the commands that help a loop.
    pub fn finding(&self) -> Finding {
        const CHECK: &str = "wake-ups";
        let worst = self.loops.iter().map(|figures| figures.worst_us).fold(0.0, f64::max);
        let seconds = self.seconds * self.loops.len() as f64;
        let found = format!("the worst was {} late in {seconds} s", duration(worst));
        let late: Vec<_> = self.loops.iter().filter(|figures| !figures.holds()).collect();
        let names: Vec<_> = late.iter().map(|figures| whole(figures.period_us)).collect();
        let costs = format!("a loop of {} misses deadlines", names.join(" or "));
        match late.len() {
            0 => Finding::ok(CHECK, found),
            few if few < self.loops.len() => Finding::warn(CHECK, found, costs, None),
            _ => Finding::bad(CHECK, found, costs, None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    fn wake_ups(late_ns: &[i64]) -> WakeUps {
        let mut latencies = Latencies::default();
        for ns in late_ns {
            latencies.record_ns(*ns);
        }
        let loops = USUAL.map(|each| figures(each, &latencies)).to_vec();
        let histogram = histogram(&latencies);
        WakeUps { seconds: 1.0, granted: "fifo:80".into(), loops, histogram }
    }

    #[test]
    fn a_wake_up_beyond_the_budget_breaks_the_fast_loop_only() {
        let mixed = wake_ups(&[4_000, 7_000, 60_000, 300_000]);
        assert!(mixed.loops[0].holds() && !mixed.loops[1].holds());
        assert!(
            mixed.answer().contains("a 1 ms loop with a budget of 100 µs does not hold (1 of 4")
        );
        assert_eq!(mixed.finding().verdict, Verdict::Warn);
        assert_eq!(wake_ups(&[5_000_000]).finding().verdict, Verdict::Bad);
        assert_eq!(wake_ups(&[4_000]).finding().verdict, Verdict::Ok);
    }

    #[test]
    fn every_wake_up_is_in_one_bin() {
        let measured = wake_ups(&[1_000, 7_000, 7_000, 700_000, 20_000_000]);
        assert_eq!(measured.histogram.iter().map(|bin| bin.count).sum::<u64>(), 5);
        assert_eq!(measured.histogram[1].count, 2);
        assert_eq!(measured.histogram.last().map(|bin| bin.count), Some(1));
        let text = measured.histogram_table().console(80);
        assert_eq!(text.lines().count(), BINS_US.len() + 2, "{text}");
        assert!(text.contains("later"), "{text}");
    }

    #[test]
    fn a_measurement_counts_each_due_instant() {
        let (measured, fastest) = measure(&USUAL, 0.05);
        assert_eq!(measured.loops.iter().map(|l| l.wakes).collect::<Vec<_>>(), [5, 50]);
        assert_eq!(fastest.count(), 50);
        assert!(measured.loops.iter().all(|l| l.worst_us >= 0.0 && l.late <= l.wakes));
        let own = Loop { period_us: 2_000, budget_us: 500 };
        let (measured, _) = measure(&[own], 0.02);
        assert_eq!((measured.loops.len(), measured.loops[0].wakes), (1, 10));
        assert_eq!(measured.loops[0].budget_us, 500);
    }
}
