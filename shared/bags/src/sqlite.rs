//! ROS 2 bags that are SQLite databases (<https://github.com/ros2/rosbag2>, storage `sqlite3`).
//!
//! | table | columns that are read |
//! | --- | --- |
//! | `topics` | `id`, `name`, `type`, `serialization_format` |
//! | `messages` | `topic_id`, `timestamp`, `data` |
//! | `message_definitions`, since Iron | `topic_type`, `encoding`, `encoded_message_definition` |
//!
//! Bags of earlier releases carry no definitions. [`standard`](crate::standard) has those of common types.

use crate::sink::{Connection, Sink};
use crate::{BagError, Encoding, standard};
use rusqlite::types::ValueRef;
use rusqlite::{OpenFlags, Row};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// Longest message that is read, bytes.
const LONGEST_MESSAGE: u64 = 64 << 20;
/// First bytes of a message that Zstandard packed.
const ZSTANDARD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

impl From<rusqlite::Error> for BagError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Database(error.to_string())
    }
}

/// Hands topics and messages of the database at `path` to `sink`, by topic and time.
pub(crate) fn read(path: &Path, sink: &mut dyn Sink) -> Result<(), BagError> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database = rusqlite::Connection::open_with_flags(path, flags)?;
    // A view could run anything, and without an end.
    for table in ["topics", "messages"] {
        if !has_table(&database, table)? {
            return Err(BagError::Database(format!("no table `{table}`, as ROS 2 writes it")));
        }
    }
    let definitions = definitions(&database)?;
    let mut topics = database.prepare("SELECT id, name, type, serialization_format FROM topics")?;
    let mut rows = topics.query([])?;
    while let Some(row) = rows.next()? {
        let type_name = text(row, 2)?;
        let (language, definition) = match definitions.get(&type_name) {
            Some((language, definition)) => (language.as_str(), definition.clone()),
            None => ("ros2msg", standard::definition(&type_name)),
        };
        let encoding = match (text(row, 3)?.as_str(), language) {
            ("cdr", "ros2msg") => Encoding::Cdr,
            (other, language) => Encoding::Other(format!("{other}, {language}")),
        };
        sink.connection(Connection {
            id: id(row, 0)?,
            topic: &text(row, 1)?,
            type_name: &type_name,
            definition: &definition,
            encoding,
        });
    }
    let mut messages = database.prepare("SELECT topic_id, timestamp, data FROM messages")?;
    let mut rows = messages.query([])?;
    while let Some(row) = rows.next()? {
        let time_ns = u64::try_from(row.get::<_, i64>(1)?).map_err(|_| BagError::Malformed)?;
        let ValueRef::Blob(bytes) = row.get_ref(2)? else { return Err(BagError::Malformed) };
        sink.message(id(row, 0)?, time_ns, &unpacked(bytes)?)?;
    }
    Ok(())
}

fn has_table(database: &rusqlite::Connection, name: &str) -> Result<bool, BagError> {
    let question = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ?1";
    Ok(database.query_row(question, [name], |row| row.get::<_, i64>(0))? > 0)
}

/// Languages and texts of the definitions that the bag carries, by type.
fn definitions(
    database: &rusqlite::Connection,
) -> Result<BTreeMap<String, (String, String)>, BagError> {
    let mut definitions = BTreeMap::new();
    if !has_table(database, "message_definitions")? {
        return Ok(definitions);
    }
    let question =
        "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions";
    let mut found = database.prepare(question)?;
    let mut rows = found.query([])?;
    while let Some(row) = rows.next()? {
        let definition = text(row, 2)?;
        // A recorder that does not find a definition leaves an empty one.
        if !definition.is_empty() {
            definitions.insert(text(row, 0)?, (text(row, 1)?, definition));
        }
    }
    Ok(definitions)
}

fn text(row: &Row<'_>, column: usize) -> Result<String, BagError> {
    match row.get_ref(column)? {
        ValueRef::Text(bytes) => Ok(String::from_utf8_lossy(bytes).into_owned()),
        _ => Err(BagError::Malformed),
    }
}

fn id(row: &Row<'_>, column: usize) -> Result<u32, BagError> {
    u32::try_from(row.get::<_, i64>(column)?).map_err(|_| BagError::Malformed)
}

