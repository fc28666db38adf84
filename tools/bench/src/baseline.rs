//! Figures over their floor, by which a benchmark is compared with an earlier one, on this or another machine.
//!
//! The pairs are the rows of both: the same conditions, sizes and periods.

use super::results::Report;
use report::gate::Sample;
use runtime::statistics::Percentiles;

/// Fewest samples for a meaningful 99th percentile.
const ENOUGH: u64 = 1000;
/// Misses above the floor's that may be chance.
const CHANCE: f64 = 5.0;

/// The figures of a report. A growth by less than `factor` is not worse.
pub fn samples(report: &Report, factor: f64) -> Vec<Sample> {
    let over = |of: fn(&Percentiles) -> f64, least: u64| {
        let ratio = move |row: &super::results::TransportRow| {
            let us = row.us.filter(|us| us.count >= least)?;
            Some(of(&us) / of(&report.futex(row.conditions, row.period_us)?))
        };
        report.transport_us.iter().map(ratio).collect::<Vec<_>>()
    };
    let net = report.chain.iter().map(|row| Some(row.net_reaction_us?.p50 / row.floor_sum_us?));
    let excess = report.deadlines.iter().map(|row| {
        let excess = row.misses_per_million? - row.floor_misses_per_million?;
        let by_chance = CHANCE * 1e6 / row.cycles?.max(1) as f64;
        Some(if excess > by_chance { excess } else { 0.0 })
    });
    let sample = |of, figure, values| Sample::growing(of, figure, values, factor);
    vec![
        sample("transport over futex", "p50", over(|us| us.p50, 1)),
        sample("transport over futex", "p99", over(|us| us.p99, ENOUGH)),
        sample("net reaction over its floors", "p50", net.collect()),
        sample("controller", "misses over the floor's, per million", excess.collect()),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::results::{
        DeadlineRow, Floor, FloorMeasure, FloorRow, Passing, TransportRow,
    };
    use super::super::setup::{Conditions, Load, Placement, Scheduling};
    use super::*;
    use report::gate::Baseline;
    use report::summary::Host;

    const CONDITIONS: Conditions = Conditions {
        placement: Placement::TwoCores,
        scheduling: Scheduling::Fifo,
        load: Load::Idle,
    };

    fn flat(us: f64) -> Option<Percentiles> {
        let count = ENOUGH;
        Some(Percentiles { p50: us, p90: us, p99: us, p999: us, p9999: us, max: us, count })
    }

    /// Twelve sizes and periods, each with this transport over this futex.
    fn report(futex_us: f64, transport_us: f64, misses: u64) -> Report {
        let mut floor = Floor::default();
        let (measure, period_us) = (FloorMeasure::Futex, 1000);
        floor
            .add(FloorRow { measure, conditions: CONDITIONS, period_us, us: flat(futex_us) }, 1000);
        let transport = |size: usize| TransportRow {
            conditions: CONDITIONS,
            period_us,
            bytes: 64 * size,
            passing: Passing::Bare,
            copied_bytes: Some(0.0),
            lost: Some(0),
            us: flat(transport_us * (1.0 + 0.01 * size as f64)),
        };
        let deadline = |_| DeadlineRow {
            conditions: CONDITIONS,
            period_us,
            cycles: Some(10_000),
            misses: Some(misses),
            misses_per_million: Some(misses as f64 * 100.0),
            floor_cycles: Some(10_000),
            floor_misses: Some(2),
            floor_misses_per_million: Some(200.0),
        };
        Report {
            schema_version: 1,
            host: Host::this(),
            quick: true,
            seconds: 1.0,
            wake_ups: None,
            refused: Default::default(),
            floor,
            transport_us: (0..12).map(transport).collect(),
            chain: Vec::new(),
            deadlines: (0..12).map(deadline).collect(),
            paired: Vec::new(),
            goals: Vec::new(),
            caveats: Vec::new(),
            samples: Vec::new(),
            against: None,
        }
    }

    fn holds(name: &str, then: Report, now: &Report) -> bool {
        let file = std::env::temp_dir().join(format!("timegap-{name}-{}", std::process::id()));
        let samples = samples(&then, 1.5);
        let then = serde_json::to_string(&Report { samples, ..then }).expect("plain data");
        std::fs::write(&file, then).expect("writable");
        let baseline = Baseline::read(&file, "a result");
        std::fs::remove_file(&file).expect("ours");
        let now = super::samples(now, 1.5);
        baseline.expect("our own").judge(&now).expect("the same rows").holds()
    }

    #[test]
    fn a_slower_machine_is_no_worse_but_a_slower_transport_and_more_misses_are() {
        assert!(holds("slower", report(10.0, 12.0, 2), &report(30.0, 36.0, 2)));
        assert!(holds("little", report(10.0, 12.0, 2), &report(10.0, 15.0, 7)));
        assert!(!holds("transport", report(10.0, 12.0, 2), &report(10.0, 19.0, 2)));
        assert!(!holds("misses", report(10.0, 12.0, 2), &report(10.0, 12.0, 8)));
    }
}
