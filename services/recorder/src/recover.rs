//! Making a broken recording whole.

use crate::counter::Counter;
use crate::{Damage, Recording, Tally, Writer};
use mcap::McapError;
use std::io::{Seek, Write};

/// What a recovery found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recovered {
    /// What is in the new file, and what is missing between its first and last messages.
    pub tally: Tally,
    /// What could not be read of the old one.
    pub damage: Vec<Damage>,
}

/// Writes what is readable of `recording` to `file` as a whole recording.
///
/// # Errors
/// If `file` cannot be written.
pub fn recover<W: Write + Seek>(recording: &Recording, file: W) -> Result<Recovered, McapError> {
    let mut writer = Writer::begin(file, recording.metadata())?;
    let mut counter = Counter::default();
    for record in recording.records() {
        writer.message(record.topic, record.log_time_ns, record.bytes)?;
        counter.count(record.topic, record.bytes);
    }
    let tally = counter.tally();
    writer.finish(&tally)?;
    Ok(Recovered { tally, damage: recording.damage().to_vec() })
}
