//! Comparison with an earlier benchmark, on this or another machine, by ratios to the floor.

use super::results::{Change, Report, TransportRow};
use runtime::statistics::Percentiles;
use std::path::Path;
use supervise::{Error, UsageError};

/// Fewest samples for a meaningful 99th percentile.
const ENOUGH: u64 = 1000;
/// Misses above the floor's that may be chance.
const CHANCE: f64 = 5.0;

pub fn read(path: &Path) -> Result<Report, Error> {
    let text = std::fs::read_to_string(path).map_err(Error::path("read", path))?;
    let mistake = |reason: serde_json::Error| {
        let place = format!("{}:{}:{}", path.display(), reason.line(), reason.column());
        UsageError::at(place, reason, "a file of `timegap bench --save`")
    };
    Ok(serde_json::from_str(&text).map_err(mistake)?)
}

/// The figures of both reports side by side. A ratio that grew by more than `factor` is worse.
pub fn compare(then: &Report, now: &Report, factor: f64) -> Vec<Change> {
    let mut changes = Vec::new();
    let mut add = |what: String, then: f64, now: f64| {
        changes.push(Change { what, then, now, worse: now > factor * then });
    };
    for row in &now.transport_us {
        let same = |other: &&TransportRow| {
            (other.conditions, other.period_us, other.bytes, other.passing)
                == (row.conditions, row.period_us, row.bytes, row.passing)
        };
        let over = |report: &Report, row: &TransportRow| {
            row.us.zip(report.futex(row.conditions, row.period_us))
        };
        let Some(before) = then.transport_us.iter().find(same) else { continue };
        let (Some(before), Some(after)) = (over(then, before), over(now, row)) else { continue };
        let what = format!("transport of {} B, {}", row.bytes, row.conditions.in_words());
        let ratio = |(us, floor): (Percentiles, Percentiles), of: fn(&Percentiles) -> f64| {
            of(&us) / of(&floor)
        };
        add(format!("{what}, p50"), ratio(before, |p| p.p50), ratio(after, |p| p.p50));
        if before.0.count >= ENOUGH && after.0.count >= ENOUGH {
            add(format!("{what}, p99"), ratio(before, |p| p.p99), ratio(after, |p| p.p99));
        }
    }
    for row in &now.chain {
        let key = (row.conditions, row.period_us);
        let ratio = |report: &Report| {
            let row = report.chain(key.0, key.1)?;
            Some(row.net_reaction_us?.p50 / row.floor_sum_us?)
        };
        if let (Some(before), Some(after)) = (ratio(then), ratio(now)) {
            let what = format!("net reaction at {} ms, {}", key.1 / 1000, key.0.in_words());
            add(format!("{what}, p50"), before, after);
        }
    }
    for row in &now.deadlines {
        let key = (row.conditions, row.period_us);
        let excess = |report: &Report| {
            let row = report.deadlines.iter().find(|r| (r.conditions, r.period_us) == key)?;
            let excess = (row.misses_per_million? - row.floor_misses_per_million?).max(0.0);
            Some((excess, excess * row.cycles? as f64 / 1e6))
        };
        if let (Some((before, _)), Some((after, misses))) = (excess(then), excess(now)) {
            let what =
                format!("misses over the floor's at {} ms, {}", key.1 / 1000, key.0.in_words());
            let worse = after > factor * before && misses > CHANCE;
            changes.push(Change { what, then: before, now: after, worse });
        }
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::super::results::{DeadlineRow, Floor, FloorMeasure, FloorRow, Passing};
    use super::super::setup::{Conditions, Load, Placement, Scheduling};
    use super::*;
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

    fn report(futex_us: f64, transport_us: f64, misses: u64) -> Report {
        let mut floor = Floor::default();
        let futex = FloorRow {
            measure: FloorMeasure::Futex,
            conditions: CONDITIONS,
            period_us: 1000,
            us: flat(futex_us),
        };
        floor.add(futex, 1000);
        Report {
            schema_version: 1,
            host: Host::this(),
            quick: true,
            seconds: 1.0,
            wake_ups: None,
            refused: Default::default(),
            floor,
            transport_us: vec![TransportRow {
                conditions: CONDITIONS,
                period_us: 1000,
                bytes: 64,
                passing: Passing::Bare,
                copied_bytes: Some(0.0),
                lost: Some(0),
                us: flat(transport_us),
            }],
            chain: Vec::new(),
            deadlines: vec![DeadlineRow {
                conditions: CONDITIONS,
                period_us: 1000,
                cycles: Some(10_000),
                misses: Some(misses),
                misses_per_million: Some(misses as f64 * 100.0),
                floor_cycles: Some(10_000),
                floor_misses: Some(2),
                floor_misses_per_million: Some(200.0),
            }],
            paired: Vec::new(),
            goals: Vec::new(),
            caveats: Vec::new(),
            against: None,
        }
    }

    fn worse(then: &Report, now: &Report) -> Vec<bool> {
        compare(then, now, 1.5).iter().map(|change| change.worse).collect()
    }

    #[test]
    fn a_slower_machine_is_no_worse_but_a_slower_transport_is() {
        assert_eq!(worse(&report(10.0, 12.0, 2), &report(30.0, 36.0, 2)), [false; 3]);
        assert_eq!(worse(&report(10.0, 12.0, 2), &report(10.0, 19.0, 2)), [true, true, false]);
    }

    #[test]
    fn few_misses_are_chance_and_many_are_not() {
        assert_eq!(worse(&report(10.0, 12.0, 2), &report(10.0, 12.0, 7)), [false; 3]);
        assert_eq!(worse(&report(10.0, 12.0, 2), &report(10.0, 12.0, 8)), [false, false, true]);
    }

    #[test]
    fn a_report_survives_its_journey_and_nonsense_says_where() {
        let text = serde_json::to_string(&report(10.0, 12.0, 2)).expect("plain data");
        let back: Report = serde_json::from_str(&text).expect("our own");
        assert_eq!(compare(&back, &report(10.0, 12.0, 2), 1.5).len(), 3);
        let path = std::env::temp_dir().join(format!("timegap-base-{}", std::process::id()));
        std::fs::write(&path, "{\n  \"floor\": 3\n}").expect("writable");
        let error = read(&path).expect_err("not a report").to_string();
        std::fs::remove_file(&path).expect("ours");
        assert!(error.contains(":2:") && error.contains("--save"), "{error}");
    }
}
