//! The numbers of one topic as rows.

use crate::BagError;
use crate::decode::{self, Encoding};
use crate::definition::Definition;
use crate::error::one_of;
use crate::mcap::{self, Connection, Sink};
use std::collections::BTreeMap;
use std::fs::{File, ReadDir};
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// Most messages of a topic that are read.
const MOST_MESSAGES: usize = 4_000_000;
/// Bags of earlier tools by their first bytes: what they are, and what makes an MCAP file of them.
const EARLIER: [(&[u8], &str, &str); 2] = [
    (b"#ROSBAG V2.0\n", "a ROS 1 bag", "`rosbags-convert`"),
    (b"SQLite format 3\0", "an SQLite bag", "`ros2 bag convert`"),
];

/// First bytes of a file, which say what it is.
const FIRST: usize = 16;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    pub name: String,
    pub type_name: String,
    pub messages: u64,
    /// Paths of the numbers in a message; empty where the definition is not read.
    pub fields: Vec<String>,
}

/// One message: its time and the values of the chosen fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Time of recording, ns since 1970.
    pub log_time_ns: u64,
    /// Values, in the order of the fields that were asked for.
    pub values: Vec<f64>,
}

impl Row {
    /// Time of recording, s since 1970.
    pub fn log_time_s(&self) -> f64 {
        self.log_time_ns as f64 * 1e-9
    }
}

/// The numbers of one topic, in the order of the log times.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub type_name: String,
    pub rows: Vec<Row>,
}

/// True if the file at `path` begins like a bag, or a file in the folder `path`. Bags that are not read count too.
pub fn is_bag(path: &Path) -> bool {
    let has_bag = |entries: ReadDir| entries.flatten().any(|entry| is_bag_file(&entry.path()));
    is_bag_file(path) || path.read_dir().is_ok_and(has_bag)
}

fn is_bag_file(path: &Path) -> bool {
    let mut first = [0; FIRST];
    // Opening a pipe would wait for its other end.
    let is_file = path.metadata().is_ok_and(|metadata| metadata.is_file());
    let read =
        is_file && File::open(path).is_ok_and(|mut file| file.read_exact(&mut first).is_ok());
    let kinds = EARLIER.map(|(magic, ..)| magic);
    read && kinds.iter().chain([&mcap::MAGIC]).any(|magic| first.starts_with(magic))
}

/// Lists the topics of the file at `path`, by name.
///
/// # Errors
/// If the file cannot be read.
pub fn topics(path: &Path) -> Result<Vec<Topic>, BagError> {
    let mut listing = Listing::default();
    read_path(path, &mut listing)?;
    let mut topics: Vec<Topic> = listing.0.into_values().collect();
    topics.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(topics)
}

/// Reads the values of `fields` of all messages of `topic` in the file at `path`.
///
/// # Errors
/// If the file cannot be read, or has no such topic or field.
pub fn series(path: &Path, topic: &str, fields: &[String]) -> Result<Series, BagError> {
    collect(topic, fields, |choice| read_path(path, choice))
}

/// Reads the same from a file in memory or elsewhere.
pub fn series_from(
    file: &mut (impl Read + Seek),
    topic: &str,
    fields: &[String],
) -> Result<Series, BagError> {
    collect(topic, fields, |choice| read(file, choice))
}

/// Collects the rows of `topic` from what `read` hands over.
fn collect(
    topic: &str,
    fields: &[String],
    read: impl FnOnce(&mut Choice<'_>) -> Result<(), BagError>,
) -> Result<Series, BagError> {
    let mut choice = Choice { topic, fields, ..Choice::default() };
    read(&mut choice)?;
    let Choice { sources, type_name, mut rows, mut topics, .. } = choice;
    if sources.is_empty() {
        topics.sort_unstable();
        topics.dedup();
        return Err(BagError::topic(format!("no topic `{topic}`")).expecting(one_of(&topics)));
    }
    if rows.is_empty() {
        return Err(BagError::topic(format!("no messages of topic `{topic}`")));
    }
    // Stable: messages of one instant keep the file's order.
    rows.sort_by_key(|row| row.log_time_ns);
    Ok(Series { type_name, rows })
}

/// The one bag in a folder, which ROS 2 makes for it; `path` itself if it is not a folder.
fn in_folder(path: &Path) -> Result<PathBuf, BagError> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let entries = path.read_dir()?.flatten().map(|entry| entry.path());
    let mut bags: Vec<PathBuf> = entries.filter(|path| is_bag_file(path)).collect();
    bags.sort();
    match bags.pop() {
        Some(bag) if bags.is_empty() => Ok(bag),
        Some(last) => {
            let message = format!("it is a folder with {} bags", bags.len() + 1);
            Err(BagError::file(message)
                .expecting(format!("one of them, such as {}", last.display())))
        }
        None => Err(no_bag()),
    }
}

