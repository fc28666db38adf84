//! `timegap export`: a recording as tables.

use super::{count, open};
use clap::Args;
use group::Error;
use messages::{Place, TOPICS, Topic, Value};
use recorder::Recording;
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
The first column, `log_time_ns`, is when the recorder took the message; the others are the message's \
own, by their dotted path. Nested arrays count from 0: `tracks.0.range_m`. In Python:

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
    let mut files = Vec::new();
    for topic in TOPICS {
        let path = directory.join(format!("{}.csv", topic.name().replace('/', "_")));
        let rows = write(&recording, topic, &path).map_err(|reason| Error::Path {
            action: "write",
            path: path.clone(),
            reason,
        })?;
        files.push((path, rows));
    }
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
    Ok(ExitCode::SUCCESS)
}

/// Writes a topic's table; returns its rows.
fn write(recording: &Recording, topic: Topic, path: &Path) -> std::io::Result<u64> {
    let places = topic.layout().scalars();
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(head(&places).as_bytes())?;
    let mut rows = 0;
    for record in recording.records().filter(|record| record.topic == topic) {
        write!(file, "{}", record.log_time_ns)?;
        for place in &places {
            match place.read(record.bytes) {
                // What every reader of CSV takes for a number that is none.
                Value::Float(value) if value.is_nan() => file.write_all(b",nan")?,
                value => write!(file, ",{value}")?,
            }
        }
        file.write_all(b"\n")?;
        rows += 1;
    }
    file.flush()?;
    Ok(rows)
}

fn head(places: &[Place]) -> String {
    let names = places.iter().map(|place| format!(",{}", place.path));
    format!("log_time_ns{}\n", names.collect::<String>())
}
