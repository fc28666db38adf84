//! `timegap export`: a recording as tables, its frames as a capture.

use super::capture::Capture;
use super::{count, open, print_damage};
use clap::{ArgGroup, Args};
use group::Error;
use messages::names::{self, Enumeration};
use messages::{Element, Place, TOPICS, Topic, Value};
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
#[command(group = ArgGroup::new("formats").args(["csv", "pcap"]).required(true).multiple(true))]
pub struct ExportArguments {
    /// Results directory of a run, or a recording
    pub run: PathBuf,
    /// Write a CSV file per topic: a row per message, a column per value, units in the names
    #[arg(long)]
    pub csv: bool,
    /// Write the vehicle's received and sent radio frames as a capture for Wireshark, `radio.pcap`
    #[arg(long)]
    pub pcap: bool,
    /// Directory for the files [default: csv beside the recording; for a capture alone, the recording's]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the written files as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

const PANDAS: &str = "\
The first column, `log_time_ns`, is when the message was published, ns of run time; the others are the \
message's own, by their dotted path. Nested arrays count from 0: `tracks.0.range_m`; the radar's \
detections, up to 1,024 in a message, have a table of their own with a row for each, \
`radar_detections.detections.csv`, and so have frames on air, `radio_frames.frames.csv`. Behind a number \
that has a name stands the name: `rung` and `rung.name`; figures of the law have theirs in place of \
their number. Of a damaged recording what can be read is exported, with a note and status 1. In Python:

