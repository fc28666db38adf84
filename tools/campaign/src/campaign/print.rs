//! A verdict for people, and the runs as CSV.

use super::record::Record;
use super::tally::Tally;
use super::verdict::Verdict;
use runtime::statistics::Percentiles;
use std::fmt::Write;

/// Most failures that are shown; `campaign.json` has all.
const SHOWN: usize = 5;
/// Most combinations that are shown one by one.
const MAX_ROWS: usize = 12;

/// The verdict in a table.
pub fn table(verdict: &Verdict) -> String {
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
    let width = rows.iter().map(|(label, _)| label.chars().count()).max().unwrap_or(0);
    let mut line = |label: &str, cells: [&str; 9]| {
        let [runs, whole, stops, crashes, reds, aborted, gap, ttc, recovery] = cells;
        writeln!(
            text,
            "  {label:<width$}  {runs:>6} {whole:>6} {stops:>6} {crashes:>6} {reds:>6} \
             {aborted:>7} {gap:>8} {ttc:>8}  {recovery}"
        )
        .expect("a string takes all");
    };
    let head = ["runs", "whole", "stops", "crash", "red", "aborted", "min gap", "min TTC"];
    let [a, b, c, d, e, f, g, h] = head;
    line("", [a, b, c, d, e, f, g, h, "recovery p50, p99, max"]);
    for (label, tally) in rows {
        let counts = [
            tally.runs,
            tally.completed,
            tally.safe_stops,
            tally.collisions,
            tally.red_lights,
            tally.aborted,
        ];
        let [runs, whole, stops, crashes, reds, aborted] = counts.map(|count| count.to_string());
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "-".into(), |value| format!("{value:.1} {unit}"))
        };
        let (gap, ttc) = (number(tally.min_gap_m, "m"), number(tally.min_ttc_s, "s"));
        let recovery = times(tally.recovery_us);
        line(&label, [&runs, &whole, &stops, &crashes, &reds, &aborted, &gap, &ttc, &recovery]);
    }
    text + &totals(verdict) + &requirements(verdict)
}

fn times(times: Option<Percentiles>) -> String {
    times.map_or_else(
        || "-".into(),
        |p| {
            let [p50, p99, max] = [p.p50, p.p99, p.max].map(|us| us / 1e3);
            format!("{p50:.1}, {p99:.1}, {max:.1} ms (n = {})", p.count)
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
    if let Some(overdue) = all.command_overdue_ms {
        line("commands", format!("overdue for at most {overdue:.0} ms"));
    }
    if !all.rungs_s.is_empty() {
        let share = |(rung, time_s): (&String, &f64)| format!("{rung} {time_s:.1} s");
        line("rungs", all.rungs_s.iter().map(share).collect::<Vec<_>>().join(", "));
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
        line(
            "growth",
            format!(
                "at most {memory:.0} KiB and {descriptors:.0} descriptors of a service, \
                 {shared:.0} KiB of shared memory"
            ),
        );
    }
    text
}

fn requirements(verdict: &Verdict) -> String {
    let mut text = String::new();
    for requirement in &verdict.requirements {
        let found = requirement.found.map_or_else(|| "nothing".into(), |found| found.to_string());
        let mark = if requirement.ok { "ok" } else { "BROKEN" };
        let (key, limit) = (&requirement.requirement, requirement.limit);
        writeln!(text, "  {mark:<6} {key} = {limit}: {found}").expect("a string takes all");
    }
    for failure in verdict.failures.iter().take(SHOWN) {
        let (run, why, repeat) = (failure.run, &failure.why, &failure.repeat);
        writeln!(text, "  run {run}: {why}\n    {repeat}").expect("a string takes all");
    }
    if verdict.failures.len() > SHOWN {
        let more = verdict.failures.len() - SHOWN;
        writeln!(text, "  and {more} more in campaign.json").expect("a string takes all");
    }
    let missing = verdict.planned as u64 - verdict.all.runs;
    let word = match (verdict.ok, missing) {
        (true, _) => "all requirements hold".into(),
        (false, 0) => "NOT WHAT IS REQUIRED".into(),
        (false, missing) => format!("NOT WHOLE: {missing} runs are missing"),
    };
    text + "verdict: " + &word + "\n"
}

/// One row per run, in their order; a figure that does not apply is empty.
pub fn csv(records: &[Record]) -> String {
    let mut text = String::from(
        "run,scenario,controller,fault,seed,outcome,avoidable,duration_s,min_gap_m,min_ttc_s,\
         kills,max_detection_us,max_recovery_us,unrecovered,messages_lost,disturbed,corrupted,\
         undetected,leaks\n",
    );
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let most = |values: &[f64]| number(values.iter().copied().max_by(f64::total_cmp));
    let quoted = |word: &str| match word.contains([',', '"']) {
        true => format!("\"{}\"", word.replace('"', "\"\"")),
        false => word.to_owned(),
    };
    let mut sorted: Vec<_> = records.iter().collect();
    sorted.sort_by_key(|record| record.run);
    for record in sorted {
        let outcome = serde_json::to_value(record.outcome).expect("plain data");
        let cells = [
            record.run.to_string(),
            quoted(&record.scenario),
            record.controller.clone(),
            quoted(&record.fault),
            record.seed.to_string(),
            outcome.as_str().unwrap_or_default().to_owned(),
            record.avoidable.to_string(),
            record.duration_s.to_string(),
            number(record.min_gap_m),
            number(record.min_ttc_s),
            record.kills.to_string(),
            most(&record.detection_us),
            most(&record.recovery_us),
            record.unrecovered.to_string(),
            record.messages_lost.to_string(),
            record.disturbed.to_string(),
            record.corrupted.to_string(),
            record.undetected.to_string(),
            record.leaks.len().to_string(),
        ];
        text.push_str(&(cells.join(",") + "\n"));
    }
    text
}
