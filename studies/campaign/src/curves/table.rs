//! The result: all drives added up, and the limits.

use group::LawOptions;
use report::results::{
    Column, Document, Format, Kind, Schema, Table, column, count, fact, flag, nested, number,
    outcome, word,
};
use serde::Serialize;
use serde_json::json;

use super::event_rows;
use super::figures::{self, Figures, Often, PlaceFigures};
use super::judge::Kept;
use super::limits;
use super::scene::{LAW, Scene};
use super::sources::{self, JUDGED};
use super::{NAME, queue::Queue};
use crate::required;
use report::verdicts::{self, LEAST, Least};

/// Most scenario files of drives with a finding or an event.
const MOST_FILES: usize = 50;

/// The sums over all drives. The figures at the top are those of the judged sources.
#[derive(Clone, Debug, Serialize)]
struct Results {
    schema_version: u32,
    ok: bool,
    km: f64,
    lead_lost: Often,
    neighbour_taken: Often,
    phantom_interventions: u64,
    collisions: usize,
    sources: Vec<Figures>,
    places: Vec<PlaceFigures>,
    limits: Vec<Limit>,
    /// The law of the user's own that drove; null: the study's.
    law: Option<String>,
    failures: Vec<String>,
    margins: Vec<Least>,
}

/// A figure with its limit.
#[derive(Clone, Debug, Serialize)]
struct Limit {
    name: &'static str,
    value: f64,
    limit: f64,
    met: bool,
}

/// Fields of the JSON.
const FIELDS: &[Column<Results>] = &[
    frame::ok(
        "All limits are met with yaw rate, standing objects and trails, and every such run ended well",
    ),
    number("km", "", "km", 1, "Way on the random roads with these sources"),
    number(
        "lead_lost.share",
        "",
        "",
        4,
        "Share of the time with a lead within 100 m in which the target is not the lead",
    ),
    number("lead_lost.per_km", "", "", 4, "Number of times per km that the lead was lost"),
    number(
        "neighbour_taken.share",
        "",
        "",
        4,
        "Share of the time in which the target is a vehicle beside the lane",
    ),
    number(
        "neighbour_taken.per_km",
        "",
        "",
        4,
        "Number of times per km that such a vehicle became the target",
    ),
    count(
        "phantom_interventions",
        "",
        "Interventions of the emergency brake on random roads and beside queues",
    ),
    count("collisions", "", "Collisions of all scenes"),
    word("law", "", "Law of the user's own that drove; null: `acc-mpc`"),
    nested(
        "failures",
        Kind::List,
        "Drives with these sources that have a finding, with the command",
    ),
];

/// Columns of the limits.
const LIMITS: &[Column<Limit>] = &[
    word("name", "figure", "Figure with yaw rate, standing objects and trails"),
    number("value", "seen", "", 4, "Its value"),
    number("limit", "at most", "", 4, "Its limit"),
    flag("met", "verdict", ("met", "EXCEEDED"), "The value is within its limit"),
];

/// Columns of `curves.csv`.
fn drives() -> Vec<Column<Kept>> {
    vec![
        count("number", "", "Number of the scene"),
        word("scene", "", "Kind of the scene"),
        word("sources", "", "Sources of the course"),
        fact("is_entry", "", "A queue stands at the start of the curve")
            .of(|run| json!(run.scene != Scene::Road && Queue::is_entry(run.number as u64))),
        outcome("outcome"),
        number("km", "", "km", 3, "Way").of(|run| json!(run.sums().km)),
        number("lead_s", "", "s", 2, "Time with a lead within 100 m")
            .of(|run| json!(run.sums().lead_s)),
        number("lost_s", "", "s", 2, "Time of these in which it was lost")
            .of(|run| json!(run.sums().lost_s)),
        count("losses", "", "Number of losses").of(|run| json!(run.sums().losses)),
        number("taken_s", "", "s", 2, "Time with a neighbour as the target")
            .of(|run| json!(run.sums().taken_s)),
        count("takings", "", "Number of such times").of(|run| json!(run.sums().takings)),
        number("nothing_s", "", "s", 2, "Time with a target that is not a vehicle")
            .of(|run| json!(run.sums().nothing_s)),
        count("interventions", "", "Interventions of the emergency brake"),
        number("lowest_request_mps2", "", "m/s²", 2, "Lowest request of the law"),
        number("sight_gap_m", "", "m", 1, "Gap at which the queue came into sight")
            .of(|run| json!(run.sight.map(|sight| sight.gap_m))),
        number("seen_after_s", "", "s", 2, "Time from sight to the target")
            .of(|run| json!(run.sight.and_then(|sight| sight.seen_after_s))),
        number("largest_lateral_mps2", "", "m/s²", 2, "Largest lateral acceleration"),
        word("margins", "", "Margins of the requirements")
            .of(|run| json!(verdicts::words(&run.requirements))),
    ]
}