    import pandas as pd
    odometry = pd.read_csv(\"runs/mine/csv/vehicle_odometry.csv\")
    odometry[\"t_s\"] = odometry[\"header.acquisition_ns\"] / 1e9
    odometry = odometry.set_index(\"t_s\")
    print(odometry[[\"speed_mps\", \"acceleration_mps2\"]].describe())";

/// Runs the command.
pub fn run(arguments: &ExportArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let beside = || recording.path().with_file_name(if arguments.csv { "csv" } else { "" });
    let directory = arguments.out.clone().unwrap_or_else(beside);
    std::fs::create_dir_all(&directory).map_err(|reason| Error::Path {
        action: "create",
        path: directory.clone(),
        reason,
    })?;
    let mut tables = TOPICS
        .into_iter()
        .filter(|_| arguments.csv)
        .map(|topic| Table::begin(topic, &directory, &recording.metadata().law))
        .collect::<Result<Vec<_>, _>>()?;
    let mut capture = arguments.pcap.then(Capture::default);
    let mut records = recording.records();
    for record in records.by_ref() {
        if let Some(table) = tables.iter_mut().find(|table| table.topic == record.topic) {
            table.add(&record)?;
        }
        if let Some(capture) = &mut capture {
            capture.add(&record);
        }
    }
    let damage = [recording.damage(), records.damage()].concat();
    let files = tables.into_iter().map(Table::finish).collect::<Result<Vec<_>, _>>()?;
    let captured = capture.map(|capture| capture.finish(&directory)).transpose()?;
    let mut tables = files.concat();
    if !damage.is_empty() {
        // An empty table of a damaged recording would pass for a topic without messages.
        for (path, _) in tables.extract_if(.., |(_, rows)| *rows == 0) {
            std::fs::remove_file(&path).map_err(write_error(&path))?;
        }
    }
    let files: Vec<_> = tables.iter().chain(&captured).collect();
    if arguments.json {
        let files: Vec<_> = files
            .iter()
            .map(|(path, rows)| json!({"path": path.to_string_lossy(), "rows": rows}))
            .collect();
        let result = json!({"schema_version": 1, "files": files});
        print::out(&(serde_json::to_string_pretty(&result).expect("plain data") + "\n"))?;
    } else {
        if arguments.csv {
            let rows = tables.iter().map(|(_, rows)| rows).sum();
            let (tables, rows) = (count(tables.len() as u64, "table"), count(rows, "row"));
            print::out(&format!("{tables} with {rows} in {}\n", directory.display()))?;
        }
        if let Some((path, frames)) = &captured {
            print::out(&format!("{} in {}\n", count(*frames, "frame"), path.display()))?;
        }
    }
    print_damage(&recording, &damage);
    Ok(if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A topic's table during writing.
struct Table {
    topic: Topic,
    path: PathBuf,
    file: BufWriter<File>,
    columns: Vec<Column>,
    rows: u64,
    lists: Vec<List>,
}

/// A value of the messages, with the names of its numbers.
struct Column {
    place: Place,
    names: Option<Names>,
}

/// Names of numbers: fixed, or the law's.
enum Names {
    Fixed(&'static Enumeration),
    OfLaw(Vec<String>),
}

impl Table {
    fn begin(topic: Topic, directory: &Path, law: &LawNames) -> Result<Self, Error> {
        let path = directory.join(format!("{}.csv", topic.name().replace('/', "_")));
        let lists = List::of(topic, &path)?;
        let in_a_list = |place: &Place| lists.iter().any(|list| list.holds(place));
        let places = topic.layout().scalars().into_iter().filter(|place| !in_a_list(place));
        let columns: Vec<_> = places.map(|place| Column::new(place, law)).collect();
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
        Ok(Self { topic, path, file, columns, rows: 0, lists })
    }

    fn add(&mut self, record: &Record) -> Result<(), Error> {
        self.rows += 1;
        self.row(record).map_err(write_error(&self.path))?;
        self.lists.iter_mut().try_for_each(|list| list.add(record))
    }

    fn row(&mut self, record: &Record) -> std::io::Result<()> {
        let file = &mut self.file;
        write!(file, "{}", record.log_time_ns)?;
        for column in &self.columns {
            let value = column.place.read(record.bytes());
            cell(file, value)?;
            if let (Some(names), Value::Unsigned(number)) = (&column.names, value) {
                write!(file, ",{}", text(names.of(number)))?;
            }
        }
        file.write_all(b"\n")
    }

    fn finish(mut self) -> Result<Vec<(PathBuf, u64)>, Error> {
        self.file.flush().map_err(write_error(&self.path))?;
        let mut files = vec![(self.path, self.rows)];
        for list in self.lists {
            files.push(list.finish()?);
        }
        Ok(files)
    }
}

/// Writes a value into its cell.
fn cell(file: &mut BufWriter<File>, value: Value) -> std::io::Result<()> {
    match value {
        // Readers of CSV accept this as not a number.
        Value::Float(value) if value.is_nan() => file.write_all(b",nan"),
        value => write!(file, ",{value}"),
    }
}

/// A name from the file without characters that end a cell or a line.
fn text(name: &str) -> String {
    name.chars().map(|c| if matches!(c, ',' | '"') || c.is_control() { '_' } else { c }).collect()
}

/// An array too long for columns: a table of its own with a row for each valid entry.
struct List {
    path: PathBuf,
    file: BufWriter<File>,
    /// Valid entries.
    count: Place,
    sequence: Place,
    /// Scalars of an entry, from its first byte.
    columns: Vec<Place>,
    /// Offset of the entries in the message, bytes.
    first: usize,
    each: usize,
    len: usize,
    rows: u64,
}

/// Longest array that is written as columns.
const MOST_IN_COLUMNS: usize = 128;
/// Most bytes of a number; more are data, such as a frame's.
const MOST_IN_A_NUMBER: usize = 8;

impl List {
    /// The lists of a topic's messages.
    fn of(topic: Topic, table: &Path) -> Result<Vec<Self>, Error> {
        let layout = topic.layout();
        let scalar = |path: &str| layout.scalars().into_iter().find(|place| place.path == path);
        let mut lists = Vec::new();
        for field in layout.fields {
            let (Element::Struct(entry), Some(len)) = (field.shape.element, field.shape.len) else {
                continue;
            };
            let (Some(count), Some(sequence)) = (scalar("count"), scalar("header.sequence")) else {
                continue;
            };
            let has_data = entry.scalars().iter().any(|place| place.bytes > MOST_IN_A_NUMBER);
            if len <= MOST_IN_COLUMNS && !has_data {
                continue;
            }
            let path = table.with_extension(format!("{}.csv", field.name));
            let columns = entry.scalars();
            let begin = || {
                let mut file = BufWriter::new(File::create(&path)?);
                write!(file, "log_time_ns,header.sequence,index")?;
                columns.iter().try_for_each(|column| write!(file, ",{}", column.path))?;
                file.write_all(b"\n").map(|()| file)
            };
            let file = begin().map_err(write_error(&path))?;
            let (first, each) = (field.offset, entry.bytes);
            lists.push(Self { path, file, count, sequence, columns, first, each, len, rows: 0 });
        }
        Ok(lists)
    }

    fn holds(&self, place: &Place) -> bool {
        (self.first..self.first + self.each * self.len).contains(&place.offset)
    }

    fn add(&mut self, record: &Record) -> Result<(), Error> {
        self.entries(record).map_err(write_error(&self.path))
    }

    fn entries(&mut self, record: &Record) -> std::io::Result<()> {
        let Value::Unsigned(count) = self.count.read(record.bytes()) else { return Ok(()) };
        let count = usize::try_from(count).map_or(self.len, |count| count.min(self.len));
        let sequence = self.sequence.read(record.bytes());
        let entries = record.bytes()[self.first..].chunks_exact(self.each).take(count);
        for (index, entry) in entries.enumerate() {
            self.rows += 1;
            write!(self.file, "{},{sequence},{index}", record.log_time_ns)?;
            for column in &self.columns {
                cell(&mut self.file, column.read(entry))?;
            }
            self.file.write_all(b"\n")?;
        }
        Ok(())
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
            Some(figure) => into.push_str(&format!(",figures.{}", text(&figure.name))),
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
