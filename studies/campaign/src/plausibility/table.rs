//! The tables: false alarms by check and by kind of drive, and the false senders that were found.

use report::results::{Column, Document, Kind, Schema, Table, count, nested, number, word};
use serde::Serialize;

use super::NAME;
use super::draw::KINDS;
use super::results::{Found, Rate, Results};
use crate::required;
use report::verdicts::LEAST;

/// Fields of the JSON.
const FIELDS: &[Column<Results>] = &[
    frame::ok(
        "No check found a contradiction without a fault, and no drive broke a requirement of the command",
    ),
    count("seed", "", "Seed of the random drives"),
    word("law", "", "Law of the user's own that drove the cars; null: those of the drives"),
    number("quiet_s", "", "s", 1, "Simulated time without faults"),
    count("drives", "", "Random drives without faults"),
];

/// Columns of a false sender, for programs.
const FAULTS: &[Column<Found>] = &[
    word("fault", "", "Fault of the sender"),
    word("size", "", "Size of the fault"),
    word("scenario", "", "Scenario"),
    count("drives", "", "Drives with the fault"),
    count("found", "", "Drives in which a check found it"),
    nested("checks", Kind::Object, "Number of drives by the check that found it first"),
    nested(
        "after_s",
        Kind::List,
        "Times from the fault's beginning until a check found it, s, in order",
    ),
];

/// Columns of a rate, for programs, at a path below its row.
fn rate<R>(below: &str) -> Vec<Column<R>> {
    let all = [
        count("drives", "", "Drives"),
        number("hours", "", "h", 2, "Simulated time"),
        count("alarmed", "", "Drives with at least one false alarm"),
        number("per_hour", "", "1/h", 2, "Drives with a false alarm per hour"),
        nested("per_hour_ci95", Kind::List, "Exact 95 % interval of this rate (Garwood, 1936)"),
    ];
    let at_path = |column: Column<R>| {
        let name = format!("{below}{}", column.head.name);
        column.named(name, String::new())
    };
    all.into_iter().map(at_path).collect()
}

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    let own: [Column<()>; 5] = [
        count("false_alarms", "", "Cycles with a false alarm"),
        nested("kinds", Kind::Object, "Drives with a false alarm, by kind"),
        word("example", "", "A drive with a false alarm"),
        number("nearest", "", "", 2, "Largest value without an alarm, as a share of the threshold"),
        word("scenario", "", "The drive with that value"),
    ];
    let check: Vec<Column<()>> = own.into_iter().chain(rate("")).collect();
    Schema::new(
        NAME,
        "False alarms of the controller's checks, and the false senders that they find",
    )
    .fields(FIELDS)
    .fields(&rate::<()>("all."))
    .map("checks", "Each check by its name, in drives without faults", &check)
    .map("kinds", "Each kind of drive by its name, without faults", &rate::<()>(""))
    .rows("faults", "The false senders", FAULTS)
    .rows("margins", "Least margins of the requirements of the command", LEAST)
}

/// A rate with its interval, for people.
#[derive(Serialize)]
struct Line<'a> {
    name: &'a str,
    drives: u64,
    hours: f64,
    alarmed: u64,
    per_hour: f64,
    low: f64,
    high: f64,
    nearest_percent: Option<f64>,
    example: Option<&'a str>,
}

impl<'a> Line<'a> {
    fn of(name: &'a str, rate: &Rate) -> Self {
        let Rate { drives, hours, alarmed, per_hour, per_hour_ci95: [low, high] } = *rate;
        let (nearest_percent, example) = (None, None);
        Self { name, drives, hours, alarmed, per_hour, low, high, nearest_percent, example }
    }
}

/// Columns of these lines; the first has the heading of what the lines are of.
fn lines<'a>(heading: &str) -> [Column<Line<'a>>; 9] {
    [
        word("", "", "Check or kind").named("name".to_owned(), heading.to_owned()),
        count("drives", "drives", "Drives").weight(1),
        number("hours", "time", "h", 2, "Simulated time").weight(2),
        count("alarmed", "alarmed", "Drives with at least one false alarm").less(),
        number("per_hour", "rate", "1/h", 2, "Drives with a false alarm per hour"),
        number("low", "from", "1/h", 2, "Lower end of the 95 % interval"),
        number("high", "to", "1/h", 2, "Upper end of the 95 % interval"),
        number(
            "nearest_percent",
            "nearest",
            "%",
            0,
            "Largest value without an alarm, of the threshold",
        ),
        word("example", "in", "A drive with a false alarm, else the one with the nearest value"),
    ]
}

