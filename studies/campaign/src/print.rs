//! A verdict as text, and the runs as CSV.

use super::exposure_table;
use super::record::Record;
use super::tally::Tally;
use super::verdict::{Broken, Verdict};
use report::chart::number;
use report::print;
use report::table::{self, NONE, TextTable};
use runtime::statistics::Percentiles;
use std::fmt::Write;

/// Most failures that are shown; `campaign.json` has all.
const SHOWN: usize = 5;
/// Most combinations that are shown one by one.
const MAX_ROWS: usize = 12;

/// The verdict in a table.
pub fn verdict(verdict: &Verdict) -> String {
    let mut text = format!(
        "{} ({}): {} of {} runs, {} kills\n",
        verdict.campaign,
        verdict.mode.name(),
        verdict.all.runs,
        verdict.planned,
        verdict.all.kills
    );
    let mut rows: Vec<(String, &Tally)> = if verdict.combinations.len() > MAX_ROWS {
        let parts = verdict.scenarios.iter().chain(&verdict.controllers).chain(&verdict.faults);
        parts.map(|part| (part.of.clone(), &part.tally)).collect()
    } else {
        let parts = verdict.combinations.iter();
        parts.map(|c| (format!("{} {}, {}", c.scenario, c.controller, c.fault), &c.tally)).collect()
    };
    if rows.len() > 1 {
        rows.push(("all".into(), &verdict.all));
    }
    let mut rows_of_text = TextTable::of_figures([
        "",
        "runs",
        "completed",
        "safe stops",
        "collisions",
        "emergency brakings",
        "red lights",
        "driven by backup",
        "aborted",
        "min gap",
        "min TTC",
        "recovery p50, p99, max",
    ]);
    for (label, tally) in rows {
        let counts = [
            tally.runs,
            tally.completed,
            tally.safe_stops,
            tally.collisions,
            tally.interventions,
            tally.red_lights,
            tally.driven_by_backup,
            tally.aborted,
        ];
        let figure = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| NONE.into(), |value| format!("{} {unit}", number(value, 1)))
        };
        let (gap, ttc) = (figure(tally.min_gap_m, "m"), figure(tally.min_ttc_s, "s"));
        let counts = counts.map(|count| count.to_string());
        rows_of_text.row(std::iter::once(label).chain(counts).chain([
            gap,
            ttc,
            times(tally.recovery_us),
        ]));
    }
    text.push_str(&rows_of_text.text());
    text + &totals(verdict) + &exposure_table::text(&verdict.exposure) + &requirements(verdict)
}

fn times(times: Option<Percentiles>) -> String {
    times.map_or_else(
        || "-".into(),
        |p| {
            let [p50, max] = [p.p50, p.max].map(|us| us / 1e3);
            let p99 = print::p99(&p).map_or_else(|| "-".into(), |us| format!("{:.1}", us / 1e3));
            format!("{p50:.1}, {p99}, {max:.1} ms (n = {})", p.count)
        },
    )
}

/// What has no column.
fn totals(verdict: &Verdict) -> String {
    let all = &verdict.all;
    let mut text = String::new();
    let mut line = |label: &str, value: String| {
        writeln!(text, "  {label:<12} {value}").expect("a string takes all");
    };
    if all.detection_us.is_some() {
        line("detection", times(all.detection_us));
    }
    if all.take_over_us.is_some() {
        line("take-overs", format!("{} by a standby that was ready", times(all.take_over_us)));
    }
    if let Some(overdue) = all.command_overdue_ms {
        line("commands", format!("overdue for at most {overdue:.0} ms"));
    }
    if !all.rungs_s.is_empty() {
        let share = |(rung, time_s): (&String, &f64)| format!("{rung} {time_s:.1} s");
        line("levels", all.rungs_s.iter().map(share).collect::<Vec<_>>().join(", "));
    }
    if all.faults_struck > 0 {
        let phases: Vec<String> =
            all.phases.iter().map(|(phase, count)| format!("{phase} {count}")).collect();
        let (struck, critical) = (all.faults_struck, all.critical_faults);
        let phases = if phases.is_empty() { "none".into() } else { phases.join(", ") };
        line("faults", format!("{struck} struck, {critical} in critical phases: {phases}"));
    }
    if all.kills > 0 {
        let (double, starting) = (all.double_kills, all.starting_kills);
        let (helpers, launchers) = (all.helper_kills, all.launcher_kills);
        line(
            "kills",
            format!(
                "{double} pairs within 5 ms, {starting} of a process that was starting, {helpers} of \
                 recorder, janitor and launcher ({launchers} launchers)"
            ),
        );
    }
    let corrupted = match (all.corrupted, all.undetected_corruptions) {
        (0, _) => String::new(),
        (all, undetected) => format!(", {all} of them corrupted, {undetected} unnoticed"),
    };
    let (lost, disturbed) = (all.messages_lost, all.disturbed);
    line("messages", format!("{lost} lost, {disturbed} disturbed by faults{corrupted}"));
    line("left behind", format!("{} objects or processes", all.leaks));
    if let (Some(memory), Some(descriptors), Some(shared)) =
        (all.all_memory_kib, all.all_descriptors, all.all_shared_memory_kib)
    {
        line(
            "services",
            format!("{memory:.0} KiB, {descriptors:.0} descriptors, {shared:.0} KiB shared memory"),
        );
    }
    if let (Some(memory), Some(descriptors), Some(shared)) =
        (all.memory_growth_kib, all.descriptor_growth, all.shared_memory_growth_kib)
    {
        let of = match all.memory_growth_of.as_str() {
            "" => String::new(),
            name => format!(" ({name})"),
        };
        line(
            "growth",
            format!(
                "at most {memory:.0} KiB{of} and {descriptors:.0} descriptors of a service, \
                 {shared:.0} KiB of shared memory"
            ),
        );
    }
    text
}

