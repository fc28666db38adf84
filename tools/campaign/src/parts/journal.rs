//! The journal of a study: one line of JSON per finished run, handed to the system at once, so that
//! it survives the end of this process, and brought to the disk a few times a second. A line that a
//! crash cut off is dropped; its run is done again.

use group::{Error, Failure};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Name of the journal in a directory of results.
pub const FILE: &str = "runs.jsonl";

/// Runs are short: waiting for the disk after each would take longer than they do. So much of them
/// can be lost with the machine.
const SYNC_PERIOD: Duration = Duration::from_millis(200);

/// Why a journal is not one of the study's.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// A line of it cannot be read.
    #[error("{}:{line}: {reason}, expected the record of a run", path.display())]
    NoRecord {
        /// The journal.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        reason: serde_json::Error,
    },
    /// It has a run twice.
    #[error("{}: run {run} is there twice", path.display())]
    Twice {
        /// The journal.
        path: PathBuf,
        /// The run's number.
        run: usize,
    },
    /// It has a run of another part.
    #[error("{}: run {run} does not belong to this part", path.display())]
    OtherPart {
        /// The journal.
        path: PathBuf,
        /// The run's number.
        run: usize,
    },
}

impl Failure for JournalError {}

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    synced: Instant,
}

impl Journal {
    /// Opens the journal in `directory`, or begins one, and reads what is in it.
    pub fn open<T: DeserializeOwned>(directory: &Path) -> Result<(Self, Vec<T>), Error> {
        let path = directory.join(FILE);
        let error = |reason| Error::Path { action: "write", path: path.clone(), reason };
        let (records, length) = if path.exists() { read(&path)? } else { (Vec::new(), 0) };
        let file = OpenOptions::new().create(true).append(true).open(&path).map_err(error)?;
        file.set_len(length).map_err(error)?;
        Ok((Self { path, file, synced: Instant::now() }, records))
    }

    /// Adds a record.
    ///
    /// # Errors
    /// [`Error::Path`] if it cannot be written.
    pub fn add(&mut self, record: &impl Serialize) -> Result<(), Error> {
        let line = serde_json::to_string(record).expect("records are plain data") + "\n";
        let mut written = self.file.write_all(line.as_bytes());
        if self.synced.elapsed() >= SYNC_PERIOD {
            written = written.and_then(|()| self.file.sync_data());
            self.synced = Instant::now();
        }
        let path = || self.path.clone();
        written.map_err(|reason| Error::Path { action: "write", path: path(), reason })
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        // What fails here was written, and is only less sure to survive the machine.
        let _ = self.file.sync_data();
    }
}

/// A record as its journal gives it back. A number may differ in its last digit from the one that was
/// written: what is kept of a run is this, so that a study gives the same bytes in any number of parts.
pub fn as_read_back<T: Serialize + DeserializeOwned>(record: &T) -> T {
    let line = serde_json::to_string(record).expect("records are plain data");
    serde_json::from_str(&line).expect("what was written can be read")
}

/// The records of a journal, and the length of its whole lines, bytes.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<(Vec<T>, u64), Error> {
    let error = |reason| Error::Path { action: "read", path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(error)?;
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let mut records = Vec::new();
    for (number, line) in text[..whole].lines().enumerate() {
        let record = serde_json::from_str(line).map_err(|reason| {
            let path = path.to_owned();
            JournalError::NoRecord { path, line: number + 1, reason }
        })?;
        records.push(record);
    }
    Ok((records, whole as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directory(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("journal-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary directory is writable");
        path
    }

    #[test]
    fn records_survive_and_a_torn_line_does_not() {
        let directory = directory("torn");
        let (mut journal, records) = Journal::open::<u32>(&directory).expect("new");
        assert!(records.is_empty());
        journal.add(&1).and_then(|()| journal.add(&22)).expect("writable");
        drop(journal);
        let path = directory.join(FILE);
        let mut text = std::fs::read_to_string(&path).expect("written");
        text.push_str("33");
        std::fs::write(&path, text).expect("ours");
        let (mut journal, records) = Journal::open::<u32>(&directory).expect("readable");
        assert_eq!(records, [1, 22]);
        journal.add(&4).expect("writable");
        assert_eq!(read::<u32>(&path).expect("readable").0, [1, 22, 4]);
        std::fs::remove_dir_all(&directory).expect("ours");
    }

    #[test]
    fn a_line_that_is_no_record_is_shown_with_its_number() {
        let directory = directory("alien");
        std::fs::write(directory.join(FILE), "1\nx\n").expect("ours");
        let said = Journal::open::<u32>(&directory).expect_err("not a journal").to_string();
        assert!(said.contains("runs.jsonl:2"), "{said}");
        std::fs::remove_dir_all(&directory).expect("ours");
    }
}