/// A false sender, for people.
#[derive(Serialize)]
struct Sender {
    fault: &'static str,
    size: &'static str,
    scenario: &'static str,
    found: String,
    median_s: Option<f64>,
    longest_s: Option<f64>,
    by: String,
}

/// Columns of the false senders.
const SENDERS: &[Column<Sender>] = &[
    word("fault", "fault", "Fault of the sender, for 10 s"),
    word("size", "size", "Size of the fault"),
    word("scenario", "scenario", "Scenario").weight(1),
    word("found", "found", "Drives in which a check found it"),
    number("median_s", "median", "s", 2, "Median time until a check found it"),
    number("longest_s", "longest", "s", 2, "Longest time until a check found it"),
    word("by", "first found by", "Checks that found it first, with the number of drives").weight(2),
];

impl Sender {
    fn of(found: &Found) -> Self {
        let by = found.checks.iter().map(|(check, count)| format!("{check} {count}"));
        let after = &found.after_s;
        Self {
            fault: found.fault,
            size: found.size,
            scenario: found.scenario,
            found: format!("{} of {}", found.found, found.drives),
            median_s: after.get(after.len() / 2).copied(),
            longest_s: after.last().copied(),
            by: by.collect::<Vec<_>>().join(", "),
        }
    }
}

/// The document of all drives.
pub fn document(results: &Results) -> Document {
    let checks = results.checks.iter().map(|(name, check)| Line {
        nearest_percent: Some(100.0 * check.nearest),
        example: Some(check.example.as_ref().unwrap_or(&check.scenario)),
        ..Line::of(name, &check.rate)
    });
    let kinds = KINDS.iter().filter_map(|(name, _)| Some(Line::of(name, results.kinds.get(name)?)));
    let senders: Vec<_> =
        results.faults.iter().filter(|found| found.drives > 0).map(Sender::of).collect();
    let Rate { hours, alarmed, per_hour, per_hour_ci95: [low, high], .. } = results.all;
    let about = format!(
        "{hours:.1} h without faults, {} drives from seed {}, lockstep{}",
        results.drives,
        results.seed,
        results.law.as_ref().map_or_else(String::new, |law| format!(", cars by {law}"))
    );
    let found: usize = results.faults.iter().map(|found| found.found).sum();
    let faulty: usize = results.faults.iter().map(|found| found.drives).sum();
    let verdict = format!(
        "{alarmed} drives with a false alarm, {per_hour:.2} per hour (95 %: {low:.2} to {high:.2}); \
         {found} of {faulty} false senders found"
    );
    let verdict = match results.margins.iter().map(|least| least.broken).sum::<usize>() {
        0 => verdict,
        broken => format!("{verdict}; requirements BROKEN {broken} times"),
    };
    let document = Document::new(NAME, "Plausibility of the controller's inputs", results)
        .about(about)
        .verdict(results.ok, verdict)
        .table(Table::new("Checks", &lines("check"), &checks.collect::<Vec<_>>()))
        .table(Table::new("Kinds of drives", &lines("kind"), &kinds.collect::<Vec<_>>()))
        .table(Table::new("False senders", SENDERS, &senders));
    required::show(document, &results.margins)
}

#[cfg(test)]
mod tests {
    use super::super::Kept;
    use super::*;
    use group::report::CheckReport;

    #[test]
    fn a_false_alarm_breaks_the_verdict_and_a_false_sender_has_its_time() {
        let kept = |cycles, first_s| Kept {
            scenario: "free-road-0".to_owned(),
            duration_s: 1_800.0,
            checks: vec![CheckReport { check: "motion".to_owned(), cycles, first_s, nearest: 0.4 }],
            requirements: Vec::new(),
        };
        let mut results = Results::new(1, None);
        results.quiet(KINDS[0].0, &kept(0, None));
        results.quiet(KINDS[0].0, &kept(3, Some(7.0)));
        results.faulty(0, 5.0, &kept(9, Some(5.25)));
        results.faulty(0, 5.0, &kept(0, None));
        results.finish();
        let document = document(&results);
        assert!(!document.is_ok());
        let text = document.console(100);
        assert!(text.contains("1 drives with a false alarm, 1.00 per hour"), "{text}");
        assert!(text.contains("1 of 2") && text.contains("0.25"), "{text}");
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }
}
