//! `timegap export`: a recording as tables.

use super::{count, open, tell};
use clap::Args;
use group::Error;
use messages::names::{self, Enumeration};
use messages::{Place, TOPICS, Topic, Value};
use recorder::{LawNames, Record};
use report::print;
use serde_json::json;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(after_long_help = PANDAS)]
pub struct ExportArguments {
    /// A run's directory of results, or a recording
    pub run: PathBuf,
    /// One CSV file per topic: a row per message, a column per value, units in the names
    #[arg(long, required = true)]
    pub csv: bool,
    /// Directory for the files [default: csv beside the recording]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print what was written as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

const PANDAS: &str = "\
The first column, `log_time_ns`, is when the message was published, ns of run time; the others are the \
message's own, by their dotted path. Nested arrays count from 0: `tracks.0.range_m`. Behind a number \
that has a name stands the name: `rung` and `rung.name`; figures of the law have theirs in place of \
their number. A damaged recording is exported as far as it goes: said, and status 1. In Python:

    import pandas as pd
    odometry = pd.read_csv(\"runs/mine/csv/vehicle_odometry.csv\")
    odometry[\"t_s\"] = odometry[\"header.acquisition_ns\"] / 1e9
    odometry = odometry.set_index(\"t_s\")
    print(odometry[[\"speed_mps\", \"acceleration_mps2\"]].describe())";

/// Runs the command.
pub fn run(arguments: &ExportArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let beside = || recording.path().with_file_name("csv");
    let directory = arguments.out.clone().unwrap_or_else(beside);
    std::fs::create_dir_all(&directory).map_err(|reason| Error::Path {
        action: "create",
        path: directory.clone(),
        reason,
    })?;
    let mut tables = TOPICS
        .into_iter()
        .map(|topic| Table::begin(topic, &directory, &recording.metadata().law))
        .collect::<Result<Vec<_>, _>>()?;
    let mut records = recording.records();
    for record in records.by_ref() {
        let table = tables.iter_mut().find(|table| table.topic == record.topic);
        table.expect("every topic has one").add(&record)?;
    }
    let damage = [recording.damage(), records.damage()].concat();
    let files = tables.into_iter().map(Table::finish).collect::<Result<Vec<_>, _>>()?;
    if arguments.json {
        let files: Vec<_> =
            files.iter().map(|(path, rows)| json!({"path": path, "rows": rows})).collect();
        let result = json!({"schema_version": 1, "files": files});
        print::out(&(serde_json::to_string_pretty(&result).expect("plain data") + "\n"))?;
    } else {
        let rows = files.iter().map(|(_, rows)| rows).sum();
        let (tables, rows) = (count(files.len() as u64, "table"), count(rows, "row"));
        print::out(&format!("{tables} with {rows} in {}\n", directory.display()))?;
    }
    tell(&recording, &damage);
    Ok(if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A topic's table while it is written.
struct Table {
    topic: Topic,
    path: PathBuf,
    file: BufWriter<File>,
    columns: Vec<Column>,
    rows: u64,
}

/// A value of the messages and the names of its numbers.
struct Column {
    place: Place,
    names: Option<Names>,
}

/// Names of numbers: the same in every run, or the law's.
enum Names {
    Fixed(&'static Enumeration),
    OfLaw(Vec<String>),
}

impl Table {
    fn begin(topic: Topic, directory: &Path, law: &LawNames) -> Result<Self, Error> {
        let path = directory.join(format!("{}.csv", topic.name().replace('/', "_")));
        let columns: Vec<_> =
            topic.layout().scalars().into_iter().map(|place| Column::new(place, law)).collect();
        let mut head = String::from("log_time_ns");
        for column in &columns {
            column.head(law, &mut head);
        }
        let begin = || {
            let mut file = BufWriter::new(File::create(&path)?);
            writeln!(file, "{head}")?;
            Ok(file)
        };
        let file = begin().map_err(write_error(&path))?;
        Ok(Self { topic, path, file, columns, rows: 0 })
    }

    fn add(&mut self, record: &Record) -> Result<(), Error> {
        self.rows += 1;
        self.row(record).map_err(write_error(&self.path))
    }

    fn row(&mut self, record: &Record) -> std::io::Result<()> {
        let file = &mut self.file;
        write!(file, "{}", record.log_time_ns)?;
        for column in &self.columns {
            let value = column.place.read(record.bytes());
            match value {
                // What every reader of CSV takes for a number that is none.
                Value::Float(value) if value.is_nan() => file.write_all(b",nan")?,
                value => write!(file, ",{value}")?,
            }
            if let (Some(names), Value::Unsigned(number)) = (&column.names, value) {
                write!(file, ",{}", names.of(number))?;
            }
        }
        file.write_all(b"\n")
    }

    fn finish(mut self) -> Result<(PathBuf, u64), Error> {
        self.file.flush().map_err(write_error(&self.path))?;
        Ok((self.path, self.rows))
    }
}

fn write_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    let path = path.to_owned();
    move |reason| Error::Path { action: "write", path, reason }
}

impl Column {
    fn new(place: Place, law: &LawNames) -> Self {
        let of_law = |names: &[String]| (!names.is_empty()).then(|| Names::OfLaw(names.to_vec()));
        let names = match (place.layout, place.field) {
            ("Diagnostics" | "Command", "mode") => of_law(&law.modes),
            ("Diagnostics", "mode_reason") => of_law(&law.reasons),
            (layout, field) => names::of_field(layout, field).map(Names::Fixed),
        };
        Self { place, names }
    }

    fn head(&self, law: &LawNames, into: &mut String) {
        let path = &self.place.path;
        let figure = path
            .strip_prefix("figures.")
            .and_then(|index| law.figures.get(index.parse::<usize>().ok()?));
        match figure {
            Some(figure) => into.push_str(&format!(",figures.{}", figure.name)),
            None => into.push_str(&format!(",{path}")),
        }
        if self.names.is_some() {
            into.push_str(&format!(",{path}.name"));
        }
    }
}

impl Names {
    fn of(&self, number: u64) -> &str {
        let name = match self {
            Self::Fixed(enumeration) => enumeration.value(number),
            Self::OfLaw(names) => {
                usize::try_from(number).ok().and_then(|at| names.get(at)).map(String::as_str)
            }
        };
        name.unwrap_or_default()
    }
}
