//! The page of a benchmark: goals with their intervals, and each distribution beside the machine's floor under
//! the same conditions.

use super::WAKE_UPS;
use super::goals::{Goal, Verdict};
use super::results::{ChainRow, DeadlineRow, PairedRow, Passing, Report, TransportRow};
use super::table::{interval, ratio};
use crate::in_words;
use report::chart::{Axis, Bands, Mark, Plot, Row, Span, Stroke, Tone, number};
use report::html::{Cell, Column, document, figure, section, table};
use report::print::{self, duration};
use report::{Distribution, distributions};
use runtime::statistics::{Latencies, Percentiles};

/// Drawn figures of a chain, the floor last: name in tags, name for readers.
const CHAIN: [(&str, &str); 6] = [
    ("net_reaction", "software overhead"),
    ("radar_publish", "radar publishes"),
    ("radar_transport", "controller wakes"),
    ("controller_compute", "controller computes"),
    ("command_transport", "plant wakes"),
    ("sleep-beside-chain", "floor: a process that only sleeps"),
];
/// Drawn ways to wake, the floor last.
const WAYS: [(&str, &str); 5] = [
    ("message", "a message through the services' ports"),
    ("iceoryx2-event", "iceoryx2 event"),
    ("eventfd", "eventfd"),
    ("sleep", "lateness of a sleep"),
    ("futex", "floor: futex"),
];

/// The page. `histograms` are tagged with figure, conditions and period.
pub fn page(report: &Report, histograms: &[(String, Latencies)]) -> String {
    let count = |verdict| report.goals.iter().filter(|goal| goal.verdict == verdict).count();
    let [met, missed, undecided] = [Verdict::Met, Verdict::Missed, Verdict::Undecided].map(count);
    let caveats = match report.caveats.as_slice() {
        [] => String::new(),
        caveats => format!(", {}", caveats.join(", ")),
    };
    let verdict = format!("Goals: {met} met, {missed} missed, {undecided} undecided{caveats}");
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
    let not_compared: String = (report.not_compared.iter())
        .map(|missing| format!("<p>not compared: {}</p>\n", report::chart::escape(missing)))
        .collect();
    let body = [
        section("Loops on this machine", &wake_ups(report, histograms)),
        refused,
        not_compared,
        section("Goals", &(goals(report) + &gap() + &intervals(report))),
        section(
            "Comparisons in alternating blocks",
            &(peers(report) + &comparisons(report, histograms)),
        ),
        section("Waking", &pictures(histograms, "Waking", &WAYS)),
        section("Publish, wake, read", &hand_overs(&report.transport_us)),
        section(
            "The chain",
            &(chains(&report.chain) + &gap() + &pictures(histograms, "Chain", &CHAIN)),
        ),
        section("Deadlines", &deadlines(&report.deadlines)),
    ]
    .concat();
    document("Benchmark", &about, missed == 0, &verdict, &body)
}

/// The answer for loops, and the lateness behind it.
fn wake_ups(report: &Report, histograms: &[(String, Latencies)]) -> String {
    let Some(wake_ups) = &report.wake_ups else { return String::new() };
    let answer = format!("<p>{}</p>\n", report::chart::escape(&wake_ups.answer()));
    let advice = "<p class=\"quiet\"><code>timegap doctor</code> says what to change.</p>\n";
    let known = histograms.iter().find(|(tag, _)| tag == WAKE_UPS);
    let drawn = known.and_then(|(_, latencies)| {
        let label = format!("1 ms loop (n = {})", latencies.count());
        let (tone, stroke) = (Tone::Series(0), Stroke::Solid);
        distributions("Lateness of wake-ups", &[Distribution { label, tone, stroke, latencies }])
    });
    let drawn = drawn.map_or_else(String::new, |plot| figure(&plot));
    format!("{answer}{advice}<div class=\"grid\">\n{drawn}</div>\n")
}

fn gap() -> String {
    "<div class=\"gap\"></div>\n".to_owned()
}

