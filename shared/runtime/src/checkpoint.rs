//! State that outlives the process that holds it: what a restarted service goes on from.
//!
//! A file in shared memory with two slots that are written in turn, each with its number and a
//! checksum: a process that dies while it writes leaves the other slot whole. One system call per
//! write, no allocation.

use super::own_file::open_own;
use super::{Group, RuntimeError};
use messages::Service;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

/// Bytes of a slot: number, length, checksum, state.
const SLOT: usize = 64 * 1024;
const HEAD: usize = 24;

/// Where a service of the run with this prefix keeps its state.
pub(super) fn state_path(prefix: &str, service: Service) -> PathBuf {
    Path::new("/dev/shm").join(format!("{prefix}{service}.state"))
}

/// Keeps states of type `T`.
#[derive(Debug)]
pub struct Checkpoint<T> {
    file: File,
    saved: u64,
    slot: Box<[u8; SLOT]>,
    state: std::marker::PhantomData<T>,
}

impl<T: DeserializeOwned> Checkpoint<T> {
    /// Opens the file at `path`, or makes it.
    pub(super) fn open(path: &Path) -> Result<Self, RuntimeError> {
        let whole = |file: File| {
            // All pages are there before the loop needs them.
            file.set_len(2 * SLOT as u64).map(|()| file)
        };
        let file = open_own(path).and_then(whole);
        let file = file.map_err(RuntimeError::setup(path.display().to_string()))?;
        Ok(Self { file, saved: 0, slot: Box::new([0; SLOT]), state: std::marker::PhantomData })
    }

    /// The newest state that `service`, which is gone, kept in its run; `None` if it kept none.
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
            if self.file.read_exact_at(&mut self.slot[..], place * SLOT as u64).is_err() {
                continue;
            }
            let word = |at: usize| {
                let bytes = self.slot[at..at + 8].try_into().expect("eight bytes");
                u64::from_le_bytes(bytes)
            };
            let (number, length, checksum) = (word(0), word(8), word(16));
            let Ok(length) = usize::try_from(length) else { continue };
            if number <= self.saved || length > SLOT - HEAD {
                continue;
            }
            let state = &self.slot[HEAD..HEAD + length];
            if checksum != xxh3_64(state) {
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
    /// [`RuntimeError::Setup`] if it does not fit, or the file cannot be written.
    pub fn save(&mut self, state: &impl Serialize) -> Result<(), RuntimeError> {
        let error = |reason| RuntimeError::Setup { what: "the kept state".into(), reason };
        let used = postcard::to_slice(state, &mut self.slot[HEAD..])
            .map_err(|e| error(io::Error::other(e)))?
            .len();
        self.saved += 1;
        let checksum = xxh3_64(&self.slot[HEAD..HEAD + used]);
        self.slot[..8].copy_from_slice(&self.saved.to_le_bytes());
        self.slot[8..16].copy_from_slice(&(used as u64).to_le_bytes());
        self.slot[16..24].copy_from_slice(&checksum.to_le_bytes());
        let place = (self.saved % 2) * SLOT as u64;
        self.file.write_all_at(&self.slot[..HEAD + used], place).map_err(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        std::fs::remove_file(&path).expect("ours");
    }
}