/// A message's bytes, out of their compression where a recorder packed each message.
fn unpacked(bytes: &[u8]) -> Result<Cow<'_, [u8]>, BagError> {
    if !bytes.starts_with(&ZSTANDARD) {
        return Ok(Cow::Borrowed(bytes));
    }
    let damaged = |error: &dyn std::error::Error| BagError::Chunk(error.to_string());
    let decoder =
        ruzstd::decoding::StreamingDecoder::new(bytes).map_err(|error| damaged(&error))?;
    let mut message = Vec::new();
    decoder.take(LONGEST_MESSAGE).read_to_end(&mut message).map_err(|error| damaged(&error))?;
    Ok(Cow::Owned(message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{series, topics};

    /// A bag as `ros2 bag record` lays it out, in a file of its own. The caller removes it.
    struct Bag(std::path::PathBuf);

    impl Bag {
        fn new(name: &str, script: &str, messages: &[(i64, i64, Vec<u8>)]) -> Self {
            let name = format!("timegap-bag-{}-{name}.db3", std::process::id());
            let bag = Self(std::env::temp_dir().join(name));
            let database = rusqlite::Connection::open(&bag.0).expect("a new database");
            let tables = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
                CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
                timestamp INTEGER NOT NULL, data BLOB NOT NULL);";
            database.execute_batch(&format!("{tables}{script}")).expect("right SQL");
            for (topic, time_ns, data) in messages {
                let row = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
                database.execute(row, (topic, time_ns, data)).expect("a row");
            }
            bag
        }
    }

    impl Drop for Bag {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(&self.0);
        }
    }

    fn float(value: f64) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat()
    }

    const SPEED: &str =
        "INSERT INTO topics VALUES (3, '/speed', 'std_msgs/msg/Float64', 'cdr', '');";

    #[test]
    fn a_bag_of_an_early_release_is_read_by_the_standard_definitions() {
        let messages = [(3, 2_000_000_000, float(5.0)), (3, 1_000_000_000, float(4.5))];
        let bag = Bag::new("early", SPEED, &messages);
        let read = series(&bag.0, "/speed", &["data".into()]).expect("a right bag");
        assert_eq!(read.type_name, "std_msgs/msg/Float64");
        let rows: Vec<_> = read.rows.iter().map(|row| (row.log_time_s(), row.values[0])).collect();
        assert_eq!(rows, [(1.0, 4.5), (2.0, 5.0)]);
        let listed = topics(&bag.0).expect("a right bag");
        assert_eq!(
            (listed[0].messages, listed[0].fields.as_slice()),
            (2, &["data".to_owned()][..])
        );
    }

    #[test]
    fn a_definition_in_the_bag_counts_before_the_standard_one() {
        let script = format!(
            "{SPEED} CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT,
            encoding TEXT, encoded_message_definition TEXT, type_description_hash TEXT);
            INSERT INTO message_definitions VALUES (1, 'std_msgs/msg/Float64', 'ros2msg',
            'float64 value', '');"
        );
        let bag = Bag::new("iron", &script, &[(3, 0, float(7.0))]);
        let read = series(&bag.0, "/speed", &["value".into()]).expect("a right bag");
        assert_eq!(read.rows[0].values, [7.0]);
        let missing = series(&bag.0, "/fast", &["value".into()]).expect_err("no such topic");
        assert_eq!(missing.to_string(), "no topic `/fast`, expected one of `/speed`");
    }

    #[test]
    fn other_databases_and_damaged_ones_are_refused() {
        let bag = Bag::new("damaged", SPEED, &[(3, 0, float(7.0)), (-1, 0, float(7.0))]);
        let fields = ["data".into()];
        assert!(matches!(series(&bag.0, "/speed", &fields), Err(BagError::Malformed)));
        let bytes = std::fs::read(&bag.0).expect("the bag");
        std::fs::write(&bag.0, &bytes[..5000]).expect("room");
        assert!(matches!(series(&bag.0, "/speed", &fields), Err(BagError::Database(_))));
        let other =
            Bag::new("other", "DROP TABLE messages; CREATE VIEW messages AS SELECT 1;", &[]);
        let said = series(&other.0, "/speed", &fields).expect_err("no bag").to_string();
        assert!(said.contains("no table `messages`"), "{said}");
    }
}
