//! Topics of a recording as columns.

use crate::errors::RunError;
use messages::{Element, Layout, Place, TOPICS, Topic, Value};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;

/// Longest array whose elements are columns; a longer one has a table of its own.
const MOST_IN_COLUMNS: usize = 128;
/// Most bytes of a number; more are data, such as a frame's.
const MOST_IN_A_NUMBER: usize = 8;

/// A recording of a run.
#[pyclass(frozen, module = "timegap._timegap")]
pub struct Recording(recorder::Recording);

/// A column: its name, numpy's name of its type, its bytes.
type Column<'py> = (String, String, Bound<'py, PyBytes>);

/// A column while messages are read.
struct Growing {
    place: Place,
    kind: String,
    bytes: Vec<u8>,
}

impl Growing {
    fn new(place: Place) -> Self {
        Self { place, kind: "<f8".to_owned(), bytes: Vec::new() }
    }

    fn add(&mut self, message: &[u8]) {
        let (kind, bytes) = match self.place.read(message) {
            Value::Float(value) => ("<f8", value.to_le_bytes()),
            Value::Unsigned(value) => ("<u8", value.to_le_bytes()),
            Value::Signed(value) => ("<i8", value.to_le_bytes()),
            Value::Bytes(bytes) => {
                self.bytes.extend(bytes);
                self.kind = format!("|V{}", bytes.len());
                return;
            }
        };
        kind.clone_into(&mut self.kind);
        self.bytes.extend(bytes);
    }
}

/// The long lists of a topic's messages: name, first byte, layout of an entry, entries.
fn lists(topic: Topic) -> Vec<(&'static str, usize, &'static Layout, usize)> {
    let fields = topic.layout().fields.iter();
    let lists = fields.filter_map(|field| {
        let (Element::Struct(entry), Some(len)) = (field.shape.element, field.shape.len) else {
            return None;
        };
        let has_data = entry.scalars().iter().any(|place| place.bytes > MOST_IN_A_NUMBER);
        (len > MOST_IN_COLUMNS || has_data).then_some((field.name, field.offset, entry, len))
    });
    lists.collect()
}

#[pymethods]
impl Recording {
    /// Opens a recording, or the one in a directory of results.
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        recorder::Recording::open(&path)
            .map(Self)
            .map_err(|error| RunError::new_err(error.to_string()))
    }

    /// Names of the topics that have messages, with their numbers.
    fn topics(&self) -> Vec<(String, u64)> {
        let mut counts = vec![0_u64; TOPICS.len()];
        for record in self.0.records() {
            if let Some(place) = TOPICS.iter().position(|topic| *topic == record.topic) {
                counts[place] += 1;
            }
        }
        let named = TOPICS.iter().zip(counts).filter(|(_, count)| *count > 0);
        named.map(|(topic, count)| (topic.name().to_owned(), count)).collect()
    }

    /// The messages of a topic as columns, a row for each message. With `list` it is a row for each valid entry of that
    /// list.
    #[pyo3(signature = (name, list=None))]
    fn topic<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        list: Option<&str>,
    ) -> PyResult<Vec<Column<'py>>> {
        let Some(topic) = TOPICS.into_iter().find(|topic| topic.name() == name) else {
            let names: Vec<_> = TOPICS.iter().map(|topic| topic.name()).collect();
            let names = names.join(", ");
            return Err(PyKeyError::new_err(format!("no topic `{name}`, expected one of {names}")));
        };
        let (mut times, mut columns) = (Vec::<u8>::new(), Vec::new());
        let lists = lists(topic);
        if let Some(wanted) = list {
            let Some(&(_, first, entry, len)) = lists.iter().find(|(name, ..)| *name == wanted)
            else {
                let names: Vec<_> = lists.iter().map(|(name, ..)| *name).collect();
                let what = format!("{name} has no list `{wanted}`, expected one of {names:?}");
                return Err(PyKeyError::new_err(what));
            };
            columns.extend(entry.scalars().into_iter().map(Growing::new));
            let count = topic.layout().scalars().into_iter().find(|place| place.path == "count");
            for record in self.0.records_of(&[topic]) {
                let message = record.bytes();
                let valid = match count.as_ref().map(|count| count.read(message)) {
                    Some(Value::Unsigned(count)) => usize::try_from(count).unwrap_or(len).min(len),
                    _ => len,
                };
                for entry in message[first..].chunks_exact(entry.bytes).take(valid) {
                    times.extend((record.log_time_ns as f64 / 1e9).to_le_bytes());
                    columns.iter_mut().for_each(|column| column.add(entry));
                }
            }
        } else {
            let in_a_list = |place: &Place| {
                let is_in = |&(_, first, entry, len): &(_, usize, &Layout, usize)| {
                    (first..first + entry.bytes * len).contains(&place.offset)
                };
                lists.iter().any(is_in)
            };
            let places = topic.layout().scalars().into_iter().filter(|place| !in_a_list(place));
            columns.extend(places.map(Growing::new));
            for record in self.0.records_of(&[topic]) {
                times.extend((record.log_time_ns as f64 / 1e9).to_le_bytes());
                columns.iter_mut().for_each(|column| column.add(record.bytes()));
            }
        }
        let own = columns
            .into_iter()
            .map(|column| (column.place.path, column.kind, PyBytes::new(py, &column.bytes)));
        let time = ("log_time_s".to_owned(), "<f8".to_owned(), PyBytes::new(py, &times));
        Ok(std::iter::once(time).chain(own).collect())
    }
}
