//! State that outlives the process that holds it: what a restarted service goes on from.
//!
//! A file in shared memory has two slots that are written in turn, each with its number and a checksum. A process that
//! dies while it writes leaves the other slot whole. No allocation, and no system call per write. Such a call took 2 µs
//! at 1 kHz, and the services behind on the same core waited for it.

#![allow(unsafe_code, reason = "a struct of atomic numbers in shared memory")]

use crate::words::{Atomics, Shared, open_own};
use crate::{Group, RuntimeError};
use messages::Service;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Words of the longest state.
const WORDS: usize = 8 * 1024 - 3;

/// One of the two places of a state.
#[repr(C)]
#[derive(Debug)]
struct Slot {
    number: AtomicU64,
    length: AtomicU64,
    checksum: AtomicU64,
    state: [AtomicU64; WORDS],
}

// SAFETY: words alone.
unsafe impl Atomics for Slot {}

/// Shared memory that a service takes for it, bytes.
pub(crate) const MOST_BYTES: usize = 2 * size_of::<Slot>();

/// Name of the file in which a service of the run with this prefix keeps its state.
pub(crate) fn state_path(prefix: &str, service: Service) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.state"))
}

/// Keeps states of type `T`.
#[derive(Debug)]
pub struct Checkpoint<T> {
    slots: Shared<[Slot; 2]>,
    /// Number of the newest state.
    saved: u64,
    room: Box<[u64; WORDS]>,
    state: PhantomData<T>,
}

impl<T: DeserializeOwned> Checkpoint<T> {
    /// Opens the file at `path`, or makes it.
    pub(crate) fn open(path: &Path) -> Result<Self, RuntimeError> {
        let slots = open_own(path).and_then(|file| Shared::of(&file, 0));
        let slots = slots.map_err(RuntimeError::setup(path.display().to_string()))?;
        Ok(Self { slots, saved: 0, room: Box::new([0; WORDS]), state: PhantomData })
    }

    /// Opens the file at `path`; `None` if there is none.
    pub(crate) fn existing(path: &Path) -> Option<Self> {
        path.exists().then(|| Self::open(path).ok()).flatten()
    }

    /// The newest state that `service`, which is gone, kept in its run; `None` if it kept no state.
    pub fn last(group: &Group, service: Service) -> Option<T> {
        Self::existing(&state_path(&group.prefix, service))?.restore()
    }

    /// The newest state that was kept whole.
    pub fn restore(&mut self) -> Option<T> {
        let mut newest = None;
        let load = |word: &AtomicU64| word.load(Ordering::Relaxed);
        for slot in &*self.slots {
            let (number, length) = (load(&slot.number), load(&slot.length) as usize);
            if number <= self.saved || length > size_of_val(&*self.room) {
                continue;
            }
            for (room, word) in self.room.iter_mut().zip(&slot.state).take(length.div_ceil(8)) {
                *room = load(word);
            }
            let state = &bytemuck::bytes_of(&*self.room)[..length];
            // Also where another process is writing it: the number counts.
            if load(&slot.checksum) != xxh3_64_with_seed(state, number) {
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
    pub fn save(&mut self, state: &impl Serialize) -> Result<(), RuntimeError> {
        let used = postcard::to_slice(state, bytemuck::bytes_of_mut(&mut *self.room))
            .map_err(|e| RuntimeError::setup("the kept state")(io::Error::other(e)))?;
        self.saved += 1;
        let (length, checksum) = (used.len(), xxh3_64_with_seed(used, self.saved));
        let slot = &self.slots[(self.saved % 2) as usize];
        let head = [(&slot.number, self.saved), (&slot.length, length as u64)];
        let state = slot.state.iter().zip(self.room.iter().copied()).take(length.div_ceil(8));
        for (word, number) in head.into_iter().chain([(&slot.checksum, checksum)]).chain(state) {
            word.store(number, Ordering::Relaxed);
        }
        Ok(())
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
        file.write_all_at(&9_u64.to_le_bytes(), size_of::<Slot>() as u64).expect("ours");
        assert_eq!(open().restore(), None);
        std::fs::remove_file(&path).expect("ours");
    }
}
