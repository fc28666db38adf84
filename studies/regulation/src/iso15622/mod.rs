//! `timegap iso15622`: the tests of ISO 15622 on a straight road (adaptive cruise control).

mod limits;
mod rows;
mod scenes;

use std::fmt::Write;
use std::process::ExitCode;

use clap::Args;
use group::{Error, GroupOptions};
use report::html::{Cell, Column, document, section, table};
use report::output::{OutputDirectory, OutputOptions};
use report::print;
use rows::Row;
use runtime::Mode;
use scenes::Test;
use serde::Serialize;

use frame::batch::{self, Job, ProcessesSample};

/// Arguments of `iso15622`.
#[derive(Debug, Args)]
pub struct Iso15622Arguments {
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub controllers: Vec<String>,
    /// Seed of the sensors' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u32,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the rows as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Serialize)]
struct Results {
    schema_version: u32,
    ok: bool,
    rows: Vec<Row>,
    processes_sample: ProcessesSample,
}

/// Runs the command.
///
/// # Errors
/// [`Error::Scenario`] for an unknown controller, else what keeps the runs from starting.
pub fn run(arguments: &Iso15622Arguments) -> Result<ExitCode, Error> {
    let laws = batch::laws::own_named(&arguments.controllers)?;
    let tests: Vec<(&String, Test)> =
        laws.iter().flat_map(|law| Test::ALL.map(|test| (law, test))).collect();
    let jobs = tests
        .iter()
        .map(|(law, test)| test.scenario(law, arguments.seed).map(Job::lockstep))
        .collect::<Result<Vec<_>, Error>>()?;
    let output = OutputDirectory::create(&arguments.output, "iso15622")?;
    let bar = report::progress::count_bar(jobs.len(), arguments.json);
    let mut sheets = vec![Vec::new(); jobs.len()];
    let at_once = batch::at_once(None, Mode::Lockstep);
    let sample = batch::run(&jobs, at_once, &arguments.group, &bar, &mut |index, result| {
        let done = result?;
        batch::whole(&done.summary)?;
        let (law, test) = tests[index];
        sheets[index] = rows::rows(test, law, &done.drive);
        Ok(())
    });
    bar.finish_and_clear();
    let processes_sample = sample?;
    let rows: Vec<Row> = sheets.into_iter().flatten().collect();
    let ok = rows.iter().all(|row| row.ok);
    let results = Results { schema_version: 1, ok, rows, processes_sample };
    let json = serde_json::to_string_pretty(&results).expect("plain data") + "\n";
    let written = output.write("iso15622.json", json.as_bytes());
    let written = written.and_then(|()| output.write(report::FILE, page(&results).as_bytes()));
    if arguments.json {
        print::out(&json)?;
    } else {
        print::out(&text(&results.rows))?;
        print::out(&output.places())?;
    }
    written?;
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The rows for people: one block per law.
fn text(rows: &[Row]) -> String {
    let mut text = String::new();
    for of_law in rows.chunk_by(|a, b| a.law == b.law) {
        let name = of_law.first().map_or("", |row| row.law.as_str());
        writeln!(text, "{name}").expect("a string takes all");
        for row in of_law {
            let (test, figure) = (row.test, row.figure);
            let (value, limit, verdict) = (value(row), limit(row), verdict(row));
            writeln!(text, "  {test:<25} {figure:<34} {value:>8} {limit:>16}  {verdict}")
                .expect("a string takes all");
        }
    }
    text
}

fn page(results: &Results) -> String {
    let head = [
        ("test", Column::Text),
        ("figure", Column::Text),
        ("value", Column::Number),
        ("limit", Column::Number),
        ("", Column::Text),
    ];
    let body: String = (results.rows.chunk_by(|a, b| a.law == b.law))
        .map(|of_law| {
            let cells: Vec<_> = of_law
                .iter()
                .map(|row| {
                    let verdict = verdict(row).to_owned();
                    vec![
                        Cell::Plain(row.test.to_owned()),
                        Cell::Plain(row.figure.to_owned()),
                        Cell::Plain(value(row)),
                        Cell::Plain(limit(row)),
                        if row.ok { Cell::Good(verdict) } else { Cell::Bad(verdict) },
                    ]
                })
                .collect();
            let name = of_law.first().map_or("", |row| row.law.as_str());
            section(name, &table(&head, &cells))
        })
        .collect();
    let inside = results.rows.iter().filter(|row| row.ok).count();
    let verdict = format!("{inside} of {} figures inside their limits", results.rows.len());
    document("ISO 15622", "tests on a straight road, lockstep", results.ok, &verdict, &body)
}

fn value(row: &Row) -> String {
    row.value.map_or_else(|| "-".into(), |value| format!("{value:.2}"))
}

fn limit(row: &Row) -> String {
    let unit = row.unit;
    match (row.least, row.most) {
        (Some(least), _) => format!("≥ {least:.2} {unit}"),
        (None, Some(most)) => format!("≤ {most:.2} {unit}"),
        (None, None) => String::new(),
    }
}

fn verdict(row: &Row) -> &'static str {
    if row.ok { "ok" } else { "MISSED" }
}
