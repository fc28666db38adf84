//! Files of an export while they are written: tables as CSV or Parquet, frames as a capture for Wireshark.

use its::geonetworking::Headers;
use its::{pcap, signed};
use messages::{RadioFrames, RadioSent, Value};
use parquet_writer::{Cells, Writer};
use recorder::Record;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use supervise::Error;

const GROUP: usize = 10_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Csv,
    Parquet,
}

impl Form {
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    Value(Value<'a>),
    Whole(i64),
    /// A name; an empty one is absent.
    Name(&'a str),
}

pub struct Sheet {
    path: PathBuf,
    rows: u64,
    file: Inner,
}

enum Inner {
    Csv(BufWriter<File>),
    Parquet { writer: Writer<BufWriter<File>>, group: Vec<Cells> },
}

impl Sheet {
    /// Begins the table at `path`, which gets the form's extension.
    pub fn begin(path: &Path, form: Form, names: &[String]) -> Result<Self, Error> {
        // The name of a list has a dot of its own.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let path = path.with_file_name(format!("{name}.{}", form.extension()));
        let begin = || -> io::Result<Inner> {
            let mut file = BufWriter::new(File::create(&path)?);
            Ok(match form {
                Form::Csv => {
                    let names: Vec<_> = names.iter().map(|name| text(name)).collect();
                    writeln!(file, "{}", names.join(","))?;
                    Inner::Csv(file)
                }
                Form::Parquet => {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    Inner::Parquet { writer: Writer::new(file, &names, &[])?, group: Vec::new() }
                }
            })
        };
        let file = begin().map_err(Error::path("write", &path))?;
        Ok(Self { path, rows: 0, file })
    }

    pub fn row<'a>(&mut self, items: impl Iterator<Item = Item<'a>>) -> Result<(), Error> {
        self.rows += 1;
        let written = match &mut self.file {
            Inner::Csv(file) => csv_row(file, items),
            Inner::Parquet { writer, group } => {
                if group.is_empty() {
                    group.extend(items.map(|item| begun(&item)));
                } else {
                    group.iter_mut().zip(items).for_each(|(cells, item)| push(cells, &item));
                }
                match group.first().map(Cells::len) {
                    Some(GROUP) => writer.group(&std::mem::take(group)),
                    _ => Ok(()),
                }
            }
        };
        written.map_err(Error::path("write", &self.path))
    }

    /// Ends the table; returns its path and number of rows.
    pub fn finish(self) -> Result<(PathBuf, u64), Error> {
        let ended = match self.file {
            Inner::Csv(mut file) => file.flush(),
            Inner::Parquet { mut writer, group } if !group.is_empty() => {
                writer.group(&group).and_then(|()| writer.finish().map(drop))
            }
            Inner::Parquet { writer, .. } => writer.finish().map(drop),
        };
        ended.map_err(Error::path("write", &self.path))?;
        Ok((self.path, self.rows))
    }
}

fn csv_row<'a>(
    file: &mut BufWriter<File>,
    items: impl Iterator<Item = Item<'a>>,
) -> io::Result<()> {
    for (place, item) in items.enumerate() {
        if place > 0 {
            file.write_all(b",")?;
        }
        match item {
            // Readers of CSV accept this as not a number.
            Item::Value(Value::Float(value)) if value.is_nan() => file.write_all(b"nan")?,
            Item::Value(value) => write!(file, "{value}")?,
            Item::Whole(number) => write!(file, "{number}")?,
            Item::Name(name) => file.write_all(text(name).as_bytes())?,
        }
    }
    file.write_all(b"\n")
}

/// A name from the file without characters that end a cell or a line.
fn text(name: &str) -> String {
    name.chars().map(|c| if matches!(c, ',' | '"') || c.is_control() { '_' } else { c }).collect()
}

fn begun(item: &Item<'_>) -> Cells {
    let mut cells = match item {
        Item::Value(Value::Float(_)) => Cells::Number(Vec::new()),
        Item::Value(Value::Unsigned(_)) => Cells::Unsigned(Vec::new()),
        Item::Value(Value::Signed(_)) | Item::Whole(_) => Cells::Integer(Vec::new()),
        Item::Value(Value::Bytes(_)) | Item::Name(_) => Cells::Text(Vec::new()),
    };
    push(&mut cells, item);
    cells
}

fn push(cells: &mut Cells, item: &Item<'_>) {
    match (cells, item) {
        (Cells::Number(cells), Item::Value(Value::Float(value))) => cells.push(Some(*value)),
        (Cells::Unsigned(cells), Item::Value(Value::Unsigned(value))) => cells.push(Some(*value)),
        (Cells::Integer(cells), Item::Value(Value::Signed(value)) | Item::Whole(value)) => {
            cells.push(Some(*value));
        }
        (Cells::Text(cells), Item::Value(value @ Value::Bytes(_))) => {
            cells.push(Some(value.to_string()));
        }
        (Cells::Text(cells), Item::Name(name)) => {
            cells.push((!name.is_empty()).then(|| (*name).to_owned()));
        }
        _ => unreachable!("a column of a layout has one type"),
    }
}

const FILE: &str = "radio.pcap";

/// The frames at the vehicle: received and sent ones.
#[derive(Default)]
pub struct Capture {
    frames: Vec<(i64, Vec<u8>)>,
}

impl Capture {
    pub fn add(&mut self, record: &Record) {
        if let Some(batch) = record.message::<RadioFrames>() {
            let frames = batch.frames().iter();
            let start_ns = batch.utc_start_ns;
            self.frames.extend(frames.map(|f| (start_ns + f.received_ns, f.data().to_vec())));
        } else if let Some(sent) = record.message::<RadioSent>() {
            let at_ns = sent.utc_start_ns + sent.frame.sent_ns;
            self.frames.push((at_ns, sent.frame.data().to_vec()));
        }
    }

    /// Writes the capture in order of the frames' times; returns its path and the number of frames.
    pub fn finish(mut self, directory: &Path) -> Result<(PathBuf, u64), Error> {
        let path = directory.join(FILE);
        // Stable: frames of one instant stay in order of arrival.
        self.frames.sort_by_key(|(unix_ns, _)| *unix_ns);
        let write = || {
            let mut writer = pcap::Writer::new(BufWriter::new(File::create(&path)?))?;
            for (unix_ns, frame) in &self.frames {
                // An unreadable frame has no known sender.
                let opened = signed::open(frame).ok().flatten();
                let packet = opened.as_ref().map_or(frame, |(_, packet)| packet);
                let address =
                    Headers::read(packet).map_or(0, |(headers, _)| headers.source.address);
                writer.write(*unix_ns, address as u32, frame)?;
            }
            writer.finish()
        };
        write().map_err(Error::path("write", &path))?;
        Ok((path, self.frames.len() as u64))
    }
}
