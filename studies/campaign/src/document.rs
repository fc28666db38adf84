//! A verdict as a document: tables, pictures and sentences.

use super::blame::Failure;
use super::columns::{BROKEN, EXPOSURE, Line, REQUIREMENTS, lines, sums};
use super::measured::LEFT_OUT;
use super::sums::{Sum, Tally};
use super::verdict::Verdict;
use report::chart::{Stroke, Tone, number};
use report::html::{Tile, figure, grid};
use report::results::{Broken, Column, Document, Table, at, word};
use report::{Distribution, distributions};
use runtime::statistics::Latencies;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Display;

/// Largest number of combinations that a terminal shows one by one.
const MAX_LINES: usize = 12;

pub fn document(verdict: &Verdict, runs: &Sum) -> Document {
    let all = &verdict.all;
    let document = Document::new("campaign", &format!("Campaign {}", verdict.campaign), verdict)
        .about(format!(
            "{} ({}): {} of {} runs, {} processes killed",
            verdict.campaign,
            verdict.mode.name(),
            all.counts.runs,
            verdict.planned,
            all.counts.kills
        ))
        .tiles(tiles(all))
        .table(Table::new("Requirements", REQUIREMENTS, &verdict.requirements))
        .figures("Detection and recovery", pictures(runs));
    let broken = verdict.failures.iter().map(|failure| {
        let Failure { run, scenario, faults, why, repeat } = failure;
        Broken::new(format!("run {run}, {scenario}, {}: {why}", faults.join(", ")), repeat)
    });
    runs_of(verdict, document)
        .table(totals(all))
        .text(listed("faults in each phase", &all.phases))
        .text(listed("radio frames by verdict", &all.frames))
        .text(listed("time on each level, s", &rounded(&all.rungs_s)))
        .table(Table::new("Events of the drives without faults", EXPOSURE, &verdict.exposure))
        .table(
            Table::new("Runs to blame, by scenario and fault", BROKEN, &verdict.broken)
                .most_rows(MAX_LINES),
        )
        .verdict(verdict.ok, sentence(verdict))
        .broken(broken)
}

/// The tables of runs: by combination, and where these are many, by scenario, controller and fault alone.
fn runs_of(verdict: &Verdict, document: Document) -> Document {
    let columns = lines();
    let combinations = verdict.combinations.iter().map(|runs| Line {
        by: None,
        of: format!("{} {}, {}", runs.scenario, runs.controller, runs.fault),
        tally: &runs.tally,
    });
    let mut rows: Vec<Line<'_>> = combinations.collect();
    let are_many = rows.len() > MAX_LINES;
    if rows.len() > 1 && !are_many {
        rows.push(Line { by: None, of: "all".into(), tally: &verdict.all });
    }
    let combinations = Table::new("Runs", &columns, &rows);
    if !are_many {
        return document.table(combinations);
    }
    let shared = [
        ("by scenario", &verdict.scenarios),
        ("by controller", &verdict.controllers),
        ("by fault", &verdict.faults),
    ];
    let rows = shared.into_iter().flat_map(|(by, all)| {
        all.iter().map(move |runs| Line { by: Some(by), of: runs.of.clone(), tally: &runs.tally })
    });
    let all = Line { by: Some("all"), of: "all".into(), tally: &verdict.all };
    let rows: Vec<Line<'_>> = rows.chain([all]).collect();
    document.table(Table::new("Runs", &columns, &rows).blocks("by")).table(combinations.for_pages())
}

/// A sum that is not in the tables of runs.
#[derive(Serialize)]
struct Total {
    figure: String,
    found: String,
}

/// The sums over all runs that the tables of runs do not show everywhere, unless they are zero.
fn totals(all: &Tally) -> Table {
    const COLUMNS: &[Column<Total>] = &[word("figure", "all runs", ""), word("found", "found", "")];
    let json = serde_json::to_value(all).expect("plain data");
    let total = |column: Column<()>| {
        let head = column.head;
        let value = at(&json, &head.name)?;
        let is_told = match value {
            Value::Number(number) => number.as_f64() != Some(0.0),
            Value::String(text) => !text.is_empty(),
            _ => false,
        };
        // A narrow terminal leaves out the columns of the largest weight.
        let is_total = head.is_hidden || head.weight == LEFT_OUT;
        (is_total && is_told).then(|| Total { figure: head.title(), found: head.text(value) })
    };
    let rows: Vec<Total> = sums().into_iter().filter_map(total).collect();
    Table::new("Totals", COLUMNS, &rows)
}

/// Figures by their names in one line; empty without any.
fn listed(heading: &str, figures: &BTreeMap<String, impl Display>) -> String {
    if figures.is_empty() {
        return String::new();
    }
    let each: Vec<_> = figures.iter().map(|(name, figure)| format!("{name} {figure}")).collect();
    format!("{heading}: {}", each.join(", "))
}

fn rounded(figures: &BTreeMap<String, f64>) -> BTreeMap<String, String> {
    figures.iter().map(|(name, figure)| (name.clone(), number(*figure, 1))).collect()
}

