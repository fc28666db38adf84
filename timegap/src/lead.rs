//! `timegap recording lead`: a recorded motion as a scenario reads it.

use clap::Args;
use report::chart::{Curve, Plot, Stroke, Tone};
use report::html::figure;
use report::print;
use report::results::{Column, Document, Fact, Format, Table, column, count, word};
use scenario::quantity::{Duration, OutOfRange, TimeConstant, TimeShift};
use scenario::recorded::{self, AfterEnd, CsvFile, Record};
use scenario::{Problem, Refusal, ScenarioError, accepted};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::{Error, UsageError};

#[derive(Debug, Args)]
#[command(
    after_help = "The options have the names of the keys of `actors[].profile.csv`. Exit status 1: \
a scenario refuses this record because of its gaps."
)]
pub struct LeadArguments {
    /// A CSV file, an MCAP file or the folder of a ROS 2 bag
    pub file: PathBuf,
    /// Column of each quantity, with its unit: `t=stamp, v=speed:km/h` [default: time_s and speed_mps]
    #[arg(long, value_name = "LIST")]
    pub columns: Option<String>,
    /// Rows of one vehicle in a file of several
    #[arg(long, value_name = "COLUMN=VALUE")]
    pub rows: Option<String>,
    /// Topic of a bag; without it, the topics of a bag are listed
    #[arg(long, value_name = "NAME")]
    pub topic: Option<String>,
    /// Start of the run, s after the first row
    #[arg(long, value_name = "S", value_parser = quantity::<TimeShift>)]
    pub offset_s: Option<TimeShift>,
    /// Half the window of the smoothing filter, s
    #[arg(long, value_name = "S", value_parser = quantity::<TimeConstant>)]
    pub smooth_s: Option<TimeConstant>,
    /// Longest step between two rows, s
    #[arg(long, value_name = "S", value_parser = quantity::<Duration>)]
    pub max_gap_s: Option<Duration>,
    /// Motion after the last row: keep-speed, stop or leave
    #[arg(long, value_name = "HOW", value_parser = after_end, default_value = "keep-speed")]
    pub after_end: AfterEnd,
    /// Write the plot as a page
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
    /// Write the points that a run would use as CSV
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Print the result as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &LeadArguments) -> Result<ExitCode, Error> {
    let path = &arguments.file;
    if arguments.topic.is_none() && bags::is_bag(path) {
        return list(path, arguments.json);
    }
    let keys = CsvFile {
        file: path.clone(),
        columns: arguments.columns.clone(),
        rows: arguments.rows.clone(),
        topic: arguments.topic.clone(),
        offset_s: arguments.offset_s,
        smooth_s: arguments.smooth_s,
        max_gap_s: arguments.max_gap_s,
        after_end: arguments.after_end,
        points: Vec::new(),
    };
    let record = recorded::read(path, &keys).map_err(|error| match error {
        Refusal::Key(Problem { path, message, expected, .. }) => {
            Error::from(UsageError::at(format!("--{}", path.replace('_', "-")), message, expected))
        }
        Refusal::File(error) => error.into(),
    })?;
    let refusal = record.expect_whole().err();
    let document = document(path, &record, refusal.as_ref());
    if let Some(page) = &arguments.page {
        write(page, &document.page())?;
    }
    if let Some(table) = &arguments.table {
        let lines = record.profile().map(|(t, v)| format!("{t},{v}\n"));
        write(table, &("time_s,speed_mps\n".to_owned() + &lines.collect::<String>()))?;
    }
    print::show(arguments.json, &document)?;
    Ok(if refusal.is_some() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn quantity<T: TryFrom<f64, Error = OutOfRange<f64>>>(text: &str) -> Result<T, String> {
    let number = text.parse::<f64>().map_err(|_| "expected a number")?;
    T::try_from(number).map_err(|error| error.to_string())
}

fn after_end(text: &str) -> Result<AfterEnd, String> {
    let found = AfterEnd::ALL.into_iter().find(|kind| kind.name() == text);
    let names = || accepted(text, AfterEnd::ALL.iter().map(|kind| kind.name()));
    found.ok_or_else(|| format!("expected {}", names()))
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    std::fs::write(path, text).map_err(Error::path("write", path))
}

fn list(path: &Path, is_json: bool) -> Result<ExitCode, Error> {
    let topics =
        bags::topics(path).map_err(|why| UsageError::at(path.display(), why, "an MCAP file"))?;
    let whole = topics.iter().map(|topic| {
        json!({"name": topic.name, "type": topic.type_name, "messages": topic.messages,
               "fields": topic.fields})
    });
    let whole = json!({
        "schema_version": 1,
        "file": path.to_string_lossy(),
        "topics": whole.collect::<Vec<_>>(),
    });
    let fields = |row: &Value| {
        let fields = row["fields"].as_array().map(Vec::as_slice).unwrap_or_default();
        let more = if fields.len() > MOST_FIELDS { ", …" } else { "" };
        let named = fields.iter().take(MOST_FIELDS).filter_map(Value::as_str);
        json!(named.collect::<Vec<_>>().join(", ") + more)
    };
    let columns: [Column<Value>; 4] = [
        word("name", "", "Topic"),
        word("type", "type", "Type of its messages"),
        count("messages", "messages", "Messages"),
        column("", "", "", Format::Sentence, "Fields of a message").of(fields),
    ];
    let rows = whole["topics"].as_array().map(Vec::as_slice).unwrap_or_default();
    let document = Document::new("lead", "Topics of a bag", &whole)
        .table(Table::new("Topics", &columns, rows))
        .verdict(true, "--topic NAME --columns v=FIELD reads one of them");
    print::show(is_json, &document)?;
    Ok(ExitCode::SUCCESS)
}

/// Most fields that are printed of a topic.
const MOST_FIELDS: usize = 12;

fn distance_m(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<_> = points.collect();
    let part = |pair: &[(f64, f64)]| (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1) / 2.0;
    points.windows(2).map(part).sum()
}

fn length_s(record: &Record) -> f64 {
    record.rows.last().map_or(0.0, |last| last.0 - record.rows[0].0)
}

fn as_json(path: &Path, record: &Record) -> Value {
    let hardest = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        recorded::hardest(points)
            .map(|(rate, at_s)| json!({"acceleration_mps2": rate, "at_s": at_s}))
    };
    let gap = |gap: &recorded::Gap| json!({"from_s": gap.from_s, "length_s": gap.length_s});
    let stop = |(from_s, to_s): &(f64, f64)| json!({"from_s": from_s, "to_s": to_s});
    json!({
        "schema_version": 1,
        "file": path.to_string_lossy(),
        "rows": record.rows.len(),
        "points": record.points.len(),
        "length_s": length_s(record),
        "median_step_s": record.median_step_s,
        "longest_step_s": longest_step_s(record),
        "gaps": record.gaps.iter().map(gap).collect::<Vec<_>>(),
        "stops": record.stops.iter().map(stop).collect::<Vec<_>>(),
        "top_speed_mps": record.profile().map(|point| point.1).fold(0.0, f64::max),
        "distance_m": distance_m(record.profile()),
        "hardest_recorded": hardest(&mut record.rows.iter().copied()),
        "hardest_read": hardest(&mut record.profile()),
        "leaves_at_s": record.leaves_at_s.map(|time| time.value()),
        "notes": record.notes(),
    })
}

fn longest_step_s(record: &Record) -> f64 {
    record.rows.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max)
}

