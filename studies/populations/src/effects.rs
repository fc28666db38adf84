//! Effect of each number of a table on the figures of a population: it is halved and doubled.
//!
//! A table of a law is a table of the scenario. Numbers that laws share can be replaced once in a process, so each of
//! their values is driven by a process of its own: this command again.

use controller::law::following::parameters::FOLLOWING;
use controller::laws;
use controller::plausibility::radar::LIMITS;
use frame::batch;
use parameters::effect::{Change, Figure, line};
use parameters::{Row, Table, Varied};
use report::figures::compared;
use scenario::Setting;
use scenario::schema::{Key, Shape};
use serde_json::{Map, Value};
use std::process::Command;
use supervise::{Error, GroupOptions, UsageError};
use v2x_sim::numbers::NUMBERS;

use crate::figures::{Drives, values};
use crate::population::{Drive, Population};
use crate::study::Test;

/// Smallest change that is shown, percent.
const COUNTS_PERCENT: f64 = 1.0;

/// Variable of the environment by which this program runs itself with another value: row and value.
const REPLACED: &str = "PARAMETERS_REPLACED";

/// Prints the figures, and how each number of `table` changes them.
pub fn print<P: Population>(
    test: &mut Test<P>,
    table: &str,
    group: &GroupOptions,
) -> Result<(), Error> {
    let measure = || figures(test, group).unwrap_or_else(|error| panic!("{error}"));
    match table {
        "following" => print_by_processes(&FOLLOWING, measure),
        "plausibility" => print_by_processes(&LIMITS, measure),
        "v2x-sim" => print_by_processes(&NUMBERS, measure),
        table => return of_law(test, table, group),
    }
    Ok(())
}

/// Prints the figures and a line for each row of numbers that a process can replace once.
///
/// Each value is measured by a process of its own: this program, with the same arguments.
fn print_by_processes<T: Table>(numbers: &Varied<T>, measure: impl Fn() -> Vec<(Figure, f64)>) {
    let replaced = std::env::var(REPLACED).ok();
    if let Some((row, value)) = replaced.as_deref().and_then(|text| text.split_once('=')) {
        let (row, value) = (row.parse().expect("a row"), value.parse().expect("a number"));
        assert!(numbers.replace(numbers.with(row, value)).is_ok(), "the first replacement");
        let values: Vec<String> = measure().iter().map(|(_, value)| value.to_string()).collect();
        println!("{}", values.join(" "));
        return;
    }
    let (figures, base): (Vec<Figure>, Vec<f64>) = measure().into_iter().unzip();
    for (figure, value) in figures.iter().zip(&base) {
        println!("{}", figure.text(*value));
    }
    for (row, Row { name, .. }) in T::ROWS.iter().enumerate() {
        let tried = [0.5, 2.0].map(|factor| {
            let value = numbers.scaled(row, factor).value(row);
            (value, measured_elsewhere(row, value))
        });
        println!("{}", line(name, &figures, &base, &tried));
    }
}

/// The figures with another value in a row, from a process of its own.
fn measured_elsewhere(row: usize, value: f64) -> Vec<f64> {
    let program = std::env::current_exe().expect("the kernel knows this program");
    let answer = Command::new(program)
        .args(std::env::args_os().skip(1))
        .env(REPLACED, format!("{row}={value:?}"))
        .output()
        .expect("this program starts");
    let text = String::from_utf8_lossy(&answer.stdout);
    text.split_whitespace().map(|word| word.parse().expect("a figure")).collect()
}

/// The same of a law's own table. If the law refuses a value, a nearer one is tried.
fn of_law<P: Population>(
    test: &mut Test<P>,
    table: &str,
    group: &GroupOptions,
) -> Result<(), Error> {
    let tables = laws::tables();
    let Some(found) = tables.iter().find(|found| found.name == table) else {
        let names: Vec<&str> = tables.iter().map(|found| found.name).collect();
        let expected = format!("following, plausibility, v2x-sim, {}", names.join(", "));
        return Err(UsageError::option("--effects", table, "no such table", expected).into());
    };
    let (named, base): (Vec<Figure>, Vec<f64>) = figures(test, group)?.into_iter().unzip();
    named.iter().zip(&base).for_each(|(figure, value)| println!("{}", figure.text(*value)));
    let mut numbers = Vec::new();
    collect(&format!("controller.{table}."), (found.keys)(), &mut numbers);
    for (path, value) in numbers {
        let mut measured = |factor: &f64| {
            let value = (value * factor * 1e6).round() / 1e6;
            test.options.set.push(Setting::new(&path, value));
            let changed = figures(test, group);
            test.options.set.pop();
            Some((value, changed.ok()?.into_iter().map(|(_, value)| value).collect()))
        };
        let pairs = [[0.5, 0.8], [2.0, 1.25]].iter();
        let tried: Vec<_> = pairs.filter_map(|pair| pair.iter().find_map(&mut measured)).collect();
        println!("{}", line(&path, &named, &base, &tried));
    }
    Ok(())
}

/// The numbers of a table that have a default other than 0.
fn collect(prefix: &str, keys: Vec<Key>, into: &mut Vec<(String, f64)>) {
    for key in keys {
        let path = format!("{prefix}{}", key.name);
        match key.shape {
            Shape::Table(below) => collect(&format!("{path}."), below, into),
            Shape::Number { is_whole: false, .. } => {
                let default = key.default.and_then(|value| value.as_float());
                into.extend(default.filter(|value| *value != 0.0).map(|value| (path, value)));
            }
            _ => {}
        }
    }
}

/// The population's figures, and those of all drives, folded.
fn figures<P: Population>(
    test: &Test<P>,
    group: &GroupOptions,
) -> Result<Vec<(Figure, f64)>, Error> {
    let drive = |planned| {
        let scenario = test.scenario(planned)?;
        let done = batch::lockstep(&scenario, group, &|| true)?;
        Ok(test.judged(planned, &scenario, &done))
    };
    let drives = test.drives.iter().map(drive).collect::<Result<Vec<Drive<P::Facts>>, Error>>()?;
    let counted = drives.iter().filter(|drive| P::counts(drive)).collect();
    let (declared, mut own) = (P::figures(), Map::new());
    values(&declared, &Drives { labels: Vec::new(), all: counted }, &mut own);
    let own = Value::Object(own);
    let figure = |name: String, unit| Figure {
        name: name.into(),
        unit,
        change: Change::Percent(COUNTS_PERCENT),
    };
    let of_own = declared.iter().filter_map(|one| {
        let head = &one.column.head;
        let value = report::results::at(&own, &head.name)?.as_f64()?;
        Some((figure(head.name.to_string(), head.unit), value))
    });
    let folded = compared().filter_map(|one| {
        let value = one.fold.over(drives.iter().map(|drive| drive.figures.get(one))).value?;
        Some((figure(one.heading.to_owned(), one.unit), value))
    });
    Ok(of_own.chain(folded).collect())
}