/// Figures at a glance.
fn tiles(all: &Tally) -> Vec<Tile> {
    let tile = |label, value: String| Tile { label, value, note: String::new() };
    let mut tiles = vec![
        tile("Runs", all.counts.runs.to_string()),
        Tile {
            label: "Faults in critical phases",
            value: all.counts.critical_faults.to_string(),
            note: format!("of {}", all.counts.faults_struck),
        },
        tile("Processes killed", all.counts.kills.to_string()),
        tile("Collisions", all.counts.collisions.to_string()),
        tile("Emergency brakings", all.counts.interventions.to_string()),
        tile("Red lights", all.counts.red_lights.to_string()),
        tile("Safe stops", all.counts.safe_stops.to_string()),
        tile("Driven by the backup", all.counts.driven_by_backup.to_string()),
        tile("Requirements broken", all.counts.requirements_broken.to_string()),
        tile("Aborted", all.counts.aborted.to_string()),
        tile("Objects left behind", all.counts.leaks.to_string()),
    ];
    let least = [
        ("Smallest gap", all.measures.extremes.min_gap_m, "m"),
        ("Smallest time to collision", all.measures.extremes.min_ttc_s, "s"),
    ];
    tiles.extend(least.into_iter().filter_map(|(label, value, unit)| {
        Some(tile(label, format!("{} {unit}", number(value?.max(0.0), 1))))
    }));
    tiles
}

/// Times of detection and recovery; empty if no process fault was timed.
fn pictures(runs: &Sum) -> String {
    let timed = [
        ("detected by the supervisor", &runs.histograms.detection_us),
        ("first message of the restarted process", &runs.histograms.recovery_us),
    ];
    // In lockstep all times are zero.
    let is_timed = |latencies: &&Latencies| latencies.percentiles_us().is_some_and(|p| p.max > 1.0);
    let timed = timed
        .iter()
        .filter_map(|(label, latencies)| Some((label, latencies.as_ref().filter(is_timed)?)));
    let drawn: Vec<_> = timed
        .enumerate()
        .map(|(index, (label, latencies))| Distribution {
            label: format!("{label} (n = {})", latencies.count()),
            tone: Tone::Series(index),
            stroke: Stroke::Solid,
            latencies,
        })
        .collect();
    let plot = distributions("Time after a process fault", &drawn);
    plot.map_or_else(String::new, |plot| grid(&figure(&plot)))
}

fn sentence(verdict: &Verdict) -> String {
    let (runs, planned) = (verdict.all.counts.runs, verdict.planned);
    let mut words = vec![match verdict.unaccounted {
        0 => format!("{runs} runs done"),
        missing => format!("INCOMPLETE: {missing} of {planned} runs are missing"),
    }];
    let broken: Vec<&str> = (verdict.requirements.iter())
        .filter(|requirement| !requirement.ok)
        .map(|requirement| requirement.requirement.as_str())
        .collect();
    words.push(match (broken.is_empty(), verdict.requirements.len()) {
        (true, all) => format!("all {all} requirements hold"),
        (false, all) => {
            format!("BROKEN: {} ({} of {all} requirements)", broken.join(", "), broken.len())
        }
    });
    if verdict.met_nothing {
        words.push(
            "BROKEN: no fault acted while the ego braked, stood, closed in on a vehicle, came \
             to a red line or was cut in on"
                .into(),
        );
    }
    words.join("; ")
}

#[cfg(test)]
mod tests {
    use super::super::verdict::tests::{WHOLE, verdict};
    use super::*;

    fn written(verdict: &Verdict) -> Document {
        document(verdict, &Sum::default())
    }

    #[test]
    fn every_output_is_of_the_same_declaration() {
        let verdict =
            verdict("max_collisions = 0\nmin_gap_m = 8.5\nmax_recovery_max_ms = 3.995", WHOLE);
        let document = written(&verdict);
        let (console, page, junit) = (document.console(80), document.page(), document.junit());
        assert!(
            console.lines().all(|line| line.len() <= 80 || line.contains("timegap run")),
            "{console}"
        );
        for text in [&console, &page, &document.markdown()] {
            for words in ["cacc-a acc-mpc, none", "timegap run", "3.995", "BROKEN"] {
                assert!(text.replace('\\', "").contains(words), "{words}: {text}");
            }
        }
        assert!(
            junit.contains("<testcase name=\"max\\_recovery")
                || junit.contains("max_recovery_max_ms")
        );
        assert!(console.contains("messages lost") && !console.contains("messages corrupted"));
        assert!(!page.contains(">3.0<"), "a count is whole");
    }

    #[test]
    fn the_sentence_names_what_is_broken_and_what_is_missing() {
        let mut whole = verdict("max_collisions = 0", WHOLE);
        assert_eq!(sentence(&whole), "4 runs done; all 1 requirements hold");
        (whole.planned, whole.unaccounted) = (6, 2);
        assert!(sentence(&whole).starts_with("INCOMPLETE: 2 of 6 runs are missing; all 1"));
        let broken = verdict("max_collisions = 0\nmin_gap_m = 8.5", WHOLE);
        assert!(sentence(&broken).contains("BROKEN: min_gap_m (1 of 2 requirements)"));
    }
}
