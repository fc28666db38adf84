//! The result: all runs added up.

use std::collections::BTreeMap;

use report::print::outcome_word;
use report::results::{
    Column, Document, Format, Kind, Schema, Table, column, count, nested, number, outcome, word,
};
use serde::Serialize;
use serde_json::json;

use super::{Kept, NAME, SCENARIO, planned};
use crate::required;
use report::verdicts::{self, LEAST, Least};

/// Stop line of the last signal, m.
const LAST_LINE_M: f64 = 1_000.0;

/// The sums over all runs.
#[derive(Clone, Debug, Serialize)]
struct Results {
    schema_version: u32,
    ok: bool,
    runs: usize,
    outcomes: BTreeMap<String, usize>,
    failures: Vec<String>,
    past_all_signals: usize,
    frames: u64,
    verdicts: BTreeMap<String, u64>,
    signals_lost_s: f64,
    driven_s: f64,
    margins: Vec<Least>,
}

/// Fields of the JSON.
const FIELDS: &[Column<Results>] = &[
    frame::ok("No run crossed a red light, touched another vehicle or ended early"),
    count("runs", "", "Runs"),
    nested("outcomes", Kind::Object, "Number of runs by their outcome"),
    nested("failures", Kind::List, "Runs that broke a requirement, each with its command"),
    count("past_all_signals", "", "Runs that passed the last stop line"),
    count("frames", "", "Received frames"),
    nested("verdicts", Kind::Object, "Number of frames by the on-board unit's verdict"),
    number("signals_lost_s", "", "s", 1, "Time of the controller without its signals, all runs"),
    number("driven_s", "", "s", 1, "Simulated time of all runs"),
];

/// Columns of `radio.csv`.
const RUNS: &[Column<Kept>] = &[
    count("run", "", "Number of the run").of(|kept| json!(kept.number)),
    outcome("outcome"),
    number("driven_s", "", "s", 2, "Simulated time"),
    number("reached_m", "", "m", 1, "Position at the end"),
    count("frames", "", "Received frames"),
    number("signals_lost_s", "", "s", 2, "Time of the controller without its signals"),
    word("keys", "", "Keys that are set").of(|kept| json!(planned(kept.number).keys.join(" "))),
    word("margins", "", "Margins of the requirements")
        .of(|kept| json!(verdicts::words(&kept.requirements))),
];

/// Columns of the runs that broke a requirement.
const FAILURES: &[Column<Kept>] = &[
    count("number", "run", "Number of the run"),
    outcome("outcome"),
    number("driven_s", "after", "s", 2, "Simulated time"),
    column("repeat", "", "", Format::Command, "Command that repeats the run")
        .of(|kept| json!(kept.repeat())),
];

/// Frames with one verdict.
#[derive(Serialize)]
struct Frames {
    verdict: String,
    count: u64,
    share_percent: f64,
}

/// Columns of the frames.
const FRAMES: &[Column<Frames>] = &[
    word("verdict", "frames", "Verdict of the on-board unit"),
    count("count", "number", "Frames"),
    number("share_percent", "share", "%", 2, "Share of the received frames"),
];

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    Schema::new(NAME, "Drives through signals whose frames are lost, late and falsified")
        .fields(FIELDS)
        .rows("margins", "Least margins of the requirements of the command", LEAST)
}

/// The document of all runs.
pub fn document(runs: &[Kept]) -> Document {
    let results = Results::of(runs);
    let frames = results.verdicts.iter().map(|(verdict, &count)| {
        let share_percent = 100.0 * count as f64 / results.frames.max(1) as f64;
        Frames { verdict: verdict.replace('_', " "), count, share_percent }
    });
    let failed: Vec<Kept> = runs.iter().filter(|run| !run.holds()).cloned().collect();
    let outcomes: Vec<_> = results.outcomes.iter().map(|(o, n)| format!("{n} {o}")).collect();
    let (all, past) = (results.runs, results.past_all_signals);
    let about = format!(
        "{all} runs of {SCENARIO}, lockstep: {}; {past} passed all signals",
        outcomes.join(", ")
    );
    let time = format!(
        "{:.1} h driven, {:.1} % of it without signals",
        results.driven_s / 3600.0,
        100.0 * results.signals_lost_s / results.driven_s.max(1.0)
    );
    let broken = if results.margins.is_empty() { "" } else { ", or broke a requirement" };
    let verdict =
        format!("{} of {all} runs crossed a red light or ended early{broken}", failed.len());
    let document = Document::new(NAME, "Signals by radio", &results)
        .about(about)
        .verdict(results.ok, verdict)
        .text(time)
        .table(Table::new("Frames", FRAMES, &frames.collect::<Vec<_>>()))
        .table(Table::new("Runs that broke a requirement", FAILURES, &failed))
        .file("radio.csv", Table::new("", RUNS, runs).csv());
    required::show(document, &results.margins)
}

impl Results {
    fn of(runs: &[Kept]) -> Self {
        let (mut outcomes, mut verdicts) = (BTreeMap::new(), BTreeMap::new());
        for run in runs {
            *outcomes.entry(outcome_word(run.outcome).to_lowercase()).or_default() += 1;
            for (verdict, count) in &run.verdicts {
                *verdicts.entry(verdict.clone()).or_default() += count;
            }
        }
        let sum = |figure: fn(&Kept) -> f64| runs.iter().map(figure).sum::<f64>();
        Self {
            schema_version: 1,
            ok: runs.iter().all(Kept::holds),
            runs: runs.len(),
            outcomes,
            failures: runs.iter().filter(|run| !run.holds()).map(Kept::failure).collect(),
            past_all_signals: runs.iter().filter(|run| run.reached_m > LAST_LINE_M).count(),
            frames: runs.iter().map(|run| run.frames).sum(),
            verdicts,
            signals_lost_s: sum(|run| run.signals_lost_s),
            driven_s: sum(|run| run.driven_s),
            margins: verdicts::least(
                runs.iter().map(|run| (format!("run {}", run.number), run.requirements.as_slice())),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use group::report::Outcome;

    #[test]
    fn a_red_light_breaks_the_verdict_and_is_a_failed_case_with_its_command() {
        let run = |number, outcome| Kept {
            number,
            outcome,
            driven_s: 31.5,
            reached_m: 1_200.0,
            frames: 4,
            verdicts: [("accepted".to_owned(), 3), ("too_old".to_owned(), 1)].into(),
            signals_lost_s: 3.15,
            law_options: Vec::new(),
            requirements: Vec::new(),
        };
        let runs = [run(1, Outcome::Completed), run(2, Outcome::RedLight)];
        let document = document(&runs);
        assert!(!document.is_ok());
        let text = document.console(80);
        assert!(
            text.contains("1 of 2 runs crossed a red light") && text.contains("10.0 %"),
            "{text}"
        );
        assert!(text.contains("timegap run corridor --mode lockstep --seed 2"), "{text}");
        assert!(document.junit().contains("<failure"), "{}", document.junit());
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }
}