fn goals(report: &Report) -> String {
    let rows: Vec<_> = (report.goals.iter())
        .map(|goal| {
            let verdict = goal.verdict.name().to_owned();
            vec![
                Cell::Plain(goal.name.clone()),
                Cell::Plain(goal.placement.name().replace('_', " ")),
                Cell::Plain(format!("{} {}", number(goal.ours, 1), goal.unit)),
                Cell::Plain(format!("{} {}", number(goal.floor, 1), goal.unit)),
                Cell::Plain(ratio(goal.ratio)),
                Cell::Plain(interval(goal.ci95)),
                Cell::Plain(number(goal.limit, 2)),
                Cell::Plain(goal.n.to_string()),
                match goal.verdict {
                    Verdict::Met => Cell::Good(verdict),
                    Verdict::Missed => Cell::Bad(verdict),
                    Verdict::Undecided => Cell::Plain(verdict),
                },
            ]
        })
        .collect();
    let head = [
        ("goal", Column::Text),
        ("placement", Column::MoreText),
        ("ours", Column::MoreNumber),
        ("floor", Column::MoreNumber),
        ("ratio", Column::Number),
        ("95 % interval", Column::Number),
        ("limit", Column::Number),
        ("samples", Column::MoreNumber),
        ("verdict", Column::Text),
    ];
    table(&head, &rows)
}

/// Least end of the intervals' axis, and its largest, as a ratio over the limit.
const WIDEST: f64 = 2.0;
const WIDEST_OF_ALL: f64 = 5.0;

/// The intervals as bars over their limits: a bar left of 1 is met, a bar right of 1 is missed.
fn intervals(report: &Report) -> String {
    if report.goals.is_empty() {
        return String::new();
    }
    let ends = report.goals.iter().filter_map(|goal| Some((goal.ci95[1]? / goal.limit).ceil()));
    let widest = ends.fold(WIDEST, f64::max).min(WIDEST_OF_ALL);
    let row = |goal: &Goal| {
        let place = |end: Option<f64>| end.map_or(widest, |end| (end / goal.limit).min(widest));
        let [low, high] = goal.ci95;
        let tone = match goal.verdict {
            Verdict::Met => Tone::Go,
            Verdict::Missed => Tone::Stop,
            Verdict::Undecided => Tone::Clear,
        };
        let (from, to) = (place(low), place(high));
        let placement = goal.placement.name().replace('_', " ");
        let interval = interval(goal.ci95);
        Row {
            name: format!("{}, {placement}: {interval}, limit {:.2}", goal.name, goal.limit),
            spans: vec![Span { from, to, label: goal.verdict.name().to_owned(), tone }],
        }
    };
    let bands = Bands {
        title: "95 % intervals of the ratios over their limits: met left of 1, missed right of it"
            .into(),
        x: Axis::linear("ratio over its limit", 0.0, widest),
        rows: report.goals.iter().map(row).collect(),
        marks: vec![Mark::numbered(1.0, 1)],
    };
    format!("<div class=\"grid\">\n{}</div>\n", figure(&bands))
}

/// Intervals of the alternatives over a message through the services' ports.
fn peers(report: &Report) -> String {
    let peers = report.paired.iter().filter(|row| row.comparison.is_peer());
    let peers: Vec<_> = peers.filter_map(|row| Some((row, row.ci95?))).collect();
    let widest = peers.iter().map(|(_, [_, high])| high.ceil()).fold(WIDEST, f64::max);
    let row = |(row, [low, high]): &(&PairedRow, [f64; 2])| {
        let name = row.comparison.name().split(" over ").next().unwrap_or_default();
        let conditions = in_words(&row.conditions).replace('_', " ");
        let interval = interval([Some(*low), Some(*high)]);
        let (label, tone) = match () {
            () if *low > 1.0 => ("slower than ours", Tone::Go),
            () if *high < 1.0 => ("faster than ours", Tone::Stop),
            () => ("no difference", Tone::Clear),
        };
        Row {
            name: format!("{name}, {conditions}: {interval}"),
            spans: vec![Span { from: *low, to: *high, label: label.into(), tone }],
        }
    };
    if peers.is_empty() {
        return String::new();
    }
    let bands = Bands {
        title: "p50 over a message through the services' ports, 95 % intervals".into(),
        x: Axis::linear("ratio", 0.0, widest),
        rows: peers.iter().map(row).collect(),
        marks: vec![Mark::numbered(1.0, 1)],
    };
    format!("<div class=\"grid\">\n{}</div>\n", figure(&bands))
}

