//! Making a broken recording whole.

use crate::counter::Counter;
use crate::{Metadata, Recording, Survey, Writer};
use mcap::McapError;
use std::io::{self, Seek, Write};

/// Writes what is readable of `recording` to `file` as a whole recording. Returns the content of the new file, and the
/// damage of the old one.
///
/// # Errors
/// If `file` cannot be written.
pub fn recover<W: Write + Seek>(recording: &Recording, file: W) -> io::Result<Survey> {
    rewrite(recording, file).map_err(|error| match error {
        // The system's own reason: a full disk differs from a bad file.
        McapError::Io(reason) => reason,
        error => io::Error::other(error),
    })
}

fn rewrite<W: Write + Seek>(recording: &Recording, file: W) -> Result<Survey, McapError> {
    let metadata = recording.metadata();
    // An older recording gets today's log times.
    let metadata = Metadata { epoch_ns: metadata.started_unix_ns, ..metadata.clone() };
    let mut writer = Writer::begin(file, &metadata)?;
    let mut counter = Counter::default();
    let mut end_ns = 0;
    let mut records = recording.records();
    for record in records.by_ref() {
        writer.message(record.topic, record.log_time_ns, record.bytes())?;
        counter.count(record.topic, record.bytes());
        end_ns = end_ns.max(record.log_time_ns);
    }
    let tally = counter.tally();
    writer.finish(&tally)?;
    let damage = [recording.damage(), records.damage()].concat();
    Ok(Survey { tally, end_ns, damage })
}
