//! A benchmark as a result: the answer for the user's loops first, then what it was compared with.

use super::goals::{Goal, Verdict};
use super::results::{DeadlineRow, FloorRow, PairedRow, Report, TransportRow};
use super::setup::Conditions;
use super::{WAKE_UPS, results::ChainRow};
use report::chart::{Stroke, Tone};
use report::html::{figure, grid};
use report::output::{HISTOGRAMS, histogram_log};
use report::print::{carries, p99};
use report::results::{Broken, Column, Document, Format, Table, column, count, number, word};
use report::{Distribution, distributions};
use runtime::statistics::{Latencies, Percentiles};
use serde::Serialize;
use serde_json::{Value, json};

/// Figures of a chain that are drawn, the floor last: name in tags, name for readers.
const CHAIN: [(&str, &str); 6] = [
    ("net_reaction", "software overhead"),
    ("radar_publish", "radar publishes"),
    ("radar_transport", "controller wakes"),
    ("controller_compute", "controller computes"),
    ("command_transport", "plant wakes"),
    ("sleep-beside-chain", "floor: a process that only sleeps"),
];
/// Ways to wake that are drawn, the floor last.
const WAYS: [(&str, &str); 5] = [
    ("message", "a message through the services' ports"),
    ("iceoryx2-event", "iceoryx2 event"),
    ("eventfd", "eventfd"),
    ("sleep", "lateness of a sleep"),
    ("futex", "floor: futex"),
];

/// The result for every output. `histograms` are tagged with figure, conditions and period.
pub fn of(report: &Report, histograms: &[(String, Latencies)]) -> Document {
    let count = |verdict| report.goals.iter().filter(|goal| goal.verdict == verdict).count();
    let [met, missed, undecided] = [Verdict::Met, Verdict::Missed, Verdict::Undecided].map(count);
    let caveats = match report.caveats.as_slice() {
        [] => String::new(),
        caveats => format!(" ({})", caveats.join(", ")),
    };
    let fastest = [(WAKE_UPS.to_owned(), "fastest loop")];
    let fastest = drawn(histograms, "Lateness of wake-ups", &fastest);
    let host = &report.host;
    let kind = if host.realtime_kernel { ", real-time kernel" } else { "" };
    let refused = report.refused.iter().map(|why| ("not granted", why.clone()));
    let missed_goals = report.goals.iter().filter(|goal| goal.verdict == Verdict::Missed);
    let broken = missed_goals
        .map(|goal| format!("{}: {}, limit {:.2}", named(goal), interval(goal.ci95), goal.limit))
        .map(|what| Broken::new(what, ""));
    Document::new("bench", "Benchmark", report)
        .about(format!(
            "{} processors, Linux {}{kind}, {} s for each measurement",
            host.cpus, host.kernel, report.seconds
        ))
        .text(report.wake_ups.as_ref().map(|all| all.answer()).unwrap_or_default())
        .figures("Loops on this machine", grid(&fastest.unwrap_or_default()))
        .facts("Not granted", refused)
        .table(goals(&report.goals))
        .table(comparisons(&report.paired))
        .figures("Comparisons in alternating blocks", blocks(&report.paired, histograms))
        .table(floor(&report.floor.rows))
        .figures("Waking", pictures(histograms, "Waking", &WAYS))
        .table(transport(report))
        .table(chains(&report.chain))
        .figures("The chain", pictures(histograms, "Chain", &CHAIN))
        .table(deadlines(&report.deadlines))
        .file(HISTOGRAMS, histogram_log(histograms))
        .verdict(
            missed == 0,
            format!("goals: {met} met, {missed} missed, {undecided} undecided{caveats}"),
        )
        .broken(broken)
}

/// A row with its conditions and its period in words, and the percentiles of `us` that its samples carry.
fn row(
    row: &impl Serialize,
    conditions: &Conditions,
    period_us: u32,
    us: Option<Percentiles>,
) -> Value {
    let mut json = json!(row);
    json["under"] = json!(conditions.in_words());
    json["period"] = json!(f64::from(period_us) / 1e3);
    if let Some(us) = us {
        json["p50"] = json!(carries(us.count, 0.5).then_some(us.p50));
        json["p99"] = json!(p99(&us));
        json["max"] = json!(us.max);
        json["n"] = json!(us.count);
    }
    json
}

