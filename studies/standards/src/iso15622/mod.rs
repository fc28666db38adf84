//! `timegap iso15622`: tests after ISO 15622 (adaptive cruise control), from secondary sources.
//!
//! ```text
//! law ─┬─ target acquisition ──┐
//!      ├─ target discrimination ┼─► rows: figure, value, limit
//!      ├─ stop and go ─────────┤
//!      └─ six curves ──────────┘
//! ```

mod curves;
mod limits;
mod rows;
mod scenes;
mod sheet;

use clap::Args;
use frame::batch::{self, Done, Job};
use frame::{Command, Entry, Found, RunOptions, Study};
use group::{Error, LawOptions};
use report::results::{Column, Document, Schema, Table, flag, number, word};
use scenes::Test;
use serde::{Deserialize, Serialize};
use sheet::Row;
use std::process::ExitCode;

/// Arguments of `iso15622`.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct Iso15622Arguments {
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub controllers: Vec<String>,
    /// Laws of the user's own.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Seed of the sensors' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u32,
}

#[derive(Debug, Serialize)]
struct Results {
    schema_version: u32,
    ok: bool,
    rows: Vec<Row>,
}

/// Fields beside the rows.
const FIELDS: &[Column<Results>] = &[frame::ok("Every figure is inside its limits")];

/// Columns of the figures.
const ROWS: &[Column<Row>] = &[
    word("law", "law", "Control law that drove"),
    word("test", "test", "Test of the standard"),
    word("figure", "figure", "Measured figure"),
    number("value", "value", "", 2, "Value; null if the event did not happen"),
    number("least", "at least", "", 2, "Least accepted value"),
    number("most", "at most", "", 2, "Largest accepted value"),
    word("unit", "unit", "Unit of the value"),
    flag("ok", "verdict", ("ok", "MISSED"), "The value is inside its limits"),
];

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    Schema::new("iso15622", "Tests of adaptive cruise control after ISO 15622").fields(FIELDS).rows(
        "rows",
        "A row for each figure of each test and law",
        ROWS,
    )
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Tests>();

/// Runs the command.
///
/// # Errors
/// [`Error::Scenario`] for an unknown controller, else as [`frame::run`].
pub fn run(command: &Command<Iso15622Arguments>) -> Result<ExitCode, Error> {
    frame::run::<Tests>(command)
}

/// The study: each test with each law.
struct Tests {
    tests: Vec<(String, Test)>,
    own: LawOptions,
    seed: u32,
}

impl Study for Tests {
    type Arguments = Iso15622Arguments;
    type Record = Vec<Row>;
    type Seen = ();

    const NAME: &'static str = "iso15622";

    fn plan(arguments: &Iso15622Arguments, _: &RunOptions) -> Result<Self, Error> {
        let laws = batch::laws::own_named(&arguments.controllers, &arguments.laws.names())?;
        arguments.laws.expect_all_in(&laws)?;
        let tests = laws.iter().flat_map(|law| Test::all().map(|test| (law.clone(), test)));
        Ok(Self { tests: tests.collect(), own: arguments.laws.clone(), seed: arguments.seed })
    }

    fn runs(&self) -> usize {
        self.tests.len()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        let (law, test) = &self.tests[run];
        test.scenario(law, &self.own, self.seed).map(Job::lockstep)
    }

    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Vec<Row>, ()), Error> {
        let done = result?;
        batch::whole(&done.summary)?;
        let (law, test) = &self.tests[run];
        Ok((rows::rows(*test, law, &job.scenario, &done.drive), ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        vec![("test".to_owned(), self.tests[run].1.name().to_owned())]
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let records = found.records.all()?;
        let rows: Vec<Row> = records.into_iter().flat_map(|(_, rows)| rows).collect();
        Ok(document(rows))
    }
}

fn document(rows: Vec<Row>) -> Document {
    let inside = rows.iter().filter(|row| row.ok).count();
    let (ok, all) = (inside == rows.len(), rows.len());
    let results = Results { schema_version: 1, ok, rows };
    let table = Table::new("Figures", ROWS, &results.rows).blocks("law");
    Document::new("iso15622", "ISO 15622", &results)
        .about("tests on a straight road and in curves, lockstep; the curves after ISO 15622, from secondary sources")
        .verdict(ok, format!("{inside} of {all} figures inside their limits"))
        .table(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_beyond_its_limit_is_missed_in_every_form() {
        let row = |law: &str, ok| {
            let row = serde_json::json!({"law": law, "test": "go", "figure": "moves_off_after_s", "unit": "s",
                "value": 3.5, "least": null, "most": 3.0, "ok": ok});
            serde_json::from_value::<Row>(row).expect("a row")
        };
        let document = document(vec![row("a", true), row("b", false)]);
        assert!(!document.is_ok());
        assert!(document.console(80).contains("1 of 2 figures inside"), "{}", document.console(80));
        assert!(document.junit().contains("failure"), "{}", document.junit());
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }
}
