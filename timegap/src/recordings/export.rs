//! `timegap recording export`: a recording as tables, its frames as a capture.

use super::sheet::{Capture, Form, Item, Sheet};
use super::{open, print_damage};
use clap::{ArgGroup, Args};
use messages::names::{self, Enumeration};
use messages::{Element, Place, TOPICS, Topic, Value};
use recorder::{LawNames, Record};
use report::print;
use report::results::Document;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use supervise::Error;

#[derive(Debug, Args)]
#[command(after_help = PANDAS)]
#[command(group = ArgGroup::new("formats").args(["csv", "parquet", "pcap"]).required(true).multiple(true))]
pub struct ExportArguments {
    /// Results directory of a run, or a recording
    pub run: PathBuf,
    /// Write a CSV file per topic: a row per message, a column per value, units in the names
    #[arg(long)]
    pub csv: bool,
    /// Write the same tables as Parquet files
    #[arg(long)]
    pub parquet: bool,
    /// Write the vehicle's received and sent radio frames as a capture for Wireshark, `radio.pcap`
    #[arg(long)]
    pub pcap: bool,
    /// Directory for the files [default: csv or parquet beside the recording; for a capture alone, the recording's]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the written files as JSON, and nothing else
    #[arg(long)]
    pub json: bool,
}

const PANDAS: &str = "\
The first column, `log_time_ns`, is the message's time of publication, ns of run time. The other columns are \
the message's values, named by their dotted path. Nested arrays count from 0: `tracks.0.range_m`.

Two kinds of elements have tables of their own, with a row for each: the radar's detections \
(`radar_detections.detections.csv`) and frames on air (`radio_frames.frames.csv`).

A number with a name has a second column for the name: `rung` and `rung.name`. Figures of the law have their \
names in their columns' headings. Parquet files have the same columns with their types.