/// Distributions of every comparison: ours and its floor.
fn comparisons(report: &Report, histograms: &[(String, Latencies)]) -> String {
    let picture = |row: &PairedRow| {
        let name = row.comparison.name();
        let tag = format!("{}:{}us", in_words(&row.conditions).replace(' ', ":"), row.period_us);
        let arm = |arm: &str, label: &str, tone, stroke| {
            let known = format!("{}-{arm}:{tag}", name.replace(' ', "-"));
            let (_, latencies) = histograms.iter().find(|(tag, _)| *tag == known)?;
            let label = format!("{label} (n = {})", latencies.count());
            Some(Distribution { label, tone, stroke, latencies })
        };
        let (ours, floor) = name.split_once(" over ").unwrap_or((name, "floor"));
        let drawn = [
            arm("ours", ours, Tone::Series(0), Stroke::Solid),
            arm("floor", floor, Tone::Muted, Stroke::Dashed),
        ];
        let drawn: Vec<_> = drawn.into_iter().flatten().collect();
        let conditions = in_words(&row.conditions).replace('_', " ");
        distributions(&format!("{name}: {conditions}"), &drawn).map(|plot| figure(&plot))
    };
    let drawn: String = report.paired.iter().filter_map(picture).collect();
    format!("<div class=\"grid\">\n{drawn}</div>\n")
}

/// One picture for each set of conditions with a measured figure of `names`.
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
    distributions(&format!("{title}: {}", conditions_in_words(conditions)), &drawn)
}

/// The conditions in a histogram's tag, `fifo:same_core:idle:1000us`.
fn conditions_in_words(tag: &str) -> String {
    let words = tag.replace(':', ", ").replace('_', " ");
    let period = words.rsplit_once(", ").and_then(|(conditions, period)| {
        let us: f64 = period.strip_suffix("us")?.parse().ok()?;
        Some(format!("{conditions}, every {} ms", us / 1e3))
    });
    period.unwrap_or(words)
}

/// A figure of a distribution; a dash where the samples do not carry it.
fn us(p: Option<Percentiles>, of: fn(&Percentiles) -> Option<f64>) -> String {
    p.as_ref().and_then(of).map_or_else(|| "–".to_owned(), duration)
}

/// Bytes copied and time for each size.
fn hand_overs(rows: &[TransportRow]) -> String {
    let cells: Vec<_> = (rows.iter())
        .map(|row| {
            let what = match row.passing {
                Passing::Message => "message of the services",
                Passing::Bare => "bytes that neither end touches",
                Passing::Protected => "written, protected and checked in place",
            };
            vec![
                in_words(&row.conditions).replace('_', " "),
                what.to_owned(),
                row.bytes.to_string(),
                row.copied_bytes.map_or_else(|| "–".into(), |bytes| number(bytes, 0)),
                us(row.us, |p| Some(p.p50)),
                us(row.us, print::p99),
                row.us.map_or_else(|| "–".into(), |p| p.count.to_string()),
            ]
        })
        .collect();
    let head = [
        ("conditions", Column::MoreText),
        ("what", Column::Text),
        ("size, bytes", Column::Number),
        ("copied, bytes", Column::Number),
        ("p50", Column::Number),
        ("p99", Column::MoreNumber),
        ("samples", Column::MoreNumber),
    ];
    table(&head, &cells)
}

fn chains(rows: &[ChainRow]) -> String {
    let cells: Vec<_> = (rows.iter())
        .map(|row| {
            let factor = row.net_reaction_us.zip(row.floor_sum_us);
            vec![
                in_words(&row.conditions).replace('_', " "),
                duration(row.period_us.into()),
                us(row.reaction_time_us, |p| Some(p.p50)),
                us(row.net_reaction_us, |p| Some(p.p50)),
                us(row.net_reaction_us, print::p99),
                us(row.net_reaction_us, |p| Some(p.max)),
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
        ("by a process that sleeps and computes", Column::Number),
        ("of its cycles", Column::MoreNumber),
    ];
    table(&head, &cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_told_with_their_period_in_ms() {
        assert_eq!(
            conditions_in_words("fifo:same_core:idle:500us"),
            "fifo, same core, idle, every 0.5 ms"
        );
        assert_eq!(conditions_in_words("fifo:two_cores"), "fifo, two cores");
    }
}
