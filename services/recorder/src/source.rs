//! The bytes of a recording, a piece at a time.

use bags::mcap::{self as format, HEAD};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::sync::Arc;

/// Bytes that a reader of everything reads ahead, and one that skips most.
const AHEAD: usize = 64 * 1024;
const AHEAD_OF_HEADS: usize = 4 * 1024;

#[derive(Clone, Debug)]
enum Place {
    File(Arc<File>),
    Memory(Arc<[u8]>),
}

/// A recording's bytes. Copies read the same file, each at its own place.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    place: Place,
    /// Bytes of the whole, as they were when it was opened.
    pub(crate) length: u64,
}

impl Source {
    pub(crate) fn of_file(file: File) -> io::Result<Self> {
        let length = file.metadata()?.len();
        Ok(Self { place: Place::File(Arc::new(file)), length })
    }

    pub(crate) fn of_bytes(bytes: &[u8]) -> Self {
        Self { place: Place::Memory(bytes.into()), length: bytes.len() as u64 }
    }

    fn read_at(&self, at: u64, into: &mut [u8]) -> io::Result<()> {
        match &self.place {
            Place::File(file) => file.read_exact_at(into, at),
            Place::Memory(bytes) => {
                let at = usize::try_from(at).map_err(|_| io::ErrorKind::UnexpectedEof)?;
                let piece = bytes.get(at..).and_then(|rest| rest.get(..into.len()));
                into.copy_from_slice(piece.ok_or(io::ErrorKind::UnexpectedEof)?);
                Ok(())
            }
        }
    }
}

/// A record's place in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Spot {
    pub(crate) opcode: u8,
    /// Start of its head.
    pub(crate) at: u64,
    pub(crate) length: u64,
}

impl Spot {
    pub(crate) fn body(&self) -> u64 {
        self.at + HEAD as u64
    }

    /// Start of the next record.
    pub(crate) fn end(&self) -> u64 {
        self.body() + self.length
    }
}

/// Reads pieces of a source, mostly forward.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    source: Source,
    buffer: Vec<u8>,
    at: u64,
    ahead: usize,
}

impl Window {
    pub(crate) fn new(source: &Source) -> Self {
        Self { source: source.clone(), buffer: Vec::new(), at: 0, ahead: AHEAD }
    }

    /// Opens it for a reader that passes over most of the file.
    pub(crate) fn of_heads(source: &Source) -> Self {
        Self { ahead: AHEAD_OF_HEADS, ..Self::new(source) }
    }

    /// The `count` bytes at `at`, which must be in the file: the caller bounds both.
    pub(crate) fn bytes(&mut self, at: u64, count: usize) -> io::Result<&[u8]> {
        let end = at + count as u64;
        let held = self.at..self.at + self.buffer.len() as u64;
        if at < held.start || end > held.end {
            if end > self.source.length {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            let left = usize::try_from(self.source.length - at).unwrap_or(usize::MAX);
            self.buffer.clear();
            self.buffer.resize(count.max(self.ahead).min(left), 0);
            self.at = at;
            self.source.read_at(at, &mut self.buffer)?;
        }
        let start = usize::try_from(at - self.at).expect("within the buffer");
        Ok(&self.buffer[start..start + count])
    }

    /// The record at `at`; `None` where no whole record begins.
    pub(crate) fn spot(&mut self, at: u64) -> io::Result<Option<Spot>> {
        let left = self.source.length.saturating_sub(at);
        if left < HEAD as u64 {
            return Ok(None);
        }
        let (opcode, length) =
            format::head(self.bytes(at, HEAD)?.try_into().expect("a whole head"));
        let fits = length <= left - HEAD as u64;
        Ok((fits && opcode != 0).then_some(Spot { opcode, at, length }))
    }
}