/// The record in words and as curves.
fn document(path: &Path, record: &Record, refusal: Option<&ScenarioError>) -> Document {
    let mut facts: Vec<Fact> = Vec::new();
    let mut add = |name: &str, value: String| facts.push((name.to_owned(), value));
    let (step_s, longest_s) = (record.median_step_s, longest_step_s(record));
    add("rows", record.rows.len().to_string());
    add("length", format!("{:.1} s", length_s(record)));
    add("step", format!("usually {step_s:.3} s, at most {longest_s:.3} s"));
    let top = record.profile().map(|point| point.1).fold(0.0, f64::max);
    add("speed", format!("0 to {top:.1} m/s"));
    add("distance", format!("{:.0} m", distance_m(record.profile())));
    let hardest = |(rate, at_s): (f64, f64)| format!("{rate:.2} m/s² at {at_s:.1} s");
    let of_rows = recorded::hardest(record.rows.iter().copied()).map(hardest);
    add("hardest", of_rows.unwrap_or_else(|| "one row has no acceleration".into()));
    if record.points.len() != record.rows.len() {
        let filtered = recorded::hardest(record.profile()).map(hardest).unwrap_or_default();
        add("as a run uses it", format!("{filtered}, {} points", record.points.len()));
    }
    for (from_s, to_s) in &record.stops {
        add("stop", format!("{from_s:.1} to {to_s:.1} s"));
    }
    for gap in &record.gaps {
        add("GAP", format!("{:.2} s after {:.1} s", gap.length_s, gap.from_s));
    }
    let notes = record.notes();
    for note in &notes {
        add("NOTE", note.clone());
    }
    let verdict = match (refusal, notes.first()) {
        (Some(refusal), _) => format!("a scenario refuses it: {}", refusal.message()),
        (None, Some(note)) => format!("readable, but {note}"),
        (None, None) => "readable".into(),
    };
    Document::new("lead", "Recorded motion", &as_json(path, record))
        .about(path.display().to_string())
        .facts("The record", facts)
        .figures("Speed and acceleration", curves(record))
        .verdict(refusal.is_none() && notes.is_empty(), verdict)
}

/// Speed and acceleration, as recorded and as a run uses them.
fn curves(record: &Record) -> String {
    let until_s = record.profile().last().map_or(1.0, |last| last.0);
    let from_s = record.rows.first().map_or(0.0, |first| first.0.min(0.0));
    let axis = || report::chart::Axis::linear("time, s", from_s, until_s.max(from_s + 1e-3));
    let read: Vec<_> = record.profile().collect();
    let rates = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let rate =
            |pair: &[(f64, f64)]| (pair[0].0, (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0));
        points.windows(2).map(rate).collect()
    };
    let both = |of_read, of_rows| {
        vec![
            Curve::new("as a run uses it", Tone::Series(0), of_read),
            Curve::new("as recorded", Tone::Muted, of_rows).stroke(Stroke::Dotted).thin(),
        ]
    };
    let rates = both(rates(&read), rates(&record.rows));
    let speed = Plot::over("Speed", axis(), "m/s", both(read, record.rows.clone()));
    figure(&speed) + &figure(&Plot::over("Acceleration", axis(), "m/s²", rates))
}
