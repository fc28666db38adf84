//! The page of a benchmark: goals, and every distribution beside the machine's floor under the same
//! conditions.

use super::results::{ChainRow, DeadlineRow, Report};
use crate::in_words;
use report::chart::{Plot, Stroke, Tone, number};
use report::html::{Cell, Column, document, figure, section, table};
use report::print::duration;
use report::{Distribution, distributions};
use runtime::statistics::{Latencies, Percentiles};

/// Figures of a chain that are drawn, with the floor last: name in tags, name for readers.
const CHAIN: [(&str, &str); 6] = [
    ("net_reaction", "reaction time without designed waits"),
    ("radar_publish", "radar publishes"),
    ("radar_transport", "controller wakes"),
    ("controller_compute", "controller computes"),
    ("command_transport", "plant wakes"),
    ("sleep-beside-chain", "floor: a process that only sleeps"),
];
/// Ways to wake that are drawn, with the floor last.
const WAYS: [(&str, &str); 5] = [
    ("message", "a message through the services' ports"),
    ("iceoryx2-event", "iceoryx2 event"),
    ("eventfd", "eventfd"),
    ("sleep", "lateness of a sleep"),
    ("futex", "floor: futex"),
];

/// The page. `histograms` are tagged with figure, conditions and period.
pub fn page(report: &Report, histograms: &[(String, Latencies)]) -> String {
    let held = report.goals.iter().filter(|goal| goal.ok).count();
    let verdict = format!("{held} of {} goals hold", report.goals.len());
    let host = &report.host;
    let kind = if host.realtime_kernel { "real-time kernel" } else { "not a real-time kernel" };
    let about = format!(
        "{} processors, Linux {}, {kind}, {} s for each measurement",
        host.cpus, host.kernel, report.seconds
    );
    let refused: String = (report.refused.iter())
        .map(|refused| {
            format!("<p class=\"bad\">not granted: {}</p>\n", report::chart::escape(refused))
        })
        .collect();
    let body = [
        refused,
        section("Goals", &goals(report)),
        section("Waking", &pictures(histograms, "Waking", &WAYS)),
        section(
            "The chain",
            &(chains(&report.chain) + &gap() + &pictures(histograms, "Chain", &CHAIN)),
        ),
        section("Deadlines", &deadlines(&report.deadlines)),
    ]
    .concat();
    document("Benchmark", &about, held == report.goals.len(), &verdict, &body)
}

fn gap() -> String {
    "<div class=\"gap\"></div>\n".to_owned()
}

fn goals(report: &Report) -> String {
    let rows: Vec<_> = (report.goals.iter())
        .map(|goal| {
            let factor = goal.ours / goal.floor;
            vec![
                Cell::Plain(goal.goal.clone()),
                Cell::Plain(goal.placement.name().replace('_', " ")),
                Cell::Plain(number(goal.ours, 1)),
                Cell::Plain(number(goal.floor, 1)),
                Cell::Plain(if factor.is_finite() { number(factor, 2) } else { "–".into() }),
                Cell::Plain(number(goal.limit, 1)),
                if goal.ok { Cell::Good("holds".into()) } else { Cell::Bad("BROKEN".into()) },
            ]
        })
        .collect();
    let head = [
        ("goal", Column::Text),
        ("placement", Column::MoreText),
        ("ours", Column::MoreNumber),
        ("floor", Column::MoreNumber),
        ("factor", Column::Number),
        ("limit", Column::Number),
        ("", Column::Text),
    ];
    table(&head, &rows)
}

/// One picture for each set of conditions under which a figure of `names` was measured.
fn pictures(histograms: &[(String, Latencies)], title: &str, names: &[(&str, &str)]) -> String {
    let mut conditions: Vec<&str> = Vec::new();
    for (tag, _) in histograms {
        if let Some((name, rest)) = tag.split_once(':')
            && names.iter().any(|(known, _)| *known == name)
            && !conditions.contains(&rest)
        {
            conditions.push(rest);
        }
    }
    let drawn: String = conditions
        .iter()
        .filter_map(|rest| picture(histograms, title, names, rest))
        .map(|plot| figure(&plot))
        .collect();
    format!("<div class=\"grid\">\n{drawn}</div>\n")
}

fn picture(
    histograms: &[(String, Latencies)],
    title: &str,
    names: &[(&str, &str)],
    conditions: &str,
) -> Option<Plot> {
    let find = |name: &str| {
        let tag = format!("{name}:{conditions}");
        histograms.iter().find(|(known, _)| *known == tag).map(|(_, latencies)| latencies)
    };
    let floor = names.len() - 1;
    let drawn: Vec<_> = (names.iter().enumerate())
        .filter_map(|(index, (name, label))| {
            let (tone, stroke) = match index {
                index if index == floor => (Tone::Muted, Stroke::Dashed),
                index => (Tone::Series(index), Stroke::Solid),
            };
            let latencies = find(name)?;
            let label = format!("{label} (n = {})", latencies.count());
            Some(Distribution { label, tone, stroke, latencies })
        })
        .collect();
    let conditions = conditions.replace(':', ", ").replace('_', " ").replace("us", " µs");
    distributions(&format!("{title}: {conditions}"), &drawn)
}

fn chains(rows: &[ChainRow]) -> String {
    let us = |p: Option<Percentiles>, of: fn(&Percentiles) -> f64| {
        p.map_or_else(|| "–".to_owned(), |p| duration(of(&p)))
    };
    let cells: Vec<_> = (rows.iter())
        .map(|row| {
            let factor = row.net_reaction_us.zip(row.floor_sum_us);
            vec![
                in_words(&row.conditions).replace('_', " "),
                duration(row.period_us.into()),
                us(row.reaction_time_us, |p| p.p50),
                us(row.net_reaction_us, |p| p.p50),
                us(row.net_reaction_us, |p| p.p99),
                us(row.net_reaction_us, |p| p.max),
                row.floor_sum_us.map_or_else(|| "–".into(), duration),
                factor.map_or_else(|| "–".into(), |(net, floor)| number(net.p50 / floor, 2)),
                row.net_reaction_us.map_or_else(|| "–".into(), |p| p.count.to_string()),
            ]
        })
        .collect();
    let head = [
        ("conditions", Column::Text),
        ("period", Column::Number),
        ("reaction p50", Column::MoreNumber),
        ("net p50", Column::Number),
        ("net p99", Column::MoreNumber),
        ("net max", Column::MoreNumber),
        ("floors' sum", Column::MoreNumber),
        ("factor", Column::Number),
        ("samples", Column::MoreNumber),
    ];
    table(&head, &cells)
}

fn deadlines(rows: &[DeadlineRow]) -> String {
    let count =
        |value: Option<u64>| value.map_or_else(|| "–".to_owned(), |value| value.to_string());
    let cells: Vec<_> = (rows.iter())
        .map(|row| {
            vec![
                in_words(&row.conditions).replace('_', " "),
                duration(row.period_us.into()),
                count(row.misses),
                count(row.cycles),
                count(row.floor_misses),
                count(row.floor_cycles),
            ]
        })
        .collect();
    let head = [
        ("conditions", Column::Text),
        ("period", Column::Number),
        ("missed", Column::Number),
        ("of cycles", Column::MoreNumber),
        ("by a process that only sleeps", Column::Number),
        ("of its cycles", Column::MoreNumber),
    ];
    table(&head, &cells)
}
