//! `timegap test iso15622`: tests after ISO 15622 (adaptive cruise control), from secondary sources.
//!
//! ```text
//! law ─┬─ target acquisition ──┐
//!      ├─ target discrimination ┼─► rows: figure, value, limit
//!      ├─ stop and go ─────────┤
//!      ├─ six curves ──────────┤
//!      └─ bends, alone ────────┘
//! ```

mod judge;
mod limits;
mod scenes;

use std::process::ExitCode;

use clap::Args;
use frame::batch::{self, Done, Job};
use frame::{Command, DriveOptions, Entry, Found, Recorded, RunOptions, Study};
use judge::Row;
use report::results::{Broken, Column, Document, Schema, Table, flag, number, word};
use scenes::Test;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use supervise::Error;

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct Iso15622Arguments {
    /// Laws, keys and requirements of all drives.
    #[command(flatten)]
    pub drives: DriveOptions,
    /// Seed of the sensors' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u32,
}

/// Tests of adaptive cruise control after ISO 15622.
#[derive(Debug, Serialize, JsonSchema)]
struct Results {
    schema_version: u32,
    /// Every figure is inside its limits.
    ok: bool,
    /// A row for each figure of each test and law.
    rows: Vec<Row>,
}

const ROWS: &[Column<Row>] = &[
    word("law", "law", "Control law that drove"),
    word("test", "test", "Test of the standard"),
    word("figure", "figure", "Measured figure"),
    number("value", "value", "", 2, "Value; null if the event did not happen"),
    number("least", "at least", "", 2, "Least accepted value").weight(1),
    number("most", "at most", "", 2, "Largest accepted value").weight(1),
    word("unit", "unit", "Unit of the value").weight(2),
    flag("ok", "verdict", ("ok", "MISSED"), "The value is inside its limits"),
];

pub fn schema() -> Schema {
    Schema::of::<Results>("iso15622")
}

pub fn run(command: &Command<Iso15622Arguments>) -> Result<ExitCode, Error> {
    frame::run::<Tests>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Tests>();

pub struct Tests {
    tests: Vec<(String, Test)>,
    arguments: Iso15622Arguments,
}

impl Study for Tests {
    type Arguments = Iso15622Arguments;
    type Record = Vec<Row>;
    type Seen = ();

    const NAME: &'static str = "iso15622";

    fn plan(arguments: &Iso15622Arguments, _: &RunOptions) -> Result<Self, Error> {
        let laws = arguments.drives.own_named()?;
        let tests = laws.iter().flat_map(|law| Test::all().map(|test| (law.clone(), test)));
        Ok(Self { tests: tests.collect(), arguments: arguments.clone() })
    }

    fn runs(&self) -> usize {
        self.tests.len()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let ((law, test), Iso15622Arguments { drives, seed, .. }) =
            (&self.tests[run], &self.arguments);
        test.scenario(law, drives, *seed).map(Job::lockstep)
    }

    fn record(&self, run: usize, job: &Job, result: Result<Done, Error>) -> Recorded<Self> {
        let done = result?;
        batch::whole(&done.summary)?;
        let (law, test) = &self.tests[run];
        let mut rows = judge::rows(*test, law, &job.scenario, &done.drive);
        // A bend that shows too late is judged by the braking.
        let may_be_late = matches!(test, Test::Bend(bend) if !bend.has_map);
        let requirements = done.summary.requirements.iter();
        let judged = requirements
            .filter(|verdict| !(may_be_late && verdict.requirement.starts_with("lateral:")));
        rows.extend(judged.map(|verdict| Row {
            law: law.clone(),
            test: test.name(),
            figure: verdict.requirement.clone(),
            unit: verdict.unit.clone(),
            value: verdict.margin,
            least: Some(0.0),
            most: None,
            ok: verdict.met,
        }));
        Ok((rows, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        vec![("test".to_owned(), self.tests[run].1.name())]
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let rows = found.records.all()?.into_iter().flat_map(|(_, rows)| rows).collect();
        Ok(document(rows, &self.arguments))
    }
}

fn document(rows: Vec<Row>, arguments: &Iso15622Arguments) -> Document {
    let inside = rows.iter().filter(|row| row.ok).count();
    let (ok, all) = (inside == rows.len(), rows.len());
    let results = Results { schema_version: 1, ok, rows };
    let table = Table::new("Figures", ROWS, &results.rows).blocks("law");
    let missed = results.rows.iter().filter(|row| !row.ok);
    Document::new("iso15622", "ISO 15622", &results)
        .about("tests on a straight road and in curves, lockstep; the curves after ISO 15622, from secondary sources")
        .verdict(ok, format!("{inside} of {all} figures inside their limits"))
        .table(table)
        .broken(missed.map(|row| broken(row, arguments)))
}

/// A missed figure, with the command that drives its law again.
fn broken(row: &Row, arguments: &Iso15622Arguments) -> Broken {
    let Row { law, test, figure, unit, .. } = row;
    let value = row.value.map_or_else(|| "never".to_owned(), |value| format!("{value:.2} {unit}"));
    let (limit, seed) = (row.least.or(row.most).unwrap_or_default(), arguments.seed.to_string());
    let words = ["timegap", "test", "iso15622", "--controllers", law, "--seed", &seed];
    let words = [words.map(str::to_owned).to_vec(), arguments.drives.words()].concat();
    let what = format!("{law}, {test}: {figure} {value}, limit {limit:.2}");
    Broken::new(what, runtime::command_line(&words))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_beyond_its_limit_is_missed_in_every_form_and_stands_at_the_end() {
        let row = |law: &str, ok| Row {
            law: law.into(),
            test: "go".into(),
            figure: "moves_off_after_s".into(),
            unit: "s".into(),
            value: Some(3.5),
            most: Some(3.0),
            ok,
            ..Row::default()
        };
        let arguments = Iso15622Arguments { drives: DriveOptions::default(), seed: 7 };
        let document = document(vec![row("a", true), row("b", false)], &arguments);
        assert!(!document.is_ok());
        let console = document.console(120);
        assert!(console.contains("1 of 2 figures inside"), "{console}");
        let last = console.lines().last().expect("it has lines").trim();
        assert_eq!(
            last,
            "b, go: moves_off_after_s 3.50 s, limit 3.00: timegap test iso15622 --controllers b --seed 7"
        );
        assert!(document.junit().contains("failure"), "{}", document.junit());
    }

    /// Six laws with 37 figures each.
    #[test]
    fn a_terminal_shows_the_figures_in_a_few_screens() {
        let rows = (0..222).map(|index| Row {
            law: format!("law-{}", index / 37),
            test: "curve-class-iii-right".into(),
            figure: "time_gap_share_when_it_slows".into(),
            unit: "m/s³".into(),
            value: Some(12.34),
            least: Some(0.67),
            ok: index != 100,
            ..Row::default()
        });
        let arguments = Iso15622Arguments { drives: DriveOptions::default(), seed: 1 };
        let console = document(rows.collect(), &arguments).console(80);
        assert!(console.lines().count() < 250, "{}", console.lines().count());
        assert!(console.lines().last().is_some_and(|line| line.contains("law-2")), "{console}");
    }
}
