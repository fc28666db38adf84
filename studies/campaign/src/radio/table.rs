//! All runs added up.

use super::{Kept, SCENARIO};
use report::table::{self, TextTable};
use serde::Serialize;
use std::collections::BTreeMap;

/// Stop line of the last signal, m.
const LAST_LINE_M: f64 = 1_000.0;

/// What came of all runs.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    schema_version: u32,
    /// No run crossed a red light, touched another vehicle or ended before its time.
    pub ok: bool,
    runs: usize,
    outcomes: BTreeMap<String, usize>,
    /// The runs that did, each with the command that repeats it.
    failures: Vec<String>,
    /// Runs in which the vehicle got past all signals: safety is not to come from standing still.
    past_all_signals: usize,
    frames: u64,
    verdicts: BTreeMap<String, u64>,
    /// Time that the controller was without its signals, s, over all runs.
    signals_lost_s: f64,
    driven_s: f64,
}

impl Table {
    /// Adds up.
    pub fn of(runs: &[Kept]) -> Self {
        let (mut outcomes, mut verdicts) = (BTreeMap::new(), BTreeMap::new());
        for run in runs {
            let outcome = report::print::outcome_word(run.outcome).to_lowercase();
            *outcomes.entry(outcome).or_default() += 1;
            for (verdict, count) in &run.verdicts {
                *verdicts.entry(verdict.clone()).or_default() += count;
            }
        }
        let sum = |figure: fn(&Kept) -> f64| runs.iter().map(figure).sum::<f64>();
        let failures = runs.iter().filter(|run| !run.holds()).map(Kept::failure);
        Self {
            schema_version: 1,
            ok: runs.iter().all(Kept::holds),
            runs: runs.len(),
            outcomes,
            failures: failures.collect(),
            past_all_signals: runs.iter().filter(|run| run.reached_m > LAST_LINE_M).count(),
            frames: runs.iter().map(|run| run.frames).sum(),
            verdicts,
            signals_lost_s: sum(|run| run.signals_lost_s),
            driven_s: sum(|run| run.driven_s),
        }
    }

    /// For a terminal.
    pub fn text(&self) -> String {
        let outcomes: Vec<_> = self.outcomes.iter().map(|(o, n)| format!("{n} {o}")).collect();
        let mut text = format!(
            "{} runs of {SCENARIO}: {}; {} got past all signals\n\
             {:.1} h driven, {:.1} % of it without signals\n",
            self.runs,
            outcomes.join(", "),
            self.past_all_signals,
            self.driven_s / 3600.0,
            100.0 * self.signals_lost_s / self.driven_s.max(1.0)
        );
        let mut rows = TextTable::of_figures(["frames", "", "share"]);
        for (verdict, count) in &self.verdicts {
            let share = 100.0 * *count as f64 / self.frames.max(1) as f64;
            rows.row([verdict.replace('_', " "), count.to_string(), format!("{share:.2} %")]);
        }
        text += &rows.text();
        let (mark, failed) = if self.ok { ("ok", 0) } else { ("BROKEN", self.failures.len()) };
        text += &format!(
            "  {mark:<6} runs that crossed a red light or did not end well = 0: {failed}\n"
        );
        for failure in &self.failures {
            text += &format!("  {}\n", failure.replace('\n', "\n  "));
        }
        let word = if self.ok { "all requirements hold" } else { "A REQUIREMENT IS BROKEN" };
        text + "verdict: " + word + "\n"
    }
}

/// One row per run.
pub fn csv(runs: &[Kept]) -> String {
    let columns = ["run", "outcome", "driven_s", "reached_m", "frames", "signals_lost_s", "keys"];
    let rows = runs.iter().map(|run| {
        [
            run.number.to_string(),
            report::print::outcome_word(run.outcome).to_lowercase(),
            run.driven_s.to_string(),
            run.reached_m.to_string(),
            run.frames.to_string(),
            run.signals_lost_s.to_string(),
            super::planned(run.number).keys.join(" "),
        ]
    });
    table::csv(columns, rows)
}