/// A count as it is, and of what was measured no more than three decimals.
pub fn found_text(found: f64) -> String {
    let rounded = (found * 1e3).round() / 1e3;
    rounded.to_string()
}

fn requirements(verdict: &Verdict) -> String {
    let mut text = String::new();
    for requirement in &verdict.requirements {
        let found = requirement.found.map_or_else(|| "nothing".into(), found_text);
        let mark = if requirement.ok { "ok" } else { "BROKEN" };
        let (key, limit) = (&requirement.requirement, requirement.limit);
        writeln!(text, "  {mark:<6} {key} = {limit}: {found}").expect("a string takes all");
    }
    if !verdict.broken.is_empty() {
        text.push_str("runs that break a requirement, by scenario and fault\n");
        let mut broken = TextTable::of_figures(["scenario", "fault", "runs"]);
        for Broken { scenario, fault, runs } in verdict.broken.iter().take(MAX_ROWS) {
            broken.row([scenario.clone(), fault.clone(), runs.to_string()]);
        }
        text += &broken.text();
    }
    for failure in verdict.failures.iter().take(SHOWN) {
        let (run, why, repeat) = (failure.run, &failure.why, &failure.repeat);
        writeln!(text, "  run {run}, {}: {why}\n    {repeat}", failure.scenario)
            .expect("a string takes all");
    }
    if verdict.failures.len() > SHOWN {
        let more = verdict.failures.len() - SHOWN;
        writeln!(text, "  and {more} more in campaign.json").expect("a string takes all");
    }
    let missing = verdict.planned as u64 - verdict.all.runs;
    if verdict.met_nothing {
        text.push_str(
            "  BROKEN its faults met nothing: none acted while the ego braked, stood, closed in on a \
             vehicle, came to a red line or was cut in on\n",
        );
    }
    let word = match (verdict.ok, missing) {
        (true, _) => "all requirements hold".into(),
        (false, 0) => "A REQUIREMENT IS BROKEN".into(),
        (false, missing) => format!("INCOMPLETE: {missing} runs are missing"),
    };
    text + "verdict: " + &word + "\n"
}

/// Columns of the runs.
const COLUMNS: [&str; 21] = [
    "run",
    "scenario",
    "controller",
    "fault",
    "seed",
    "outcome",
    "avoidable",
    "duration_s",
    "min_gap_m",
    "min_ttc_s",
    "interventions",
    "kills",
    "max_detection_us",
    "max_recovery_us",
    "unrecovered",
    "messages_lost",
    "disturbed",
    "corrupted",
    "undetected",
    "leaks",
    "parameters",
];

/// The head of the table of runs.
pub fn csv_head() -> Vec<u8> {
    table::csv_row(COLUMNS)
}

/// A run's row of it; a figure that does not apply is empty.
pub fn csv_row(record: &Record) -> Vec<u8> {
    let most = |values: &[f64]| table::field(values.iter().copied().max_by(f64::total_cmp));
    let outcome = serde_json::to_value(record.outcome).expect("plain data");
    table::csv_row([
        record.run.to_string(),
        record.scenario.clone(),
        record.controller.clone(),
        record.fault.clone(),
        record.seed.to_string(),
        outcome.as_str().unwrap_or_default().to_owned(),
        record.avoidable.to_string(),
        record.duration_s.to_string(),
        table::field(record.min_gap_m),
        table::field(record.min_ttc_s),
        record.interventions.to_string(),
        record.kills.to_string(),
        most(&record.detection_us),
        most(&record.recovery_us),
        record.unrecovered.to_string(),
        record.messages_lost.to_string(),
        record.disturbed.to_string(),
        record.corrupted.to_string(),
        record.undetected.to_string(),
        record.leaks.len().to_string(),
        record.parameters.join(" "),
    ])
}
