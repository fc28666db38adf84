//! The result of one run: verdict, figures at a glance, facts, charts, the machine's part.

mod facts;
mod times;

use serde_json::json;

use crate::chart::escape;
use crate::figures::{ALL, Figure, MIN_GAP_M, Values};
use crate::html::{Tile, figure};
use crate::picture::{RunPicture, letter};
use crate::results::{Broken, Column, Document, Format, Table, column, count, word};
use crate::summary::Summary;
use crate::{over_time, print, verdicts};
use scenario::Scenario;
use supervise::report::Outcome;
use supervise::{FaultRecord, RequirementVerdict};

/// Longest scenario that is printed in full, bytes.
const MAX_SCENARIO: usize = 100_000;
/// Most faults that a terminal shows.
const MOST_FAULTS: usize = 8;

/// The result of a run for every output.
pub fn document(scenario: &Scenario, summary: &Summary, run: &RunPicture) -> Document {
    let about = [
        summary.driver(),
        summary.mode.to_owned(),
        format!("seed {}", summary.seed),
        scenario.description.as_str().to_owned(),
    ];
    let about: Vec<_> = about.into_iter().filter(|part| !part.is_empty()).collect();
    let (ok, verdict) = verdict(summary);
    let broken = summary.requirements.iter().filter(|verdict| !verdict.met);
    let broken = broken.map(|verdict| {
        Broken::new(format!("{}: {}", verdict.requirement, print::requirement(verdict)), "")
    });
    let document = Document::new("run", &summary.scenario, summary)
        .json_file("summary.json")
        .about(about.join(" · "))
        .verdict(ok, verdict)
        .broken(broken)
        .tiles(tiles(summary))
        .facts("The run", facts::of(summary))
        .table(requirements(&summary.requirements))
        .table(faults(&summary.faults))
        .figures("The drive", pictures(run))
        .facts("Radar", facts::radar(summary))
        .facts("Radio", facts::radio(summary))
        .facts("Link", facts::link(summary))
        .table(times::table(summary));
    let document = times::pictures(document, summary, run);
    document
        .table(times::messages(summary))
        .table(times::services(summary))
        .figures("Repeat this run", repeat(scenario, summary))
}

/// True for a completed run, and the outcome in a sentence.
fn verdict(summary: &Summary) -> (bool, String) {
    let at = format!("{:.1} s", summary.duration_s);
    let sentence = match summary.outcome {
        Outcome::Completed => {
            let helped = summary.aebs.interventions;
            let helped = helped
                .map_or_else(String::new, |times| format!("; {}", crate::summary::braked(times)));
            format!("{at} driven without a collision or a red light{helped}")
        }
        Outcome::Collision => format!("after {at}"),
        Outcome::RedLight => format!("a stop line was crossed at red after {at}"),
        Outcome::SafeStop => format!("the plant received no valid commands; {at} driven"),
        Outcome::DrivenByBackup => {
            let law = summary.law.as_ref().map(ToString::to_string).unwrap_or_default();
            format!("{law}. These figures say little about the law")
        }
        Outcome::RequirementBroken => {
            let broken = summary.requirements.iter().filter(|verdict| !verdict.met);
            broken.map(|verdict| verdict.requirement.as_str()).collect::<Vec<_>>().join("; ")
        }
        Outcome::NoStory => {
            let acts = summary.perception.as_ref().map_or(&[][..], |it| &it.unstarted_acts);
            let why = facts::unstarted_acts(acts).unwrap_or_default();
            format!("{why} within {at}: the file's story did not happen")
        }
        Outcome::Aborted => {
            let why = summary.aborted_because.as_deref().unwrap_or("ended early");
            format!("{why}, after {at}")
        }
    };
    let sentence = format!("{}: {sentence}", print::outcome_word(summary.outcome));
    (summary.outcome == Outcome::Completed, sentence)
}

/// The figures that apply, with their values in words.
fn shown(summary: &Summary) -> impl Iterator<Item = (&'static Figure, String)> {
    let values = Values::of(summary);
    ALL.iter().zip(values.0).filter_map(|(figure, value)| {
        let value = value?;
        // Touching bodies have no gap.
        let value = if figure.name == MIN_GAP_M.name { value.max(0.0) } else { value };
        Some((figure, figure.text(value)))
    })
}

/// The figures by which laws are compared, at the top of the page.
fn tiles(summary: &Summary) -> Vec<Tile> {
    let compared = shown(summary).filter(|(figure, _)| figure.is_compared());
    compared
        .map(|(figure, value)| Tile { label: figure.heading, value, note: String::new() })
        .collect()
}