A damaged recording is exported as far as it can be read, with a note and status 1. In Python:

    import pandas as pd
    odometry = pd.read_csv(\"runs/mine/csv/vehicle_odometry.csv\")
    odometry[\"t_s\"] = odometry[\"header.acquisition_ns\"] / 1e9
    odometry = odometry.set_index(\"t_s\")
    print(odometry[[\"speed_mps\", \"acceleration_mps2\"]].describe())";

pub fn run(arguments: &ExportArguments) -> Result<ExitCode, Error> {
    let recording = open(&arguments.run)?;
    let forms = [(arguments.csv, Form::Csv), (arguments.parquet, Form::Parquet)];
    let forms: Vec<Form> =
        forms.into_iter().filter_map(|(asked, form)| asked.then_some(form)).collect();
    let directory = |form: Option<Form>| {
        let name = form.map_or("", Form::extension);
        arguments.out.clone().unwrap_or_else(|| recording.path().with_file_name(name))
    };
    let mut tables = Vec::new();
    for form in &forms {
        let directory = directory(Some(*form));
        make(&directory)?;
        for topic in TOPICS {
            tables.push(Table::begin(topic, &directory, &recording.metadata().law, *form)?);
        }
    }
    let mut capture = arguments.pcap.then(Capture::default);
    let mut records = recording.records();
    for record in records.by_ref() {
        for table in tables.iter_mut().filter(|table| table.topic == record.topic) {
            table.add(&record)?;
        }
        if let Some(capture) = &mut capture {
            capture.add(&record);
        }
    }
    let damage = [recording.damage(), records.damage()].concat();
    let files = tables.into_iter().map(Table::finish).collect::<Result<Vec<_>, _>>()?;
    let beside = directory(forms.first().copied());
    make(&beside)?;
    let captured = capture.map(|capture| capture.finish(&beside)).transpose()?;
    let mut tables = files.concat();
    if !damage.is_empty() {
        // An empty table of a damaged recording would pass for a topic without messages.
        for (path, _) in tables.extract_if(.., |(_, rows)| *rows == 0) {
            std::fs::remove_file(&path).map_err(Error::path("remove", &path))?;
        }
    }
    let files = tables.iter().chain(&captured);
    let files = files.map(|(path, rows)| json!({"path": path.to_string_lossy(), "rows": rows}));
    let whole = json!({"schema_version": 1, "files": files.collect::<Vec<_>>()});
    let of_form = |form: Form| {
        let is_its = |path: &Path| path.extension().is_some_and(|end| end == form.extension());
        let rows: Vec<_> = tables.iter().filter(|(path, _)| is_its(path)).map(|of| of.1).collect();
        let (tables, rows) =
            (print::counted(rows.len() as u64, "table"), print::counted(rows.iter().sum(), "row"));
        format!("{tables} with {rows} in {}", directory(Some(form)).display())
    };
    let mut written: Vec<String> = forms.into_iter().map(of_form).collect();
    written.extend((captured.iter()).map(|(path, frames)| {
        format!("{} in {}", print::counted(*frames, "frame"), path.display())
    }));
    let facts = written.into_iter().map(|line| ("written", line));
    print::show(arguments.json, &Document::new("export", "Export", &whole).facts("Export", facts))?;
    print_damage(&recording, &damage);
    Ok(if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn make(directory: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(directory).map_err(Error::path("create", directory))
}

struct Table {
    topic: Topic,
    sheet: Sheet,
    columns: Vec<Column>,
    lists: Vec<List>,
}

/// A value of the messages, with the names of its numbers.
struct Column {
    place: Place,
    names: Option<Names>,
}

enum Names {
    Fixed(&'static Enumeration),
    OfLaw(Vec<String>),
}

impl Table {
    fn begin(topic: Topic, directory: &Path, law: &LawNames, form: Form) -> Result<Self, Error> {
        let path = directory.join(topic.name().replace('/', "_"));
        let lists = List::of(topic, &path, form)?;
        let in_a_list = |place: &Place| lists.iter().any(|list| list.holds(place));
        let places = topic.layout().scalars().into_iter().filter(|place| !in_a_list(place));
        let columns: Vec<_> = places.map(|place| Column::new(place, law)).collect();
        let mut names = vec!["log_time_ns".to_owned()];
        columns.iter().for_each(|column| column.head(law, &mut names));
        let sheet = Sheet::begin(&path, form, &names)?;
        Ok(Self { topic, sheet, columns, lists })
    }

    fn add(&mut self, record: &Record) -> Result<(), Error> {
        let values = self.columns.iter().flat_map(|column| {
            let value = column.place.read(record.bytes());
            let name = match (&column.names, value) {
                (Some(names), Value::Unsigned(number)) => Some(Item::Name(names.of(number))),
                (Some(_), _) => Some(Item::Name("")),
                (None, _) => None,
            };
            [Some(Item::Value(value)), name].into_iter().flatten()
        });
        self.sheet.row([Item::Whole(record.log_time_ns)].into_iter().chain(values))?;
        self.lists.iter_mut().try_for_each(|list| list.add(record))
    }

    fn finish(self) -> Result<Vec<(PathBuf, u64)>, Error> {
        let mut files = vec![self.sheet.finish()?];
        for list in self.lists {
            files.push(list.sheet.finish()?);
        }
        Ok(files)
    }
}

/// An array too long for columns: a table of its own with a row for each valid entry.
struct List {
    sheet: Sheet,
    count: Place,
    sequence: Place,
    /// Scalars of an entry, from its first byte.
    columns: Vec<Place>,
    /// Offset of the entries in the message, bytes.
    first: usize,
    each: usize,
    len: usize,
}

/// Longest array that is written as columns.
const MOST_IN_COLUMNS: usize = 128;
/// Most bytes of a number; more are data, such as a frame's.
const MOST_IN_A_NUMBER: usize = 8;

impl List {
    /// The lists of a topic's messages.
    fn of(topic: Topic, table: &Path, form: Form) -> Result<Vec<Self>, Error> {
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
            let columns = entry.scalars();
            let own = columns.iter().map(|column| column.path.clone());
            let names = ["log_time_ns", "header.sequence", "index"].map(str::to_owned);
            let names: Vec<String> = names.into_iter().chain(own).collect();
            let name = table.file_name().unwrap_or_default().to_string_lossy();
            let path = table.with_file_name(format!("{name}.{}", field.name));
            let sheet = Sheet::begin(&path, form, &names)?;
            let (first, each) = (field.offset, entry.bytes);
            lists.push(Self { sheet, count, sequence, columns, first, each, len });
        }
        Ok(lists)
    }

    fn holds(&self, place: &Place) -> bool {
        (self.first..self.first + self.each * self.len).contains(&place.offset)
    }

    fn add(&mut self, record: &Record) -> Result<(), Error> {
        let Value::Unsigned(count) = self.count.read(record.bytes()) else { return Ok(()) };
        let count = usize::try_from(count).map_or(self.len, |count| count.min(self.len));
        let sequence = self.sequence.read(record.bytes());
        let entries = record.bytes()[self.first..].chunks_exact(self.each).take(count);
        for (index, entry) in entries.enumerate() {
            let head =
                [Item::Whole(record.log_time_ns), Item::Value(sequence), Item::Whole(index as i64)];
            let values = self.columns.iter().map(|column| Item::Value(column.read(entry)));
            self.sheet.row(head.into_iter().chain(values))?;
        }
        Ok(())
    }
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

    fn head(&self, law: &LawNames, into: &mut Vec<String>) {
        let path = &self.place.path;
        let figure = path
            .strip_prefix("figures.")
            .and_then(|index| law.figures.get(index.parse::<usize>().ok()?));
        into.push(match figure {
            Some(figure) => format!("figures.{}", figure.name),
            None => path.clone(),
        });
        if self.names.is_some() {
            into.push(format!("{path}.name"));
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
