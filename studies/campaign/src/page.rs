//! The page of a campaign: what was required and found, how long detection and recovery took, and
//! the runs to blame.

use super::exposure_table;
use super::print::found_text;
use super::record::Record;
use super::tally::Tally;
use super::verdict::{Requirement, Verdict};
use report::chart::{Stroke, Tone, number};
use report::html::{Cell, Column, Tile, document, figure, section, table, tiles};
use report::{Distribution, distributions};
use runtime::statistics::Latencies;

/// Most failures that the page has; `campaign.json` has all.
const MAX_FAILURES: usize = 100;

/// How long things took in all runs, µs.
#[derive(Clone, Debug, Default)]
pub struct Times {
    detection: Vec<f64>,
    recovery: Vec<f64>,
}

impl Times {
    /// Adds those of a run.
    pub fn add(&mut self, record: &Record) {
        self.detection.extend(&record.detection_us);
        self.recovery.extend(&record.recovery_us);
    }
}

/// The page.
pub fn page(verdict: &Verdict, times: &Times) -> String {
    let met = verdict.requirements.iter().filter(|requirement| requirement.ok).count();
    let words = format!(
        "{} of {} runs done; {met} of {} requirements hold",
        verdict.all.runs,
        verdict.planned,
        verdict.requirements.len()
    );
    let body = [
        tiles(&figures(&verdict.all)),
        section("Requirements", &requirements(&verdict.requirements)),
        section("Detection and recovery", &pictures(times)),
        section("Runs", &combinations(verdict)),
        exposure_table::section(&verdict.exposure),
        failures(verdict),
    ]
    .concat();
    let title = format!("Campaign {}", verdict.campaign);
    document(&title, verdict.mode.name(), verdict.ok, &words, &body)
}

fn figures(all: &Tally) -> Vec<Tile> {
    let count = |label, count: u64| Tile { label, value: count.to_string(), note: String::new() };
    let mut tiles = vec![
        count("Runs", all.runs),
        Tile {
            label: "Faults in critical phases",
            value: all.critical_faults.to_string(),
            note: format!("of {}", all.faults_struck),
        },
        count("Processes killed", all.kills),
        count("Collisions", all.collisions),
        count("Emergency brakings", all.interventions),
        count("Red lights", all.red_lights),
        count("Safe stops", all.safe_stops),
        count("Driven by the backup", all.driven_by_backup),
        count("Aborted", all.aborted),
        count("Objects left behind", all.leaks),
    ];
    let least =
        [("Smallest gap", all.min_gap_m, "m"), ("Smallest time to collision", all.min_ttc_s, "s")];
    tiles.extend(least.into_iter().filter_map(|(label, value, unit)| {
        let value = format!("{} {unit}", number(value?.max(0.0), 1));
        Some(Tile { label, value, note: String::new() })
    }));
    tiles
}

fn requirements(all: &[Requirement]) -> String {
    let rows: Vec<_> = (all.iter())
        .map(|requirement| {
            let found = requirement.found.map_or_else(|| "nothing".into(), found_text);
            vec![
                Cell::Plain(requirement.requirement.clone()),
                Cell::Plain(requirement.limit.to_string()),
                Cell::Plain(found),
                if requirement.ok {
                    Cell::Good("holds".into())
                } else {
                    Cell::Bad("BROKEN".into())
                },
            ]
        })
        .collect();
    let head = [
        ("requirement", Column::Text),
        ("limit", Column::Number),
        ("found", Column::Number),
        ("", Column::Text),
    ];
    table(&head, &rows)
}

fn pictures(times: &Times) -> String {
    let latencies = |times_us: &[f64]| {
        let mut latencies = Latencies::default();
        times_us.iter().for_each(|us| latencies.record_ns((us * 1e3) as i64));
        latencies
    };
    let (detection, recovery) = (latencies(&times.detection), latencies(&times.recovery));
    let drawn = [
        ("detected by the supervisor", &detection),
        ("first message of the restarted process", &recovery),
    ];
    // In lockstep all of them are zero.
    let drawn = drawn.into_iter().filter(|(_, l)| l.percentiles_us().is_some_and(|p| p.max > 1.0));
    let drawn: Vec<_> = drawn
        .enumerate()
        .map(|(index, (label, latencies))| Distribution {
            label: format!("{label} (n = {})", latencies.count()),
            tone: Tone::Series(index),
            stroke: Stroke::Solid,
            latencies,
        })
        .collect();
    match distributions("Time after a process fault", &drawn) {
        Some(plot) => format!("<div class=\"grid\">\n{}</div>\n", figure(&plot)),
        None => "<p class=\"quiet\">No process fault was timed.</p>\n".to_owned(),
    }
}