/// Columns of the drives with a finding.
const FAILURES: &[Column<Kept>] = &[
    count("number", "number", "Number of the scene"),
    word("scene", "scene", "Kind of the scene").of(|run| json!(run.scene.name())),
    outcome("outcome"),
    word("finding", "finding", "What it did").of(|run| json!(run.finding())),
    column("repeat", "", "", Format::Command, "Command that repeats all drives of its number")
        .of(|run| json!(run.repeat())),
];

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    Schema::new(NAME, "Random curved roads, and curve entries and exits with queues")
        .fields(FIELDS)
        .rows("sources", "Figures with each set of sources of the course", &figures::columns())
        .rows("places", "Figures by part of a curve", &figures::place_columns())
        .rows("limits", "Limits of the figures", LIMITS)
        .rows("margins", "Least margins of the requirements of the command", LEAST)
}

/// The document of all drives.
pub fn document(runs: &[Kept], laws: &LawOptions) -> Document {
    let results = Results::of(runs, laws.only());
    let law = laws.only().unwrap_or(LAW);
    let failed: Vec<Kept> = runs.iter().filter(|run| is_failure(run)).cloned().collect();
    let met = results.limits.iter().filter(|limit| limit.met).count();
    let verdict = format!(
        "lead lost {:.2} % of the time and {:.3} times per km, neighbour taken {:.3} times per km; \
         {met} of {} limits met",
        100.0 * results.lead_lost.share,
        results.lead_lost.per_km,
        results.neighbour_taken.per_km,
        results.limits.len(),
    );
    let (roads, queues) = results.sources.first().map_or((0.0, 0), |row| (row.km, row.beside));
    let document = Document::new(NAME, "Curves", &results)
        .about(format!(
            "{roads:.0} km of random roads, {queues} queues beside and in the lane, driven by {law}, lockstep"
        ))
        .verdict(results.ok, verdict)
        // Other sources than the judged ones are there for comparison.
        .table(
            Table::new("Sources of the course", &figures::columns(), &results.sources)
                .without_cases(),
        )
        .table(
            Table::new("Parts of a curve", &figures::place_columns(), &results.places)
                .blocks("place")
                .without_cases(),
        )
        .table(Table::new("Limits", LIMITS, &results.limits))
        .table(Table::new("Drives with a finding", FAILURES, &failed).most_rows(20))
        .file("curves.csv", Table::new("", &drives(), runs).csv())
        .file("events.csv", Table::new("", &event_rows::columns(), &event_rows::Row::all(runs)).csv());
    let document = required::show(document, &results.margins);
    // A drive whose lead is lost counts in the figures alone, but is worth a look.
    let is_eventful = |run: &&Kept| run.sources == JUDGED.name && !run.events.is_empty();
    let eventful = runs.iter().filter(is_eventful).filter(|run| !is_failure(run));
    failed.iter().chain(eventful).take(MOST_FILES).fold(document, |document, run| {
        let number = run.number as u64;
        let text = run.scene.text(number, &JUDGED, law);
        let scene = serde_json::to_value(run.scene).expect("a word");
        let name = format!("{}-{number}.toml", scene.as_str().unwrap_or_default());
        document.file(&name, text)
    })
}

fn is_failure(run: &Kept) -> bool {
    run.sources == JUDGED.name && !run.holds()
}

/// The runs with some sources, as `places` in the order of those that have runs at all.
fn with_sources(runs: &[Kept]) -> impl Iterator<Item = (&'static str, Vec<&Kept>)> {
    let all = sources::ALL.iter();
    all.map(|sources| {
        (sources.name, runs.iter().filter(|run| run.sources == sources.name).collect::<Vec<_>>())
    })
    .filter(|(_, runs)| !runs.is_empty())
}