/// Columns of conditions, then `own`.
fn under(own: impl IntoIterator<Item = Column<Value>>) -> Vec<Column<Value>> {
    let period = column("period", "period", "ms", Format::Exact, "Period of the loop");
    [word("under", "under", "Scheduling, cores and load"), period].into_iter().chain(own).collect()
}

fn us(name: &'static str, heading: &'static str, meaning: &'static str) -> Column<Value> {
    number(name, heading, "µs", 1, meaning)
}

fn percentiles() -> [Column<Value>; 4] {
    [
        us("p50", "p50", "Median"),
        us("p99", "p99", "99th percentile"),
        us("max", "max", "Largest sample"),
        count("n", "n", "Samples").weight(1),
    ]
}

fn goals(goals: &[Goal]) -> Table {
    let columns: [Column<Value>; 8] = [
        word("of", "goal", "Figure over its floor"),
        number("ours", "ours", "", 1, "Our figure"),
        number("floor", "floor", "", 1, "The floor's figure"),
        word("unit", "unit", "Unit of both"),
        number("ratio", "ratio", "", 2, "Ratio"),
        word("interval", "95 %", "Its interval with 95 % confidence"),
        number("limit", "limit", "", 2, "Largest accepted ratio"),
        column(
            "verdict",
            "verdict",
            "",
            Format::Verdict(verdict),
            "Judgement by the whole interval",
        ),
    ];
    let rows: Vec<Value> = (goals.iter())
        .map(|goal| {
            let mut row = json!(goal);
            row["of"] = json!(named(goal));
            row["interval"] = json!(interval(goal.ci95));
            row
        })
        .collect();
    Table::new("Goals", &columns, &rows)
}

fn named(goal: &Goal) -> String {
    format!("{}, {}", goal.name, goal.placement.name().replace('_', " "))
}

/// An undecided goal needs more samples, and is not a bad one.
fn verdict(word: &str) -> (&'static str, bool) {
    match word {
        "met" => ("met", true),
        "missed" => ("MISSED", false),
        _ => ("undecided", true),
    }
}

fn comparisons(rows: &[PairedRow]) -> Table {
    let p50 = |us: Option<Percentiles>| json!(us.map(|us| us.p50));
    let rows: Vec<Value> = (rows.iter())
        .map(|one| {
            let mut row = row(one, &one.conditions, one.period_us, None);
            row["of"] = json!(one.comparison.label());
            (row["ours"], row["floor"]) = (p50(one.ours_us), p50(one.floor_us));
            row["interval"] = json!(one.ci95.map(|[low, high]| interval([Some(low), Some(high)])));
            row
        })
        .collect();
    let columns: [Column<Value>; 8] = [
        word("of", "compared", "Both sides"),
        word("under", "under", "Scheduling, cores and load").weight(2),
        us("ours", "p50", "Median of ours"),
        us("floor", "over", "Median of the floor"),
        number("ratio", "ratio", "", 2, "Ratio of the medians"),
        word("interval", "95 %", "Its interval with 95 % confidence"),
        count("pairs", "pairs of blocks", "Pairs of blocks").weight(1),
        count("lost", "lost", "Wake-ups that never arrived").weight(1),
    ];
    Table::new("Compared in alternating blocks", &columns, &rows).without_cases()
}

fn floor(rows: &[FloorRow]) -> Table {
    let rows: Vec<Value> =
        rows.iter().map(|one| row(one, &one.conditions, one.period_us, one.us)).collect();
    let measure = word("measure", "floor", "Kind of the floor");
    let columns: Vec<_> = std::iter::once(measure).chain(under(percentiles())).collect();
    Table::new("The machine's floor", &columns, &rows)
}

