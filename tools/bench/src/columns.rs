//! The columns of loops and goals, for continuous integration and the schema. Console and page have the other
//! measurements too ([`super::table`], [`super::page`]), and [`super::schema`] describes them all.

use super::goals::Goal;
use super::results::Report;
use doctor::wake_ups::LoopFigures;
use report::results::{Column, Document, Format, Table, column, count, number, word};
use serde_json::json;

/// Columns of the loops.
const LOOPS: &[Column<LoopFigures>] = &[
    count("period_us", "period", "Period, µs"),
    count("budget_us", "budget", "Largest accepted lateness, µs"),
    count("wakes", "wake-ups", "Wake-ups"),
    count("late", "late", "Wake-ups later than the budget"),
    number("worst_us", "worst", "µs", 1, "Largest lateness"),
    word("", "answer", "Whether the loop holds")
        .of(|figures| json!(if figures.holds() { "holds" } else { "does not hold" })),
];

/// Columns of the goals.
pub const GOALS: &[Column<Goal>] = &[
    word("name", "goal", "The two sides and the figure"),
    word("placement", "placement", "Cores of both"),
    number("ours", "ours", "", 1, "Our figure"),
    number("floor", "floor", "", 1, "The floor's figure"),
    word("unit", "unit", "Unit of both"),
    number("ratio", "ratio", "", 2, "Their ratio; null if only ours has an event"),
    number("limit", "limit", "", 2, "Largest accepted ratio"),
    count("n", "samples", "Our samples or cycles"),
    column("verdict", "verdict", "", Format::Verdict(verdict_words), "Judgement"),
];

/// An undecided goal is not a failure.
fn verdict_words(name: &str) -> (&'static str, bool) {
    match name {
        "missed" => ("missed", false),
        "undecided" => ("undecided", true),
        _ => ("met", true),
    }
}

/// The document of a benchmark.
pub fn document(report: &Report) -> Document {
    let missed = report.goals.iter().filter(|goal| goal.verdict == super::Verdict::Missed).count();
    let answer = report.wake_ups.as_ref().map_or_else(String::new, |wake_ups| wake_ups.answer());
    let loops = report.wake_ups.as_ref().map_or(&[][..], |wake_ups| &wake_ups.loops);
    let verdict = format!("{answer}; {missed} of {} goals missed", report.goals.len());
    Document::new("bench", "Benchmark", report)
        .verdict(missed == 0, verdict)
        .table(Table::new("Loops on this machine", LOOPS, loops).without_cases())
        .table(Table::new("Goals", GOALS, &report.goals))
}