/// The requirements with their margins. Their letters stand in the charts.
fn requirements(verdicts: &[RequirementVerdict]) -> Table {
    let rows: Vec<_> = (verdicts.iter().enumerate())
        .map(|(place, verdict)| {
            let mut row = json!(verdict);
            row["mark"] = json!(letter(place).to_string());
            row
        })
        .collect();
    let mark = word("mark", "mark", "Its letter in the charts");
    let columns: Vec<Column<_>> = std::iter::once(mark).chain(verdicts::columns()).collect();
    Table::new("Requirements", &columns, &rows)
}

/// The faults with their effects. Their numbers stand in the charts.
fn faults(records: &[FaultRecord]) -> Table {
    let mut records: Vec<_> = records.iter().collect();
    records.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    let columns = [
        count("no", "no.", "Its number in the charts"),
        column("t_s", "at", "s", Format::Decimals(3), "Run time"),
        word("fault", "fault", "Kind and target"),
        word("result", "result", "Its effect, as far as it is known"),
    ];
    let row = |(place, record): (usize, &&FaultRecord)| {
        let (fault, result) = (print::fault_name(record), print::fault_outcome(record));
        json!({"no": place + 1, "t_s": record.t_s, "fault": fault, "result": result})
    };
    let rows: Vec<_> = records.iter().enumerate().map(row).collect();
    Table::new("Faults", &columns, &rows).most_rows(MOST_FAULTS)
}

/// Charts of the drive.
pub fn pictures(run: &RunPicture) -> String {
    let following =
        [over_time::gap(run), over_time::time_gap(run), over_time::time_to_collision(run)];
    let plots = [over_time::speed(run)].into_iter().chain(following.into_iter().flatten());
    let motion =
        plots.chain([over_time::acceleration(run), over_time::jerk(run), over_time::road(run)]);
    let below = over_time::lateral(run).into_iter().chain(over_time::profile(run));
    let below = below.chain(over_time::powertrain(run));
    let drawn: String = motion.map(|plot| figure(&plot)).collect();
    let modes = over_time::modes(run).map_or_else(String::new, |modes| figure(&modes));
    let below: String = below.map(|plot| figure(&plot)).collect();
    let above = run.plane.as_ref().map_or_else(String::new, |plane| plane.html());
    format!("{above}<div class=\"columns\">\n{drawn}{modes}{below}</div>\n")
}

/// Instructions to repeat the run, with the scenario that took effect.
fn repeat(scenario: &Scenario, summary: &Summary) -> String {
    let toml = scenario.to_toml();
    let whole = if toml.len() <= MAX_SCENARIO {
        format!(
            "<details><summary>The scenario with all options applied</summary>\n<pre>{}</pre>\n</details>\n",
            escape(&toml)
        )
    } else {
        String::new()
    };
    let mode = if summary.mode == "lockstep" { " --mode lockstep" } else { "" };
    format!(
        "<p>In the directory of this page: <code>timegap run scenario.toml{mode}</code></p>\n{whole}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::Mode;
    use std::time::Duration;
    use supervise::ScenarioOptions;

    /// A short drive behind another vehicle, which breaks its requirement.
    fn driven() -> (Summary, Document) {
        let options = ScenarioOptions {
            duration: Some(3.into()),
            require: vec!["gap_m > 1000".to_owned()],
            ..ScenarioOptions::default()
        };
        let scenario = supervise::open("following", &options).expect("built in");
        let outcome = supervise::in_process::run(&scenario).expect("it runs");
        let summary = Summary::new(&scenario, Mode::Lockstep, &outcome, Duration::from_secs(1));
        let picture = RunPicture::of(&scenario, &outcome).judged(&summary.requirements);
        let document = document(&scenario, &summary, &picture);
        (summary, document)
    }

    #[test]
    fn every_output_of_a_run_has_its_figures_its_requirements_and_its_verdict() {
        let (summary, document) = driven();
        let gap = MIN_GAP_M.text(summary.control.figures.min_gap_m.expect("there is a gap"));
        let console = document.console(100);
        for text in [&console, &document.page(), &document.markdown()] {
            assert!(text.contains(&gap) && text.contains("REQUIREMENT BROKEN"), "{text}");
        }
        let last = console.lines().last().expect("there is text");
        assert!(last.starts_with("  gap_m > 1000: BROKEN, margin −"), "{console}");
        assert!(document.junit().contains("failures=\"2\""), "{}", document.junit());
        assert_eq!(document.value()["outcome"], "requirement_broken");
        assert!(console.lines().count() < 50, "{console}");
    }
}
