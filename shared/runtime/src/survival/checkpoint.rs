//! State that outlives the process that holds it: what a restarted service goes on from.
//!
//! A file in shared memory has two slots that are written in turn, each with its number and a checksum. A process that
//! dies while it writes leaves the other slot whole. No allocation, and no system call per write. Such a call took 2 µs
//! at 1 kHz, and the services behind on the same core waited for it.

use crate::words::open_own;
use crate::words::{PAGE_BYTES, SharedWords};
use crate::{Group, RuntimeError};
use messages::Service;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Bytes of a slot: number, length, checksum of number and state, state.
const SLOT: usize = 64 * 1024;
const HEAD: usize = 24;
const WORD: usize = 4;
/// Shared memory that a service takes for it, bytes.
pub(crate) const MOST_BYTES: usize = 2 * SLOT;

/// Name of the file in which a service of the run with this prefix keeps its state.
pub(crate) fn state_path(prefix: &str, service: Service) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.state"))
}

/// Keeps states of type `T`.
#[derive(Debug)]
pub struct Checkpoint<T> {
    words: SharedWords,
    saved: u64,
    slot: Box<[u8; SLOT]>,
    state: std::marker::PhantomData<T>,
}

impl<T: DeserializeOwned> Checkpoint<T> {
    /// Opens the file at `path`, or makes it.
    pub(crate) fn open(path: &Path) -> Result<Self, RuntimeError> {
        let words =
            open_own(path).and_then(|file| SharedWords::of(&file, 0, MOST_BYTES / PAGE_BYTES));
        let words = words.map_err(RuntimeError::setup(path.display().to_string()))?;
        Ok(Self { words, saved: 0, slot: Box::new([0; SLOT]), state: std::marker::PhantomData })
    }

    /// The newest state that `service`, which is gone, kept in its run; `None` if it kept no state.
    #[must_use]
    pub fn last(group: &Group, service: Service) -> Option<T> {
        let path = state_path(&group.prefix, service);
        if !path.exists() {
            return None;
        }
        Self::open(&path).ok()?.restore()
    }

    /// The newest state that was kept whole.
    pub fn restore(&mut self) -> Option<T> {
        let mut newest = None;
        for place in 0..2 {
            self.read(place, 0..HEAD);
            let word = |at: usize| {
                let bytes = self.slot[at..at + 8].try_into().expect("eight bytes");
                u64::from_le_bytes(bytes)
            };
            let (number, length, checksum) = (word(0), word(8), word(16));
            let Ok(length) = usize::try_from(length) else { continue };
            if number <= self.saved || length > SLOT - HEAD {
                continue;
            }
            self.read(place, HEAD..HEAD + length);
            let state = &self.slot[HEAD..HEAD + length];
            // Also where another process is writing it: the number counts.
            if checksum != xxh3_64_with_seed(state, number) {
                continue;
            }
            if let Ok(state) = postcard::from_bytes(state) {
                self.saved = number;
                newest = Some(state);
            }
        }
        newest
    }

    /// Keeps `state`, which has the form of a `T`.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if it does not fit.
    pub fn save(&mut self, state: &impl Serialize) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Setup { what: "the kept state".into(), reason };
        let used = postcard::to_slice(state, &mut self.slot[HEAD..])
            .map_err(|e| error(io::Error::other(e)))?
            .len();
        self.saved += 1;
        let checksum = xxh3_64_with_seed(&self.slot[HEAD..HEAD + used], self.saved);
        self.slot[..8].copy_from_slice(&self.saved.to_le_bytes());
        self.slot[8..16].copy_from_slice(&(used as u64).to_le_bytes());
        self.slot[16..24].copy_from_slice(&checksum.to_le_bytes());
        self.write((self.saved % 2) as usize, HEAD + used);
        Ok(())
    }

    /// Takes whole words of a slot, those that hold `bytes`.
    fn read(&mut self, place: usize, bytes: Range<usize>) {
        let words = bytes.start / WORD..bytes.end.div_ceil(WORD);
        let room = self.slot.chunks_exact_mut(WORD).enumerate().take(words.end);
        for (index, room) in room.skip(words.start) {
            let word = self.words.word(place * SLOT / WORD + index);
            room.copy_from_slice(&word.load(Ordering::Relaxed).to_ne_bytes());
        }
    }

    /// Writes whole words of a slot, those that hold its first `bytes`.
    fn write(&self, place: usize, bytes: usize) {
        let used = self.slot.chunks_exact(WORD).take(bytes.div_ceil(WORD));
        for (index, bytes) in used.enumerate() {
            let word = u32::from_ne_bytes(bytes.try_into().expect("four bytes"));
            self.words.word(place * SLOT / WORD + index).store(word, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::os::unix::fs::FileExt;

    #[test]
    fn the_newest_whole_state_is_restored() {
        let path = std::env::temp_dir().join(format!("timegap-checkpoint-{}", std::process::id()));
        let open = || Checkpoint::<(u64, Option<f64>)>::open(&path).expect("writable");
        assert_eq!(open().restore(), None);
        let mut checkpoint = open();
        for k in 0..5_u64 {
            checkpoint.save(&(k, Some(0.1))).expect("it fits");
        }
        let mut restored = open();
        assert_eq!(restored.restore(), Some((4, Some(0.1))));
        restored.save(&(5_u64, None::<f64>)).expect("it fits");
        assert_eq!(open().restore(), Some((5, None)));
        // The newest slot is the one that a dying process was writing.
        let file = File::options().write(true).open(&path).expect("ours");
        file.write_all_at(&[0xff; 40], 0).expect("ours");
        assert_eq!(open().restore(), Some((4, Some(0.1))));
        // A later number before an earlier state: it died after the first word.
        file.write_all_at(&9_u64.to_le_bytes(), SLOT as u64).expect("ours");
        assert_eq!(open().restore(), None);
        std::fs::remove_file(&path).expect("ours");
    }
}
