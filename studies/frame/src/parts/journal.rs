//! The journal of a study: one line of JSON per finished run.
//!
//! A line is handed to the system at once, so that it survives the end of this process. It is brought to the disk a
//! few times a second. A line that a crash cut off is dropped; its run is done again. The last key of a line is a
//! checksum of the rest. Otherwise a flipped digit would pass as a result.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use supervise::{Error, UsageError};
use xxhash_rust::xxh3::xxh3_64;

/// Name of the journal in a directory of results.
pub const FILE: &str = "runs.jsonl";

/// Longest time of which the runs can be lost with the machine. Waiting for the disk after each run would take longer
/// than the run.
const SYNC_PERIOD: Duration = Duration::from_millis(200);

/// Place of a record in its journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Start of its line, bytes from the beginning of the journal.
    pub offset: u64,
    /// Length of the line with its end, bytes.
    pub length: usize,
}

#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Bytes written.
    length: u64,
    synced: Instant,
}

impl Journal {
    /// Opens the journal `name` in `directory`, or begins one, and hands over its records.
    pub fn open<T: DeserializeOwned>(
        directory: &Path,
        name: &str,
        each: &mut dyn FnMut(Place, T) -> Result<(), Error>,
    ) -> Result<Self, Error> {
        let path = directory.join(name);
        let error = Error::path("write", &path);
        let length = if path.exists() { read(&path, each)? } else { 0 };
        let file = OpenOptions::new().create(true).append(true).open(&path).map_err(error)?;
        file.set_len(length).map_err(error)?;
        Ok(Self { path, file, length, synced: Instant::now() })
    }

    pub fn add(&mut self, record: &impl Serialize) -> Result<Place, Error> {
        let line = sealed(serde_json::to_string(record).expect("records are plain data")) + "\n";
        let mut written = self.file.write_all(line.as_bytes());
        if self.synced.elapsed() >= SYNC_PERIOD {
            written = written.and_then(|()| self.file.sync_data());
            self.synced = Instant::now();
        }
        written.map_err(Error::path("write", &self.path))?;
        let place = Place { offset: self.length, length: line.len() };
        self.length += line.len() as u64;
        Ok(place)
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        // The lines are written; without this they are only less sure to survive the machine.
        let _ = self.file.sync_data();
    }
}

/// Text before a line's checksum, which has 16 digits, and text behind it.
const BEFORE_CHECKSUM: &str = ",\"xxh3\":\"";
const BEHIND_CHECKSUM: &str = "\"}";

/// A record, an object, with its checksum.
fn sealed(record: String) -> String {
    let checksum = xxh3_64(record.as_bytes());
    match record.strip_suffix('}') {
        Some(open) => format!("{open}{BEFORE_CHECKSUM}{checksum:016x}{BEHIND_CHECKSUM}"),
        None => record,
    }
}

/// The line of a journal, if its checksum is right. A line of version 0.1 has no checksum.
fn unsealed(line: &[u8]) -> serde_json::Result<&[u8]> {
    let text = line.trim_ascii_end().strip_suffix(BEHIND_CHECKSUM.as_bytes());
    let split = text.and_then(|text| text.split_at_checked(text.len().checked_sub(16)?));
    let Some((record, checksum)) = split else { return Ok(line) };
    let Some(record) = record.strip_suffix(BEFORE_CHECKSUM.as_bytes()) else { return Ok(line) };
    let found = format!("{:016x}", xxh3_64(&[record, b"}"].concat()));
    if found.as_bytes() == checksum {
        Ok(line)
    } else {
        Err(serde::de::Error::custom("its checksum is wrong"))
    }
}

/// Hands over the records of a journal, line by line; returns the length of its whole lines, bytes.
pub fn read<T: DeserializeOwned>(
    path: &Path,
    each: &mut dyn FnMut(Place, T) -> Result<(), Error>,
) -> Result<u64, Error> {
    let error = Error::path("read", path);
    let mut lines = BufReader::new(File::open(path).map_err(error)?);
    let (mut offset, mut line) = (0, Vec::new());
    for number in 1.. {
        line.clear();
        let length = lines.read_until(b'\n', &mut line).map_err(error)?;
        if !line.ends_with(b"\n") {
            break;
        }
        let record = unsealed(&line).and_then(serde_json::from_slice).map_err(|reason| {
            let place = format_args!("{}:{number}", path.display());
            UsageError::at(place, reason, "the record of a run")
        })?;
        each(Place { offset, length }, record)?;
        offset += length as u64;
    }
    Ok(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directory(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("journal-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary directory is writable");
        path
    }

    /// Opens a journal of numbers, with those that are in it.
    fn open(directory: &Path) -> Result<(Journal, Vec<u32>), Error> {
        let mut records = Vec::new();
        let journal = Journal::open(directory, FILE, &mut |_, record| {
            records.push(record);
            Ok(())
        })?;
        Ok((journal, records))
    }

    #[test]
    fn records_survive_and_a_torn_line_does_not() {
        let directory = directory("torn");
        let (mut journal, records) = open(&directory).expect("new");
        assert!(records.is_empty());
        journal.add(&1).and_then(|_| journal.add(&22)).expect("writable");
        drop(journal);
        let path = directory.join(FILE);
        let mut text = std::fs::read_to_string(&path).expect("written");
        text.push_str("33");
        std::fs::write(&path, text).expect("ours");
        let (mut journal, records) = open(&directory).expect("readable");
        assert_eq!(records, [1, 22]);
        assert_eq!(journal.add(&4).expect("writable"), Place { offset: 5, length: 2 });
        assert_eq!(open(&directory).expect("readable").1, [1, 22, 4]);
        std::fs::remove_dir_all(&directory).expect("ours");
    }

    #[test]
    fn a_line_with_any_other_byte_is_no_record() {
        let record = serde_json::json!({"run": 17, "gap_m": 1.25, "why": "\"}"});
        let line = sealed(record.to_string());
        assert_eq!(unsealed(line.as_bytes()).expect("it is right"), line.as_bytes());
        let digits = line.len() - BEHIND_CHECKSUM.len() - 16;
        for at in 0..digits - BEFORE_CHECKSUM.len() {
            let mut other = line.clone().into_bytes();
            other[at] ^= 1;
            assert!(unsealed(&other).is_err(), "byte {at}");
        }
        let before = record.to_string();
        assert_eq!(unsealed(before.as_bytes()).expect("no checksum"), before.as_bytes());
    }

    #[test]
    fn a_line_that_is_no_record_is_shown_with_its_number() {
        let directory = directory("alien");
        std::fs::write(directory.join(FILE), "1\nx\n").expect("ours");
        let said = open(&directory).expect_err("not a journal").to_string();
        assert!(said.contains("runs.jsonl:2"), "{said}");
        std::fs::remove_dir_all(&directory).expect("ours");
    }
}