fn combinations(verdict: &Verdict) -> String {
    let rows: Vec<_> = (verdict.combinations.iter())
        .map(|combination| {
            let tally = &combination.tally;
            let figure = |value: Option<f64>| value.map_or_else(|| "–".into(), |v| number(v, 1));
            let ms = |us: Option<f64>| figure(us.map(|us| us / 1e3));
            vec![
                combination.scenario.clone(),
                combination.controller.clone(),
                combination.fault.clone(),
                tally.runs.to_string(),
                tally.completed.to_string(),
                tally.safe_stops.to_string(),
                tally.collisions.to_string(),
                tally.interventions.to_string(),
                tally.red_lights.to_string(),
                tally.driven_by_backup.to_string(),
                tally.aborted.to_string(),
                figure(tally.min_gap_m),
                figure(tally.min_ttc_s),
                ms(tally.recovery_us.map(|p| p.p50)),
                ms(tally.recovery_us.map(|p| p.max)),
            ]
        })
        .collect();
    let head = [
        ("scenario", Column::Text),
        ("controller", Column::Text),
        ("fault", Column::Text),
        ("runs", Column::Number),
        ("completed", Column::Number),
        ("safe stops", Column::MoreNumber),
        ("collisions", Column::Number),
        ("emergency brakings", Column::Number),
        ("red lights", Column::Number),
        ("driven by backup", Column::MoreNumber),
        ("aborted", Column::MoreNumber),
        ("min gap, m", Column::MoreNumber),
        ("min TTC, s", Column::MoreNumber),
        ("recovery p50, ms", Column::MoreNumber),
        ("recovery max, ms", Column::MoreNumber),
    ];
    table(&head, &rows)
}

/// The runs that broke a requirement, each with the command that repeats it.
fn failures(verdict: &Verdict) -> String {
    if verdict.failures.is_empty() {
        return String::new();
    }
    let rows: Vec<_> = (verdict.failures.iter().take(MAX_FAILURES))
        .map(|failure| {
            let [run, faults] = [failure.run.to_string(), failure.faults.join(", ")];
            vec![run, failure.scenario.clone(), faults, failure.why.clone(), failure.repeat.clone()]
        })
        .collect();
    let words = ["scenario", "faults", "why", "command that repeats it"];
    let head: Vec<_> = [("run", Column::Number)]
        .into_iter()
        .chain(words.map(|word| (word, Column::Text)))
        .collect();
    section("Failures", &(broken(verdict) + &table(&head, &rows)))
}

/// How many runs broke a requirement, by scenario and fault.
fn broken(verdict: &Verdict) -> String {
    if verdict.broken.is_empty() {
        return String::new();
    }
    let rows: Vec<_> = (verdict.broken.iter())
        .map(|broken| vec![broken.scenario.clone(), broken.fault.clone(), broken.runs.to_string()])
        .collect();
    let head = [("scenario", Column::Text), ("fault", Column::Text), ("runs", Column::Number)];
    table(&head, &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_is_whole_and_a_limit_that_is_just_missed_is_seen_to_be() {
        let requirement = |key: &str, limit, found| Requirement {
            requirement: key.into(),
            limit,
            found: Some(found),
            ok: found <= limit,
        };
        let table = requirements(&[
            requirement("max_collisions", 3.0, 0.0),
            requirement("max_take_over_p50_ms", 1.0, 1.004),
        ]);
        assert!(table.contains(">3<") && table.contains(">0<"), "{table}");
        assert!(table.contains(">1<") && table.contains(">1.004<"), "{table}");
    }
}
