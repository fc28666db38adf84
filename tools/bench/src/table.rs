//! A benchmark as text.

use super::baseline::Change;
use super::goals::Verdict;
use super::plan::{Cell, Measure};
use super::results::{FloorMeasure, Passing, Report};
use super::setup::Mechanism;
use crate::in_words;
use report::print;
use report::table::TextTable;
use runtime::statistics::Percentiles;
use std::fmt::Write;

/// Name of a way to wake.
pub fn mechanism(mechanism: Mechanism) -> String {
    match mechanism {
        Mechanism::Futex => "futex".into(),
        Mechanism::Eventfd => "eventfd".into(),
        Mechanism::Iceoryx2Event => "iceoryx2-event".into(),
        Mechanism::Message => "message".into(),
        Mechanism::Detections => "detections".into(),
        Mechanism::Iceoryx2PubSub => "iceoryx2-pub-sub".into(),
        Mechanism::UnixDatagram => "unix-datagram".into(),
        Mechanism::Tcp => "tcp".into(),
        Mechanism::Zenoh => "zenoh".into(),
        Mechanism::CycloneDds => "cyclonedds".into(),
        Mechanism::Payload(bytes) => format!("payload-{bytes}"),
        Mechanism::ProtectedPayload(bytes) => format!("protected-payload-{bytes}"),
    }
}

/// A cell on the progress bar.
pub fn describe(cell: &Cell) -> String {
    let what = match cell.measure {
        Measure::Sleep => "sleep".into(),
        Measure::Wake(way) => mechanism(way),
        Measure::Chain => format!("chain {} ms", cell.period_us / 1000),
    };
    format!("{what}, {}", in_words(&cell.conditions))
}

/// A cell's conditions in the tag of its histogram.
pub fn tag(cell: &Cell) -> String {
    format!("{}:{}us", in_words(&cell.conditions).replace(' ', ":"), cell.period_us)
}

/// The report.
pub fn report(report: &Report) -> String {
    let mut text = format!(
        "{} cores, Linux {}{}, {} s each\n",
        report.host.cpus,
        report.host.kernel,
        if report.host.realtime_kernel { " (real-time)" } else { "" },
        report.seconds
    );
    if let Some(wake_ups) = &report.wake_ups {
        line(&mut text, &wake_ups.answer());
        text.push_str(&wake_ups.histogram_text());
    }
    for refused in &report.refused {
        line(&mut text, &format!("not granted: {refused}"));
    }
    for missing in &report.not_compared {
        line(&mut text, &format!("not compared: {missing}"));
    }
    floor(report, &mut text);
    add(&mut text, &transport(report));
    add(&mut text, &chains(report));
    add(&mut text, &deadlines(report));
    comparisons(report, &mut text);
    if !report.goals.is_empty() {
        add(&mut text, &goals(report));
        verdict(report, &mut text);
    }
    text
}

fn floor(report: &Report, text: &mut String) {
    let mut table = figures("the machine's floor, µs", &["period", "p50", "p99", "max", "n"]);
    for row in &report.floor.rows {
        let name = match row.measure {
            FloorMeasure::Sleep => "sleep",
            FloorMeasure::Futex => "futex",
            FloorMeasure::Eventfd => "eventfd",
            FloorMeasure::Iceoryx2Event => "iceoryx2 event",
        };
        let what = format!("{name}, {}", in_words(&row.conditions));
        let period = format!("{} ms", row.period_us / 1000);
        table.row([what, period].into_iter().chain(percentiles(row.us)));
    }
    add(text, &table);
}

/// Bytes copied and time for each size.
pub fn transport(report: &Report) -> TextTable {
    let columns = ["copied, B", "p50", "p99", "max", "n", "over futex"];
    let mut table = figures("publish, wake, read, µs", &columns);
    for row in &report.transport_us {
        let passing = match row.passing {
            Passing::Message => "message",
            Passing::Bare => "bare",
            Passing::Protected => "protected",
        };
        let what = format!("{passing} {} B, {}", row.bytes, in_words(&row.conditions));
        let copied = row.copied_bytes.map_or_else(|| "-".into(), |bytes| format!("{bytes:.0}"));
        let ratio = row.us.zip(report.futex(row.conditions, row.period_us));
        let ratio = ratio.map_or_else(
            || "-".into(),
            |(us, futex)| {
                let tails = print::p99(&us).zip(print::p99(&futex));
                let tail = tails.map(|(us, futex)| format!(", p99 {:.2}", us / futex));
                format!("{:.2}{}", us.p50 / futex.p50, tail.unwrap_or_default())
            },
        );
        table.row([what, copied].into_iter().chain(percentiles(row.us)).chain([ratio]));
    }
    table
}