/// Bytes copied and time for each size.
fn transport(report: &Report) -> Table {
    let rows: Vec<Value> = (report.transport_us.iter())
        .map(|one: &TransportRow| {
            let mut row = row(one, &one.conditions, one.period_us, one.us);
            let futex = report.futex(one.conditions, one.period_us);
            row["over_futex"] = json!(one.us.zip(futex).map(|(us, futex)| us.p50 / futex.p50));
            row
        })
        .collect();
    let own = [
        word("passing", "passing", "Kind of the hand-over"),
        count("bytes", "bytes", "Size of the message"),
        number("copied_bytes", "copied", "B", 0, "Bytes copied for each message").weight(1),
    ];
    let ratio = number("over_futex", "over futex", "", 2, "Ratio of the medians");
    let columns: Vec<_> = own.into_iter().chain(under(percentiles())).chain([ratio]).collect();
    Table::new("Publish, wake, read", &columns, &rows)
}

fn chains(rows: &[ChainRow]) -> Table {
    let rows: Vec<Value> = (rows.iter())
        .map(|one| {
            let mut row = row(one, &one.conditions, one.period_us, one.net_reaction_us);
            let p50 = |us: Option<Percentiles>| json!(us.map(|us| us.p50));
            row["reaction"] = p50(one.reaction_time_us);
            row["waits"] = p50(one.designed_wait_us);
            row
        })
        .collect();
    let own = [
        us("reaction", "reaction", "Median from the radar's measurement to the actuation"),
        us("waits", "waits", "Median of the radar's latency and the waits for the next period"),
        us("p50", "net p50", "Median of the reaction without these waits"),
        us("p99", "net p99", "99th percentile of the reaction without these waits"),
        us("floor_sum_us", "floors", "Sum of the medians of the floors"),
        count("n", "n", "Samples").weight(1),
    ];
    Table::new("Radar to actuation", &under(own), &rows)
}

fn deadlines(rows: &[DeadlineRow]) -> Table {
    let rows: Vec<Value> =
        rows.iter().map(|one| row(one, &one.conditions, one.period_us, None)).collect();
    let own = [
        count("cycles", "cycles", "Cycles of the controller"),
        count("misses", "misses", "Deadlines that it missed"),
        number("misses_per_million", "per million", "", 1, "Misses in a million cycles"),
        count("floor_misses", "floor", "Misses of a process that sleeps and computes as the law"),
        number("floor_misses_per_million", "per million", "", 1, "Its misses in a million cycles"),
    ];
    Table::new("Deadlines", &under(own), &rows)
}

fn interval([low, high]: [Option<f64>; 2]) -> String {
    let end = |value: Option<f64>| value.map_or_else(|| "∞".into(), |end| format!("{end:.2}"));
    format!("{} to {}", end(low), end(high))
}

/// Distributions of every comparison: ours and its floor.
fn blocks(rows: &[PairedRow], histograms: &[(String, Latencies)]) -> String {
    let picture = |row: &PairedRow| {
        let name = row.comparison.name();
        let tag = row.conditions.tag(row.period_us);
        let (ours, floor) = name.split_once(" over ").unwrap_or((name, "floor"));
        let arm = |arm: &str| format!("{}-{arm}:{tag}", name.replace(' ', "-"));
        let title = format!("{name}: {}", row.conditions.in_words().replace('_', " "));
        drawn(histograms, &title, &[(arm("ours"), ours), (arm("floor"), floor)])
    };
    grid(&rows.iter().filter_map(picture).collect::<String>())
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
    let picture = |rest: &&str| {
        let tagged = names.iter().map(|(name, label)| (format!("{name}:{rest}"), *label));
        let title = format!("{title}: {}", rest.replace(':', ", ").replace('_', " "));
        drawn(histograms, &title, &tagged.collect::<Vec<_>>())
    };
    grid(&conditions.iter().filter_map(picture).collect::<String>())
}

/// The histograms of these tags in one picture, the floor last.
pub fn drawn(
    histograms: &[(String, Latencies)],
    title: &str,
    tagged: &[(String, &str)],
) -> Option<String> {
    let drawn = tagged.iter().enumerate().filter_map(|(index, (tag, label))| {
        let (_, latencies) = histograms.iter().find(|(known, _)| known == tag)?;
        let (tone, stroke) = match index + 1 == tagged.len() {
            true => (Tone::Muted, Stroke::Dashed),
            false => (Tone::Series(index), Stroke::Solid),
        };
        let label = format!("{label} (n = {})", latencies.count());
        Some(Distribution { label, tone, stroke, latencies })
    });
    distributions(title, &drawn.collect::<Vec<_>>()).map(|plot| figure(&plot))
}
