//! A benchmark for people.

use super::baseline::Change;
use super::plan::{Cell, Measure, Mechanism};
use super::results::{FloorMeasure, Passing, Report};
use crate::in_words;
use runtime::statistics::Percentiles;
use std::fmt::Write;

/// What a way to wake is called.
pub fn mechanism(mechanism: Mechanism) -> String {
    match mechanism {
        Mechanism::Futex => "futex".into(),
        Mechanism::Eventfd => "eventfd".into(),
        Mechanism::Iceoryx2Event => "iceoryx2-event".into(),
        Mechanism::Message => "message".into(),
        Mechanism::Payload(bytes) => format!("payload-{bytes}"),
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

/// The whole report.
pub fn report(report: &Report) -> String {
    let mut text = format!(
        "{} cores, Linux {}{}, {} s each\n",
        report.host.cpus,
        report.host.kernel,
        if report.host.realtime_kernel { " (real-time)" } else { "" },
        report.seconds
    );
    for refused in &report.refused {
        line(&mut text, &format!("not granted: {refused}"));
    }
    floor(report, &mut text);
    transport(report, &mut text);
    chains(report, &mut text);
    deadlines(report, &mut text);
    goals(report, &mut text);
    text
}

fn floor(report: &Report, text: &mut String) {
    heading(text, "the machine's floor, µs", &["period", "p50", "p99", "max", "n"]);
    for row in &report.floor.rows {
        let name = match row.measure {
            FloorMeasure::Sleep => "sleep",
            FloorMeasure::Futex => "futex",
            FloorMeasure::Eventfd => "eventfd",
            FloorMeasure::Iceoryx2Event => "iceoryx2 event",
        };
        let what = format!("{name}, {}", in_words(&row.conditions));
        let period = format!("{} ms", row.period_us / 1000);
        row_of(text, &what, &[&[period], &percentiles(row.us)[..]].concat());
    }
}

fn transport(report: &Report, text: &mut String) {
    heading(text, "publish, wake, read, µs", &["p50", "p99", "max", "n", "over futex"]);
    for row in &report.transport_us {
        let passing = match row.passing {
            Passing::Copied => "message",
            Passing::Loaned => "loaned",
        };
        let what = format!("{passing} {} B, {}", row.bytes, in_words(&row.conditions));
        let ratio = row.us.zip(report.futex(row.conditions, row.period_us));
        let ratio = ratio.map_or_else(
            || "-".into(),
            |(us, futex)| format!("{:.2}, p99 {:.2}", us.p50 / futex.p50, us.p99 / futex.p99),
        );
        row_of(text, &what, &[&percentiles(row.us)[..], &[ratio]].concat());
    }
}

fn chains(report: &Report, text: &mut String) {
    let columns = ["reaction", "waits", "net p50", "net p99", "floors", "n"];
    heading(text, "radar to actuation, µs", &columns);
    for row in &report.chain {
        let what = format!("{} ms, {}", row.period_us / 1000, in_words(&row.conditions));
        let p50 = |p: Option<Percentiles>| number(p.map(|p| p.p50));
        let cells = [
            p50(row.reaction_time_us),
            p50(row.designed_wait_us),
            p50(row.net_reaction_us),
            number(row.net_reaction_us.map(|p| p.p99)),
            number(row.floor_sum_us),
            row.net_reaction_us.map_or_else(|| "-".into(), |p| p.count.to_string()),
        ];
        row_of(text, &what, &cells);
    }
}

fn deadlines(report: &Report, text: &mut String) {
    let columns = ["cycles", "misses", "per million", "floor", "per million"];
    heading(text, "deadlines missed by the controller, and by a mere sleeper", &columns);
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
        row_of(text, &what, &cells);
    }
}

fn goals(report: &Report, text: &mut String) {
    if report.goals.is_empty() {
        return;
    }
    heading(text, "goals, as factors of the floor", &["ours", "floor", "factor", "limit", ""]);
    for goal in &report.goals {
        let what = format!("{}, {}", goal.goal, goal.placement.name());
        let factor = (goal.floor > 0.0).then(|| goal.ours / goal.floor);
        let cells = [
            number(Some(goal.ours)),
            number(Some(goal.floor)),
            factor.map_or_else(|| "-".into(), |factor| format!("{factor:.2}")),
            number(Some(goal.limit)),
            if goal.ok { "met" } else { "missed" }.into(),
        ];
        row_of(text, &what, &cells);
    }
}

/// The comparison with an earlier report: what is worse, and how much was compared.
pub fn changes(changes: &[Change], factor: f64) -> String {
    let mut text = String::new();
    let worse: Vec<_> = changes.iter().filter(|change| change.worse).collect();
    let title = format!("{} of {} figures worse by {factor}", worse.len(), changes.len());
    heading(&mut text, &title, &["then", "now"]);
    for change in worse {
        let cells = [format!("{:.2}", change.then), format!("{:.2}", change.now)];
        row_of(&mut text, &change.what, &cells);
    }
    text
}

fn percentiles(us: Option<Percentiles>) -> [String; 4] {
    us.map_or_else(
        || [const { String::new() }; 4].map(|_| "-".into()),
        |us| {
            let [p50, p99, max] = [us.p50, us.p99, us.max].map(|us| number(Some(us)));
            [p50, p99, max, us.count.to_string()]
        },
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.1}"))
}

const NAME_WIDTH: usize = 66;

fn heading(text: &mut String, title: &str, columns: &[&str]) {
    line(text, "");
    let columns: String = columns.iter().map(|column| format!(" {column:>11}")).collect();
    line(text, &format!("{title:<NAME_WIDTH$}{columns}"));
}

fn row_of(text: &mut String, name: &str, cells: &[String]) {
    let cells: String = cells.iter().map(|cell| format!(" {cell:>11}")).collect();
    let width = NAME_WIDTH - 2;
    line(text, &format!("  {name:<width$}{cells}"));
}

fn line(text: &mut String, line: &str) {
    writeln!(text, "{}", line.trim_end()).expect("a string takes all");
}