/// Reaction times of the chain.
pub fn chains(report: &Report) -> TextTable {
    let columns = ["reaction", "waits", "net p50", "net p99", "floors", "n"];
    let mut table = figures("radar to actuation, µs", &columns);
    for row in &report.chain {
        let what = format!("{} ms, {}", row.period_us / 1000, in_words(&row.conditions));
        let p50 = |p: Option<Percentiles>| number(p.map(|p| p.p50));
        let cells = [
            p50(row.reaction_time_us),
            p50(row.designed_wait_us),
            p50(row.net_reaction_us),
            number(row.net_reaction_us.as_ref().and_then(print::p99)),
            number(row.floor_sum_us),
            row.net_reaction_us.map_or_else(|| "-".into(), |p| p.count.to_string()),
        ];
        table.row(std::iter::once(what).chain(cells));
    }
    table
}

/// Missed deadlines.
pub fn deadlines(report: &Report) -> TextTable {
    let columns = ["cycles", "misses", "per million", "floor", "per million"];
    let mut table = figures(
        "deadlines missed by the controller, and by a process that sleeps and computes for as long as the law",
        &columns,
    );
    for row in &report.deadlines {
        let what = format!("{} ms, {}", row.period_us / 1000, in_words(&row.conditions));
        let count = |count: Option<u64>| count.map_or_else(|| "-".into(), |n| n.to_string());
        let cells = [
            count(row.cycles),
            count(row.misses),
            number(row.misses_per_million),
            count(row.floor_misses),
            number(row.floor_misses_per_million),
        ];
        table.row(std::iter::once(what).chain(cells));
    }
    table
}

fn comparisons(report: &Report, text: &mut String) {
    let columns = ["p50", "over", "ratio", "95 %", "pairs of blocks", "lost"];
    let mut table = figures("compared in alternating blocks, µs", &columns);
    for row in &report.paired {
        let p50 = |us: Option<Percentiles>| number(us.map(|p| p.p50));
        table.row([
            format!("{}, {}", row.comparison.label(), in_words(&row.conditions)),
            p50(row.ours_us),
            p50(row.floor_us),
            ratio(row.ratio),
            row.ci95.map_or_else(|| "-".into(), |[low, high]| interval([Some(low), Some(high)])),
            row.pairs.to_string(),
            row.lost.to_string(),
        ]);
    }
    add(text, &table);
}

/// The goals.
pub fn goals(report: &Report) -> TextTable {
    let columns = ["ours", "floor", "ratio", "95 %", "limit", "n", "verdict"];
    let mut table = figures("goals, as ratios with their 95 % intervals", &columns);
    for goal in &report.goals {
        table.row([
            format!("{}, {}", goal.name, goal.placement.name()),
            format!("{} {}", number(Some(goal.ours)), goal.unit),
            format!("{} {}", number(Some(goal.floor)), goal.unit),
            ratio(goal.ratio),
            interval(goal.ci95),
            format!("{:.2}", goal.limit),
            goal.n.to_string(),
            goal.verdict.name().to_owned(),
        ]);
    }
    table
}

fn verdict(report: &Report, text: &mut String) {
    let count = |verdict| report.goals.iter().filter(|goal| goal.verdict == verdict).count();
    let [met, missed, undecided] = [Verdict::Met, Verdict::Missed, Verdict::Undecided].map(count);
    let caveats = match report.caveats.as_slice() {
        [] => String::new(),
        caveats => format!(" ({})", caveats.join(", ")),
    };
    line(text, &format!("verdict: {met} met, {missed} missed, {undecided} undecided{caveats}"));
}

/// A ratio; infinity if unbounded.
pub fn ratio(value: Option<f64>) -> String {
    value.map_or_else(|| "∞".into(), |value| format!("{value:.2}"))
}

/// An interval from its ends.
pub fn interval([low, high]: [Option<f64>; 2]) -> String {
    format!("{} to {}", ratio(low), ratio(high))
}

/// The comparison with an earlier report: worse figures, and the number of compared ones.
pub fn changes(changes: &[Change], factor: f64) -> String {
    let mut text = String::new();
    let worse: Vec<_> = changes.iter().filter(|change| change.worse).collect();
    let title = format!("{} of {} figures worse by {factor}", worse.len(), changes.len());
    let mut table = figures(&title, &["then", "now"]);
    for change in worse {
        table.row([
            change.what.clone(),
            format!("{:.2}", change.then),
            format!("{:.2}", change.now),
        ]);
    }
    add(&mut text, &table);
    text
}

fn percentiles(us: Option<Percentiles>) -> [String; 4] {
    us.map_or_else(
        || [const { String::new() }; 4].map(|_| "-".into()),
        |us| {
            let p50 = Some(us.p50).filter(|_| print::carries(us.count, 0.5));
            let [p50, p99, max] = [p50, print::p99(&us), Some(us.max)].map(number);
            [p50, p99, max, us.count.to_string()]
        },
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.1}"))
}

/// A table of figures under its title.
fn figures<'a>(title: &'a str, columns: &[&'a str]) -> TextTable {
    TextTable::of_figures(std::iter::once(title).chain(columns.iter().copied()))
}

/// Adds a table after an empty line.
fn add(text: &mut String, table: &TextTable) {
    line(text, "");
    text.push_str(&table.text());
}

fn line(text: &mut String, line: &str) {
    writeln!(text, "{}", line.trim_end()).expect("a string takes all");
}
