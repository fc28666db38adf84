//! The page of a benchmark: goals with their intervals, and each distribution beside the machine's floor under
//! the same conditions.

use super::WAKE_UPS;
use super::goals::{Goal, Verdict};
use super::results::{PairedRow, Report};
use super::table::{self, interval};
use crate::in_words;
use report::chart::{Axis, Bands, Mark, Plot, Row, Span, Stroke, Tone};
use report::html::{document, figure, section, text_table};
use report::{Distribution, distributions};
use runtime::statistics::Latencies;

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
        section("Goals", &(text_table(&table::goals(report)) + &gap() + &intervals(report))),
        section(
            "Comparisons in alternating blocks",
            &(peers(report) + &comparisons(report, histograms)),
        ),
        section("Waking", &pictures(histograms, "Waking", &WAYS)),
        section("Publish, wake, read", &text_table(&table::transport(report))),
        section(
            "The chain",
            &(text_table(&table::chains(report)) + &gap() + &pictures(histograms, "Chain", &CHAIN)),
        ),
        section("Deadlines", &text_table(&table::deadlines(report))),
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

/// Least end of the intervals' axis, and its largest, as a ratio over the limit.
const WIDEST: f64 = 2.0;
const WIDEST_OF_ALL: f64 = 5.0;

/// The intervals as bars over their limits. A bar left of 1 is met, and a bar right of 1 is missed.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_stated_with_their_period_in_ms() {
        assert_eq!(
            conditions_in_words("fifo:same_core:idle:500us"),
            "fifo, same core, idle, every 0.5 ms"
        );
        assert_eq!(conditions_in_words("fifo:two_cores"), "fifo, two cores");
    }
}