impl Results {
    fn of(runs: &[Kept], law: Option<&str>) -> Self {
        let judged: Vec<&Kept> = runs.iter().filter(|run| run.sources == JUDGED.name).collect();
        let figures = Figures::of(JUDGED.name, &judged);
        let limits = Limit::all(&figures);
        let ended = |run: &&Kept| run.outcome == group::report::Outcome::Completed;
        // Collisions are judged by their limit.
        let hit = |run: &&Kept| run.outcome == group::report::Outcome::Collision;
        let failures = judged.iter().filter(|run| !run.holds()).map(|run| {
            format!(
                "{} {}: {}; to repeat: {}",
                run.scene.name(),
                run.number,
                run.finding(),
                run.repeat()
            )
        });
        Self {
            schema_version: 1,
            ok: limits.iter().all(|limit| limit.met)
                && judged.iter().all(|run| ended(run) || hit(run)),
            km: figures.km,
            lead_lost: figures.lead_lost,
            neighbour_taken: figures.neighbour_taken,
            phantom_interventions: figures.phantom_interventions,
            collisions: figures.collisions,
            sources: with_sources(runs).map(|(name, runs)| Figures::of(name, &runs)).collect(),
            places: places(runs),
            limits,
            law: law.map(str::to_owned),
            failures: failures.collect(),
            margins: verdicts::least(judged.iter().map(|run| {
                (format!("{} {}", run.scene.name(), run.number), run.requirements.as_slice())
            })),
        }
    }
}

/// Figures by part of a curve: all sources of one part below each other.
fn places(runs: &[Kept]) -> Vec<PlaceFigures> {
    let mut places: Vec<PlaceFigures> =
        with_sources(runs).flat_map(|(name, runs)| PlaceFigures::all(name, &runs)).collect();
    places.sort_by_key(|figures| figures.place);
    places
}

impl Limit {
    fn all(figures: &Figures) -> Vec<Self> {
        let of = |name, value: f64, limit: f64| Self { name, value, limit, met: value <= limit };
        vec![
            of("lead_lost.share", figures.lead_lost.share, limits::LOST_SHARE),
            of("lead_lost.per_km", figures.lead_lost.per_km, limits::LOST_PER_KM),
            of("neighbour_taken.per_km", figures.neighbour_taken.per_km, limits::TAKEN_PER_KM),
            of(
                "phantom_interventions",
                figures.phantom_interventions as f64,
                limits::PHANTOM_INTERVENTIONS,
            ),
            of("braked_share", figures.braked_share, limits::BRAKED_SHARE),
            of(
                "avoidable_collisions",
                figures.avoidable_collisions as f64,
                limits::AVOIDABLE_COLLISIONS,
            ),
            of("seen_late", figures.seen_late as f64, limits::SEEN_LATE),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::judge::tests::example;
    use super::*;
    use group::report::Outcome;
    use report::targets::Sums;

    fn all(sources: &'static str) -> Vec<Kept> {
        Scene::ALL.map(|scene| example(scene, sources)).to_vec()
    }

    #[test]
    fn the_judged_sources_decide_and_the_others_are_beside_them() {
        let mut runs = all(JUDGED.name);
        let mut straight = example(Scene::Road, sources::ALL[0].name);
        straight.places[0] = Sums { lost_s: 90.0, losses: 30, ..straight.places[0] };
        straight.outcome = Outcome::Collision;
        runs.push(straight);
        let results = Results::of(&runs, None);
        assert!(results.ok, "{:?}", results.limits);
        assert_eq!(results.sources.len(), 2);
        assert_eq!(results.sources[0].lead_lost, Often { share: 0.6, per_km: 6.0 });
        assert_eq!(results.lead_lost, Often::default());
        runs[1].interventions = 1;
        let results = Results::of(&runs, None);
        assert!(!results.ok && results.phantom_interventions == 1);
        let document = document(&runs, &LawOptions::default());
        assert!(document.junit().contains("<failure"), "{}", document.junit());
        assert!(document.console(200).contains("6 of 7 limits met"), "{}", document.console(200));
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }

    #[test]
    fn a_loss_too_many_exceeds_its_limit() {
        let mut runs = all(JUDGED.name);
        runs[0].places[1] = Sums { km: 0.0, losses: 1, ..Sums::default() };
        let results = Results::of(&runs, None);
        assert_eq!(results.lead_lost.per_km, 0.2);
        let exceeded: Vec<_> =
            results.limits.iter().filter(|limit| !limit.met).map(|limit| limit.name).collect();
        assert_eq!(exceeded, ["lead_lost.per_km"]);
    }
}