fn no_bag() -> BagError {
    BagError::file("it is not a bag").expecting("an MCAP file")
}

fn read_path(path: &Path, sink: &mut dyn Sink) -> Result<(), BagError> {
    let path = in_folder(path)?;
    if !path.metadata()?.is_file() {
        return Err(no_bag());
    }
    read(&mut BufReader::with_capacity(1 << 16, File::open(path)?), sink)
}

fn read(file: &mut (impl Read + Seek), sink: &mut dyn Sink) -> Result<(), BagError> {
    let mut first = Vec::new();
    file.by_ref().take(FIRST as u64).read_to_end(&mut first)?;
    if first.starts_with(mcap::MAGIC) {
        return mcap::read(file, sink);
    }
    Err(match EARLIER.iter().find(|(magic, ..)| first.starts_with(magic)) {
        Some((_, kind, program)) => BagError::file(format!("it is {kind}"))
            .expecting(format!("an MCAP file ({program} makes one of it)")),
        None => no_bag(),
    })
}

#[derive(Default)]
struct Listing(BTreeMap<u16, Topic>);

impl Sink for Listing {
    fn connection(&mut self, connection: Connection<'_>) {
        self.0.entry(connection.id).or_insert_with(|| Topic {
            name: connection.topic.to_owned(),
            type_name: connection.type_name.to_owned(),
            messages: 0,
            fields: Definition::parse(connection.type_name, connection.definition).numbers(),
        });
    }

    fn message(&mut self, id: u16, _: u64, _: &[u8]) -> Result<(), BagError> {
        if let Some(topic) = self.0.get_mut(&id) {
            topic.messages += 1;
        }
        Ok(())
    }
}

/// Collects the rows of one topic.
#[derive(Default)]
struct Choice<'a> {
    topic: &'a str,
    fields: &'a [String],
    /// Connections of the topic. A bag can hold several, one for each publisher.
    sources: BTreeMap<u16, (Definition, Encoding)>,
    type_name: String,
    rows: Vec<Row>,
    topics: Vec<String>,
}

impl Sink for Choice<'_> {
    fn connection(&mut self, connection: Connection<'_>) {
        if connection.topic != self.topic {
            self.topics.push(connection.topic.to_owned());
            return;
        }
        connection.type_name.clone_into(&mut self.type_name);
        self.sources.entry(connection.id).or_insert_with(|| {
            let definition = Definition::parse(connection.type_name, connection.definition);
            (definition, connection.encoding)
        });
    }

    fn message(&mut self, id: u16, log_time_ns: u64, payload: &[u8]) -> Result<(), BagError> {
        let Some((definition, encoding)) = self.sources.get(&id) else { return Ok(()) };
        let topic = self.topic;
        if self.rows.len() >= MOST_MESSAGES {
            let message = format!("topic `{topic}` has more than {MOST_MESSAGES} messages");
            return Err(BagError::file(message));
        }
        let value = |field: &String| {
            let found = match encoding {
                Encoding::Cdr => decode::number(definition, field, true, payload),
                Encoding::Ros1 => decode::number(definition, field, false, payload),
                Encoding::Json => decode::json_number(field, payload),
                Encoding::Other(name) => {
                    let message = format!("topic `{topic}` is encoded as {name}");
                    return Err(BagError::topic(message).expecting("CDR (ros2msg), ROS 1 or JSON"));
                }
            };
            let number = found.map_err(|_| {
                let index = self.rows.len() + 1;
                let fault = "does not fit its definition";
                BagError::file(format!("message {index} of topic `{topic}` {fault}"))
            })?;
            number.ok_or_else(|| {
                let message = format!("`{field}` is not a number of {}", self.type_name);
                BagError::field(message).expecting(one_of(&definition.numbers()))
            })
        };
        let values = self.fields.iter().map(value).collect::<Result<_, _>>()?;
        self.rows.push(Row { log_time_ns, values });
        Ok(())
    }
}
